#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <absl/status/statusor.h>
#include <nlohmann/json_fwd.hpp>

#include "common/geometry/comparison/metrics.h"
#include "common/geometry/registration/scaling_icp.h"

namespace cohort {

/// What the meshes are aligned to before all pairs are measured.
enum class Method {
  kAverage,  ///< The mean shape, built in `rounds` rounds from the base mesh.
  kOne,      ///< The base mesh.
  kEach,     ///< Every mesh: the pair (source, target) is measured after aligning source to target.
  kNone,     ///< Nothing: the meshes are measured where they are.
};

/// How a mesh is brought near the reference before ICP.
enum class PoseMode { kPrincipalAxes, kNone };

/// How the two directed values of a pair become one.
enum class Symmetrization {
  kMean,      ///< (m_ij + m_ji) / 2, as the predecessor.
  kMax,       ///< max(m_ij, m_ji); of the metric "max" this is the Hausdorff distance.
  kDirected,  ///< Left as they are: row = source (its vertices are measured), column = target.
};

/// Everything that determines the numbers of a job, apart from its meshes.
struct JobSpec {
  Method method = Method::kAverage;
  std::string base;  ///< Mesh name of the first reference; empty: the first usable mesh by name.
  int rounds = 3;    ///< M, updates of the mean shape (method average), 1..100.
  PoseMode pose = PoseMode::kPrincipalAxes;
  IcpOptions icp;
  Metric metric = Metric::kRms;
  Symmetrization symmetrization = Symmetrization::kMean;
  int neighbours = 3;      ///< Most similar faces listed per face, >= 1.
  int position_bits = 18;  ///< Draco quantisation of the canonical meshes, 8..30.
  /// Meshes more than this many times larger or smaller than the median one (RMS radius) are taken
  /// for another unit of length and the job is refused. 0: not checked.
  double size_ratio_limit = 5;

  /// @return kInvalidArgument naming the field, its value and what was expected.
  [[nodiscard]] absl::Status Validate() const;
};

/// "default" or "thesis" (I = 10 per round, e = 0.05, M = 3, scaling on; for one and each I = 40,
/// as the thesis's tables use). `method` is set too.
/// @return kInvalidArgument listing the presets.
[[nodiscard]] absl::StatusOr<JobSpec> PresetSpec(std::string_view preset, Method method);

[[nodiscard]] std::string_view MethodName(Method method);  ///< "average", "one", "each", "none".
[[nodiscard]] std::optional<Method> MethodFromName(std::string_view name);
[[nodiscard]] std::string_view PoseModeName(PoseMode pose);  ///< "principal-axes", "none".
[[nodiscard]] std::optional<PoseMode> PoseModeFromName(std::string_view name);
[[nodiscard]] std::string_view SymmetrizationName(
    Symmetrization value);  ///< "mean", "max", "directed".
[[nodiscard]] std::optional<Symmetrization> SymmetrizationFromName(std::string_view name);

/// As kept in the catalog and shown in job.json.
[[nodiscard]] nlohmann::json ToJson(const JobSpec& spec);
/// @return kInvalidArgument naming the field. Missing fields take their defaults.
[[nodiscard]] absl::StatusOr<JobSpec> JobSpecFromJson(const nlohmann::json& json);

}  // namespace cohort
