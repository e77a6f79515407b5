#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <absl/status/statusor.h>
#include <nlohmann/json_fwd.hpp>

#include "common/base/sha256.h"
#include "common/geometry/comparison/metrics.h"
#include "common/geometry/registration/scaling_icp.h"
#include "common/geometry/registration/undersampling.h"

namespace cohort {

/// What the meshes are aligned to before all pairs are measured.
enum class Method {
  kAverage,  ///< The mean shape, built in `rounds` rounds from the base mesh.
  kOne,      ///< The base mesh.
  kEach,     ///< Every mesh: the pair (source, target) is measured after aligning source to target.
  kNone,     ///< Nothing: the meshes are measured where they are.
};

/// How a mesh is brought near the reference before ICP.
enum class PoseMode {
  kPrincipalAxes,
  kNone,
  kLandmarks,  ///< Procrustes fit of the mesh's landmarks to those of the base mesh.
};

/// Which mesh is the first reference.
enum class BaseRule {
  kGiven,  ///< JobSpec::base.
  kAuto,   ///< The one with the least sum of distances to the others, in a cheap pre-pass.
};

/// What is kept of the distances of every directed pair, besides its metrics.
enum class Retention {
  kVectors,  ///< All, bit by bit: 3.2 bytes a vertex.
  kCompact,  ///< All, to 1 um: 1.5 bytes a vertex.
  kSketch,   ///< Totals and a histogram: 0.5 KB.
  kMetrics,  ///< Nothing: the 7 metrics, 56 bytes.
  kAuto,     ///< The richest that fits JobSpec::retention_budget.
};

/// Whose numbers a job computes.
enum class Arithmetic {
  kExact,  ///< Ours.
  /// The predecessor's, FIDENTIS Analyst of 2016, with its defects: float32, summed in the order of
  /// the file. Takes few of the options; ValidateFidentis names the others.
  kFidentis,
};

/// How the distances of a pair are measured.
struct CompareOptions {
  Correspondence correspondence = Correspondence::kVertex;
  BoundaryPairs boundary_pairs = BoundaryPairs::kKeep;
  Retention retention = Retention::kAuto;       ///< In a task never kAuto.
  DistanceSign sign = DistanceSign::kAbsolute;  ///< kSigned only with Arithmetic::kFidentis.
  friend bool operator==(const CompareOptions&, const CompareOptions&) = default;
};

/// How the two directed values of a pair become one.
enum class Symmetrization {
  kMean,      ///< (m_ij + m_ji) / 2, as the predecessor.
  kMax,       ///< max(m_ij, m_ji); of the metric "max" this is the Hausdorff distance.
  kDirected,  ///< Left as they are: row = source (its vertices are measured), column = target.
};

/// Everything that determines the numbers of a job, apart from its meshes.
struct JobSpec {
  Arithmetic arithmetic = Arithmetic::kExact;
  Method method = Method::kAverage;
  BaseRule base_rule = BaseRule::kGiven;
  std::string base;  ///< Mesh name of the first reference; empty: the first usable mesh by name.
  int rounds = 3;    ///< M, updates of the mean shape (method average), 1..100.
  /// No further rounds once a round moved the mean shape by no more than this (RMS over its
  /// vertices, mesh units). 0: all rounds run.
  double mean_tolerance = 0;
  PoseMode pose = PoseMode::kPrincipalAxes;
  Digest landmarks;  ///< Landmark blob with the meshes of the job, for PoseMode::kLandmarks.
  /// Each mesh is replaced by its symmetric copy (MakeSymmetric), in this job only.
  bool symmetric_copies = false;
  IcpOptions icp;
  UndersamplingOptions undersampling;  ///< Of the moving meshes, in every alignment.
  CompareOptions compare;
  int64_t retention_budget = int64_t{2} << 30;  ///< Bytes for Retention::kAuto.
  /// Before the comparison, a matrix of what correspondences over the last reference tell.
  bool preview = false;
  /// Jobs of a higher one are served first; no part of what the results are. Within +-100.
  int priority = 0;
  /// A job of the same server whose frame, options and pairs this one keeps; empty: none.
  std::string reference_job;
  /// Computes everything, also what is known from earlier jobs.
  bool fresh = false;
  Metric metric = Metric::kRms;
  Symmetrization symmetrization = Symmetrization::kMean;
  int neighbours = 3;  ///< Most similar faces listed per face, >= 1.
  /// Draco quantisation of the canonical meshes, 8..30; with kFidentis 0: as in the file.
  int position_bits = 18;
  /// Meshes more than this many times larger or smaller than the median one (RMS radius) are taken
  /// for another unit of length and the job is refused. 0: not checked.
  double size_ratio_limit = 5;

  /// @return kInvalidArgument naming the field, its value and what was expected.
  [[nodiscard]] absl::Status Validate() const;
};

/// "default"; "thesis" (I = 10 per round, e = 0.05, M = 3, least-squares scale, plain ICP; for one
/// and each I = 40, as the thesis's tables use); "fidentis" (FidentisSpec). `method` is set too.
/// @return kInvalidArgument listing the presets.
[[nodiscard]] absl::StatusOr<JobSpec> PresetSpec(std::string_view preset, Method method);

[[nodiscard]] std::string_view MethodName(Method method);  ///< "average", "one", "each", "none".
[[nodiscard]] std::optional<Method> MethodFromName(std::string_view name);
[[nodiscard]] std::string_view PoseModeName(
    PoseMode pose);  ///< "principal-axes", "none", "landmarks".
[[nodiscard]] std::optional<PoseMode> PoseModeFromName(std::string_view name);
[[nodiscard]] std::string_view SymmetrizationName(
    Symmetrization value);  ///< "mean", "max", "directed".
[[nodiscard]] std::optional<Symmetrization> SymmetrizationFromName(std::string_view name);

[[nodiscard]] std::string_view ArithmeticName(Arithmetic value);  ///< "exact", "fidentis".
[[nodiscard]] std::optional<Arithmetic> ArithmeticFromName(std::string_view name);
[[nodiscard]] std::string_view DistanceSignName(DistanceSign value);  ///< "absolute", "signed".
[[nodiscard]] std::optional<DistanceSign> DistanceSignFromName(std::string_view name);
[[nodiscard]] std::string_view BaseRuleName(BaseRule rule);  ///< "given", "auto".
/// "vectors", "compact", "sketch", "metrics", "auto".
[[nodiscard]] std::string_view RetentionName(Retention retention);
[[nodiscard]] std::optional<Retention> RetentionFromName(std::string_view name);
[[nodiscard]] std::string_view CorrespondenceName(Correspondence value);  ///< "vertex", "surface".
[[nodiscard]] std::optional<Correspondence> CorrespondenceFromName(std::string_view name);
[[nodiscard]] std::string_view BoundaryPairsName(BoundaryPairs value);  ///< "keep", "reject".
[[nodiscard]] std::optional<BoundaryPairs> BoundaryPairsFromName(std::string_view name);
[[nodiscard]] std::string_view AccelerationName(Acceleration value);  ///< "none", "anderson".
[[nodiscard]] std::optional<Acceleration> AccelerationFromName(std::string_view name);
/// "none", "random", "disk", "curvature".
[[nodiscard]] std::string_view UndersamplingName(UndersamplingMethod method);
[[nodiscard]] std::optional<UndersamplingMethod> UndersamplingFromName(std::string_view name);

/// As kept in the catalog and shown in job.json.
[[nodiscard]] nlohmann::json ToJson(const JobSpec& spec);
/// @return kInvalidArgument naming the field. Missing fields take their defaults.
[[nodiscard]] absl::StatusOr<JobSpec> JobSpecFromJson(const nlohmann::json& json);

}  // namespace cohort
