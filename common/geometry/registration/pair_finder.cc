#include "common/geometry/registration/pair_finder.h"

#include "common/geometry/nearest/surface_search.h"

namespace cohort {
namespace {

class VertexPairs final : public PairFinder {
 public:
  VertexPairs(const IcpMesh& source, const IcpMesh& target, PacketSearch& search)
      : source_(source), target_(target), search_(search) {}

  void Find(const PointTransform& transform) override {
    search_.FindMoved(source_.Packed(), transform, target_.Packed(), seed_, nearest_);
    seed_ = SearchSeed::kPrevious;
  }
  PairSums FindAndSum(const PointTransform& transform) override {
    PairSums sums =
        search_.FindMovedAndSum(source_.Packed(), transform, target_.Packed(), seed_, nearest_);
    seed_ = SearchSeed::kPrevious;
    return sums;
  }
  [[nodiscard]] PairSums Sum(std::span<const uint16_t> kept) const override {
    return search_.Sum(source_.Packed(), target_.Packed(), nearest_, kept);
  }
  [[nodiscard]] std::span<const float> SquaredDistances() const override {
    return {nearest_.squared_distances.data(), nearest_.squared_distances.size()};
  }
  [[nodiscard]] Eigen::Vector3d PartnerOf(int slot) const override {
    return target_.Packed().PointOfSlot(nearest_.slots[static_cast<size_t>(slot)]).cast<double>();
  }
  [[nodiscard]] bool IsOnBoundary(int slot) const override {
    return target_.HasBoundary() &&
           target_.IsSlotOnBoundary(nearest_.slots[static_cast<size_t>(slot)]);
  }

 private:
  const IcpMesh& source_;
  const IcpMesh& target_;
  PacketSearch& search_;
  SearchSeed seed_ = SearchSeed::kDescent;
  NearestSlots nearest_;
};

class SurfacePairs final : public PairFinder {
 public:
  SurfacePairs(const IcpMesh& source, const PackedSurface& target)
      : source_(source), target_(target) {}

  void Find(const PointTransform& transform) override {
    search_.FindMoved(source_.Packed(), transform, target_, seed_, nearest_);
    seed_ = SearchSeed::kPrevious;
  }
  PairSums FindAndSum(const PointTransform& transform) override {
    PairSums sums = search_.FindMovedAndSum(source_.Packed(), transform, target_, seed_, nearest_);
    seed_ = SearchSeed::kPrevious;
    return sums;
  }
  [[nodiscard]] PairSums Sum(std::span<const uint16_t> kept) const override {
    return search_.Sum(source_.Packed(), nearest_, kept);
  }
  [[nodiscard]] std::span<const float> SquaredDistances() const override {
    return {nearest_.squared_distances.data(), nearest_.squared_distances.size()};
  }
  [[nodiscard]] Eigen::Vector3d PartnerOf(int slot) const override {
    return nearest_.PointOfSlot(slot).cast<double>();
  }
  [[nodiscard]] bool IsOnBoundary(int /*slot*/) const override { return false; }

 private:
  const IcpMesh& source_;
  const PackedSurface& target_;
  SurfaceSearch search_;
  SearchSeed seed_ = SearchSeed::kDescent;
  NearestOnSurface nearest_;
};

}  // namespace

std::unique_ptr<PairFinder> MakePairFinder(const IcpMesh& source,
                                           const IcpMesh& target,
                                           Correspondence correspondence,
                                           PacketSearch& search) {
  if (correspondence == Correspondence::kSurface) {
    return std::make_unique<SurfacePairs>(source, *target.Surface());
  }
  return std::make_unique<VertexPairs>(source, target, search);
}

}  // namespace cohort
