#pragma once

#include <span>
#include <vector>

#include "common/geometry/comparison/metrics.h"
#include "common/geometry/nearest/packet_search.h"
#include "common/geometry/nearest/surface_search.h"
#include "common/pairs/pair_mesh.h"

namespace cohort {

/// Distances of one directed pair, of the vertices that count.
struct PairDistances {
  std::vector<float> distances;  ///< Mesh units; with a sign if asked for.
  std::vector<int32_t> slots;    ///< Of the source, ascending: slot s is VertexOfSlot()[s].
};

/// Finds the distances themselves, where PairMeter only measures them. Without a sign they are, bit
/// by bit, those that a job measures. Holds the memory that this needs: one per thread.
class DistanceFinder {
 public:
  DistanceFinder(const CompareOptions& options, DistanceSign sign)
      : options_(options), sign_(sign) {}

  /// From the vertices of `source` to `target`, both made for these options.
  /// @return valid until the next call.
  const PairDistances& Find(const PairMesh& source, const PairMesh& target);

 private:
  std::span<const float> SquaredToVertices(const PairMesh& source, const PairMesh& target);
  std::span<const float> SquaredToSurface(const PairMesh& source, const PairMesh& target);
  void AddSigns(const PairMesh& source,
                const PairMesh& target,
                std::span<const float> squared_distances);
  void DropBoundary(const PairMesh& target);

  const CompareOptions options_;
  const DistanceSign sign_;
  PacketSearch search_;
  NearestSlots nearest_;
  SurfaceSearch surface_search_;
  NearestOnSurface on_surface_;
  PairDistances found_;
};

}  // namespace cohort
