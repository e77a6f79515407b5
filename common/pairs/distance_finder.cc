#include "common/pairs/distance_finder.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/geometry/comparison/signed_distances.h"

namespace cohort {

std::span<const float> DistanceFinder::SquaredToVertices(const PairMesh& source,
                                                         const PairMesh& target) {
  search_.Find(source.vertices, target.vertices, nearest_);
  return {nearest_.squared_distances.data(), static_cast<size_t>(source.vertices.VertexCount())};
}

std::span<const float> DistanceFinder::SquaredToSurface(const PairMesh& source,
                                                        const PairMesh& target) {
  surface_search_.Find(source.vertices, *target.surface, on_surface_);
  return {on_surface_.squared_distances.data(), static_cast<size_t>(source.vertices.VertexCount())};
}

void DistanceFinder::AddSigns(const PairMesh& source,
                              const PairMesh& target,
                              std::span<const float> squared_distances) {
  if (options_.correspondence == Correspondence::kVertex) {
    found_.distances =
        SignedDistances(source.slot_points, source.slot_normals, target.slot_points,
                        {nearest_.slots.data(), squared_distances.size()}, squared_distances)
            .distances;
    return;
  }
  Eigen::Matrix3Xf points(3, source.slot_points.cols());
  for (Eigen::Index slot = 0; slot < points.cols(); ++slot) {
    points.col(slot) = on_surface_.PointOfSlot(static_cast<int>(slot));
  }
  found_.distances =
      SignedDistances(source.slot_points, source.slot_normals, points, squared_distances).distances;
}

void DistanceFinder::DropBoundary(const PairMesh& target) {
  size_t kept = 0;
  for (size_t slot = 0; slot < found_.distances.size(); ++slot) {
    const auto found = static_cast<size_t>(nearest_.slots[slot]);
    if (!target.unplaced->IsOnBoundary(target.vertices.VertexOfSlot()[found])) {
      found_.distances[kept] = found_.distances[slot];
      found_.slots[kept] = found_.slots[slot];
      ++kept;
    }
  }
  found_.distances.resize(kept);
  found_.slots.resize(kept);
}

const PairDistances& DistanceFinder::Find(const PairMesh& source, const PairMesh& target) {
  const bool to_surface = options_.correspondence == Correspondence::kSurface;
  const std::span<const float> squared =
      to_surface ? SquaredToSurface(source, target) : SquaredToVertices(source, target);
  found_.distances.resize(squared.size());
  found_.slots.resize(squared.size());
  std::iota(found_.slots.begin(), found_.slots.end(), 0);
  if (sign_ == DistanceSign::kSigned) {
    AddSigns(source, target, squared);
  } else {
    std::transform(squared.begin(), squared.end(), found_.distances.begin(),
                   [](float value) { return std::sqrt(value); });
  }
  if (!to_surface && options_.boundary_pairs == BoundaryPairs::kReject &&
      target.unplaced->HasBoundary()) {
    DropBoundary(target);
  }
  return found_;
}

}  // namespace cohort
