#include "common/pairs/pair_meter.h"

#include <limits>
#include <utility>

#include "common/base/status_macros.h"
#include "common/geometry/comparison/distance_codec.h"

namespace cohort {

namespace {

/// Without the repeats behind the last vertex.
std::span<const float> VertexValues(const AlignedArray<float>& values, const PackedMesh& mesh) {
  return {values.data(), static_cast<size_t>(mesh.VertexCount())};
}

}  // namespace

absl::StatusOr<MeasuredPair> PairMeter::Measure(const PackedMesh& source,
                                                const PairTarget& target) {
  if (options_.correspondence == Correspondence::kSurface) {
    surface_search_.Find(source, *target.surface, on_surface_);
    return Summarize(VertexValues(on_surface_.squared_distances, source), source.Diagonal());
  }
  search_.Find(source, target.vertices, nearest_);
  return Summarize(Counting(source, target.vertices, target.unplaced), source.Diagonal());
}

absl::StatusOr<MeasuredPair> PairMeter::MeasureMoved(const IcpMesh& source,
                                                     const IcpMesh& target,
                                                     const Similarity& T_target_source) {
  const PointTransform transform = PackedTransform(T_target_source, source, target);
  if (options_.correspondence == Correspondence::kSurface) {
    surface_search_.FindMoved(source.Packed(), transform, *target.Surface(), SearchSeed::kDescent,
                              on_surface_);
    return Summarize(VertexValues(on_surface_.squared_distances, source.Packed()),
                     source.Packed().Diagonal());
  }
  search_.FindMoved(source.Packed(), transform, target.Packed(), SearchSeed::kDescent, nearest_);
  return Summarize(Counting(source.Packed(), target.Packed(), &target), source.Packed().Diagonal());
}

std::span<const float> PairMeter::Counting(const PackedMesh& source,
                                           const PackedMesh& target,
                                           const IcpMesh* target_mesh) {
  const std::span<const float> all = VertexValues(nearest_.squared_distances, source);
  if (options_.boundary_pairs == BoundaryPairs::kKeep || !target_mesh->HasBoundary()) {
    return all;
  }
  counting_.clear();
  for (size_t slot = 0; slot < all.size(); ++slot) {
    const auto found = static_cast<size_t>(nearest_.slots[slot]);
    if (!target_mesh->IsOnBoundary(target.VertexOfSlot()[found])) {
      counting_.push_back(all[slot]);
    }
  }
  return counting_;
}

absl::StatusOr<MeasuredPair> PairMeter::Summarize(std::span<const float> squared_distances,
                                                  double diagonal) {
  MeasuredPair measured;
  if (squared_distances.empty()) {
    measured.metrics.fill(std::numeric_limits<double>::quiet_NaN());
    return measured;
  }
  DistanceSummary summary = MeasureSquaredDistances(squared_distances, scratch_);
  measured.field.values = static_cast<int64_t>(squared_distances.size());
  const std::span<const float> distances(scratch_.distances.data(), squared_distances.size());
  switch (options_.retention) {
    case Retention::kVectors:
      measured.field.bytes = EncodeVectors(distances);
      break;
    case Retention::kCompact: {
      // Metrics are those of the values as kept, so that computing them again changes nothing.
      const CompactOptions compact = {.step = CompactStep(diagonal)};
      COHORT_ASSIGN_OR_RETURN(const CompactField kept, RoundCompact(distances, compact));
      COHORT_ASSIGN_OR_RETURN(measured.field.bytes, EncodeCompact(distances, compact));
      summary = MeasureDistances(kept.distances, DistanceSign::kAbsolute, scratch_);
      break;
    }
    case Retention::kSketch:
      measured.field.bytes = EncodeSketch(summary.sketch);
      break;
    case Retention::kMetrics:
    case Retention::kAuto:
      break;
  }
  measured.metrics = summary.metrics;
  return measured;
}

}  // namespace cohort
