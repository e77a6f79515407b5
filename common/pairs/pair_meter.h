#pragma once

#include "common/geometry/comparison/measure_distances.h"
#include "common/geometry/nearest/packet_search.h"
#include "common/geometry/nearest/surface_search.h"
#include "common/geometry/registration/icp_mesh.h"
#include "common/jobs/field_blob.h"

namespace cohort {

/// What was measured of one directed pair. All metrics are NaN if no pair of vertices counts.
struct MeasuredPair {
  MetricValues metrics{};
  KeptField field;  ///< Empty for Retention::kMetrics.
};

/// The target of a pair in the common frame.
struct PairTarget {
  const PackedMesh& vertices;
  const IcpMesh* unplaced = nullptr;       ///< The same mesh, needed for BoundaryPairs::kReject.
  const PackedSurface* surface = nullptr;  ///< Needed for Correspondence::kSurface.
};

/// Measures directed pairs: distances of the source's vertices to the target. Holds the memory that
/// this needs: one per thread.
class PairMeter {
 public:
  explicit PairMeter(const CompareOptions& options) : options_(options) {}

  /// Both packed in one common frame.
  /// @return as EncodeCompact.
  [[nodiscard]] absl::StatusOr<MeasuredPair> Measure(const PackedMesh& source,
                                                     const PairTarget& target);
  /// The source moved onto the target.
  [[nodiscard]] absl::StatusOr<MeasuredPair> MeasureMoved(const IcpMesh& source,
                                                          const IcpMesh& target,
                                                          const Similarity& T_target_source);
  [[nodiscard]] PacketSearch& Search() { return search_; }

 private:
  /// The squared distances to vertices found last that count, in slot order.
  [[nodiscard]] std::span<const float> Counting(const PackedMesh& source,
                                                const PackedMesh& target,
                                                const IcpMesh* target_mesh);
  [[nodiscard]] absl::StatusOr<MeasuredPair> Summarize(std::span<const float> squared_distances,
                                                       double diagonal);

  const CompareOptions options_;
  PacketSearch search_;
  NearestSlots nearest_;
  SurfaceSearch surface_search_;
  NearestOnSurface on_surface_;
  DistanceScratch scratch_;
  std::vector<float> counting_;
};

}  // namespace cohort
