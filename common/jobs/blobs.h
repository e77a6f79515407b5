#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include <absl/status/statusor.h>

#include "common/geometry/comparison/metrics.h"
#include "common/geometry/registration/scaling_icp.h"

namespace cohort {

// What tasks write. Every blob begins with 8 bytes of magic and version; numbers are little-endian;
// every Decode returns kDataLoss, naming the blob kind and what is wrong, for bytes that are cut
// short, too long, or hold impossible counts.

/// Alignment of one mesh of a job.
struct MeshAlignment {
  int32_t mesh = 0;  ///< Index in the job.
  Alignment alignment;
};
/// "COHALGN2", uint64 count, count x { int32 mesh, int32 iterations, uint8 converged,
/// int64 lookups, float64 rms, mean, uint8 at_scale_limit, float64 overlap, kept_share, scale,
/// R (9, row by row), t (3) }.
[[nodiscard]] std::string EncodeAlignmentBlob(const std::vector<MeshAlignment>& alignments);
[[nodiscard]] absl::StatusOr<std::vector<MeshAlignment>> DecodeAlignmentBlob(
    std::string_view bytes);

/// Sum of the displacements of some meshes. float32 rounds it by 1e-7 of what is itself small
/// beside the shape that its mean is added to.
struct DisplacementSum {
  int64_t mesh_count = 0;
  Eigen::Matrix3Xf sum;  ///< 3 x n, n = reference vertices.
};
/// "COHDISP2", int64 mesh_count, uint64 n, 3 n float32.
[[nodiscard]] std::string EncodeDisplacementBlob(const DisplacementSum& displacement);
[[nodiscard]] absl::StatusOr<DisplacementSum> DecodeDisplacementBlob(std::string_view bytes);

/// Metrics of all directed pairs sources x targets.
struct MetricBlock {
  std::vector<int32_t> sources;      ///< Job indices, rows.
  std::vector<int32_t> targets;      ///< Job indices, columns.
  std::vector<MetricValues> values;  ///< values[row * targets.size() + column].
};
/// "COHTILE1", uint64 blocks, each { uint64 rows, uint64 columns, uint64 metrics (7), int32
/// sources, int32 targets, float64 values }.
[[nodiscard]] std::string EncodeTileBlob(const std::vector<MetricBlock>& blocks);
[[nodiscard]] absl::StatusOr<std::vector<MetricBlock>> DecodeTileBlob(std::string_view bytes);

/// How the base mesh was chosen (BaseRule::kAuto).
struct BaseChoice {
  int32_t base = 0;  ///< Job index.
  /// Of each mesh that was looked at: mean of its distances to the others, coarsely aligned.
  struct Candidate {
    int32_t mesh = 0;
    double mean_distance = 0;
  };
  std::vector<Candidate> candidates;
};
/// "COHBASE1", int32 base, uint64 candidates, each { int32 mesh, float64 mean_distance }.
[[nodiscard]] std::string EncodeBaseBlob(const BaseChoice& choice);
[[nodiscard]] absl::StatusOr<BaseChoice> DecodeBaseBlob(std::string_view bytes);

/// Distances of each reference vertex to some aligned meshes.
struct VariationPart {
  std::vector<int32_t> meshes;   ///< Job indices.
  Eigen::MatrixXf distances;     ///< n x meshes.
  DisplacementSum displacement;  ///< Its sum: of n vertices or of none.
};
/// "COHVARI3", uint64 n, uint64 meshes, int32 indices, float32 distances (mesh by mesh),
/// int64 mesh_count, uint64 p (n, or 0: the sum is not wanted), 3 p float32.
[[nodiscard]] std::string EncodeVariationBlob(const VariationPart& part);
[[nodiscard]] absl::StatusOr<VariationPart> DecodeVariationBlob(std::string_view bytes);

/// All metrics over the meshes, for each vertex of the mean shape.
struct VariationSummary {
  int64_t mesh_count = 0;
  std::vector<MetricValues> values;  ///< One per vertex.
};
/// "COHSUMM1", int64 mesh_count, uint64 n, uint64 metrics (7), float64 values.
[[nodiscard]] std::string EncodeSummaryBlob(const VariationSummary& summary);
[[nodiscard]] absl::StatusOr<VariationSummary> DecodeSummaryBlob(std::string_view bytes);

}  // namespace cohort
