#pragma once

#include <memory>
#include <span>

#include "common/geometry/nearest/correspondence.h"
#include "common/geometry/nearest/packet_search.h"
#include "common/geometry/registration/icp_mesh.h"

namespace cohort {

/// Pairs the vertices of one moved mesh with what is nearest to them on another; the pairs found
/// last stay. Internal to registration.
class PairFinder {
 public:
  virtual ~PairFinder() = default;

  /// Pairs all vertices. Any but the first call is fastest after a small move.
  virtual void Find(const PointTransform& transform) = 0;
  /// Find and Sum over all pairs in one go.
  virtual PairSums FindAndSum(const PointTransform& transform) = 0;
  [[nodiscard]] virtual PairSums Sum(std::span<const uint16_t> kept) const = 0;

  /// By source slot.
  [[nodiscard]] virtual std::span<const float> SquaredDistances() const = 0;
  /// The target's point paired with the source's slot, in the target's packed frame.
  [[nodiscard]] virtual Eigen::Vector3d PartnerOf(int slot) const = 0;
  /// True if that point lies on the target's open boundary; surfaces do not know.
  [[nodiscard]] virtual bool IsOnBoundary(int slot) const = 0;
};

/// @param search  used by pairs of vertices; must outlive the finder, as the meshes must.
/// @param target  with a surface for Correspondence::kSurface.
[[nodiscard]] std::unique_ptr<PairFinder> MakePairFinder(const IcpMesh& source,
                                                         const IcpMesh& target,
                                                         Correspondence correspondence,
                                                         PacketSearch& search);

}  // namespace cohort
