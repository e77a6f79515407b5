#include "common/geometry/nearest/surface_search.h"

#include <algorithm>
#include <cassert>
#include <numeric>

#include "common/geometry/nearest/packet_blocks.h"

namespace cohort {
namespace {

constexpr size_t kLanes = PackedMesh::kLanes;

const SurfaceKernels& SurfaceKernelsOf(InstructionSet set) {
#if defined(COHORT_X86_KERNELS)
  switch (set) {
    case InstructionSet::kAvx512:
      return Avx512SurfaceKernels();
    case InstructionSet::kAvx2:
      return Avx2SurfaceKernels();
    case InstructionSet::kPortable:
      return PortableSurfaceKernels();
  }
#endif
  assert(set == InstructionSet::kPortable);
  return PortableSurfaceKernels();
}

}  // namespace

Eigen::Vector3f NearestOnSurface::PointOfSlot(int slot) const {
  const auto s = static_cast<size_t>(slot);
  const float* packet = &points[s / kLanes * kPacketFloats];
  return {packet[s % kLanes], packet[kLanes + s % kLanes], packet[2 * kLanes + s % kLanes]};
}

SurfaceSearch::SurfaceSearch()
    : SurfaceSearch(ChooseInstructionSet().value_or(AvailableInstructionSets().back())) {}

SurfaceSearch::SurfaceSearch(InstructionSet set)
    : kernels_(&SurfaceKernelsOf(set)),
      packet_kernels_(&PacketKernelsOf(set)),
      moved_points_(kBlockPackets * kPacketFloats),
      moved_boxes_(kBlockPackets * kBoxFloats),
      own_slots_(kBlockPackets * kLanes) {
  std::iota(own_slots_.data(), own_slots_.data() + own_slots_.size(), 0);
}

SurfaceQueues SurfaceSearch::Queues(const PackedSurface& target) {
  const auto size = static_cast<size_t>(SearchQueues::Size(target.Addresses().boxes));
  first_queue_.Reset(size);
  second_queue_.Reset(size);
  distances_.Reset(static_cast<size_t>(target.LeafCount()) * kLanes);
  return {.leaves = {.first = first_queue_.data(), .second = second_queue_.data()},
          .distances = distances_.data()};
}

void SurfaceSearch::Find(const PackedMesh& queries,
                         const PackedSurface& target,
                         NearestOnSurface& nearest) {
  nearest.Reset(queries.SlotCount());
  const SurfaceQueues queues = Queues(target);
  for (int first = 0; first < queries.LeafCount(); first += kBlockPackets) {
    const auto leaf = static_cast<size_t>(first);
    const QueryBlock block = {.points = queries.Addresses().points + leaf * kPacketFloats,
                              .boxes = queries.Addresses().boxes + leaf * kBoxFloats,
                              .packets = PacketsFrom(queries, first)};
    kernels_->find(block, target.Addresses(), SearchSeed::kDescent, queues,
                   {.slots = nearest.slots.data() + leaf * kLanes,
                    .squared_distances = nearest.squared_distances.data() + leaf * kLanes,
                    .points = nearest.points.data() + leaf * kPacketFloats});
  }
}

void SurfaceSearch::FindBlock(const PackedMesh& queries,
                              const PointTransform& transform,
                              const PackedSurface& target,
                              int first,
                              SearchSeed seed,
                              NearestOnSurface& nearest) {
  const auto leaf = static_cast<size_t>(first);
  const int packets = PacketsFrom(queries, first);
  packet_kernels_->move(queries.Addresses().points + leaf * kPacketFloats, packets, transform,
                        moved_points_.data(), moved_boxes_.data());
  kernels_->find({.points = moved_points_.data(), .boxes = moved_boxes_.data(), .packets = packets},
                 target.Addresses(), seed, Queues(target),
                 {.slots = nearest.slots.data() + leaf * kLanes,
                  .squared_distances = nearest.squared_distances.data() + leaf * kLanes,
                  .points = nearest.points.data() + leaf * kPacketFloats});
}

void SurfaceSearch::FindMoved(const PackedMesh& queries,
                              const PointTransform& transform,
                              const PackedSurface& target,
                              SearchSeed seed,
                              NearestOnSurface& nearest) {
  if (seed == SearchSeed::kDescent) {
    nearest.Reset(queries.SlotCount());
  }
  assert(nearest.slots.size() == static_cast<size_t>(queries.SlotCount()));
  for (int first = 0; first < queries.LeafCount(); first += kBlockPackets) {
    FindBlock(queries, transform, target, first, seed, nearest);
  }
}

void SurfaceSearch::AddBlock(const PackedMesh& queries,
                             int first,
                             const uint16_t* kept,
                             const NearestOnSurface& nearest,
                             PairSumLanes& sums) const {
  const auto leaf = static_cast<size_t>(first);
  PackedMesh::View partners{};
  partners.points = nearest.points.data() + leaf * kPacketFloats;
  packet_kernels_->add_pairs({.points = queries.Addresses().points + leaf * kPacketFloats,
                              .slots = own_slots_.data(),
                              .squared_distances = nearest.squared_distances.data() + leaf * kLanes,
                              .kept = kept + leaf,
                              .packets = PacketsFrom(queries, first)},
                             partners, sums);
}

PairSums SurfaceSearch::FindMovedAndSum(const PackedMesh& queries,
                                        const PointTransform& transform,
                                        const PackedSurface& target,
                                        SearchSeed seed,
                                        NearestOnSurface& nearest) {
  if (seed == SearchSeed::kDescent) {
    nearest.Reset(queries.SlotCount());
  }
  assert(nearest.slots.size() == static_cast<size_t>(queries.SlotCount()));
  const AlignedArray<uint16_t> kept = AllVertices(queries);
  PairSumLanes sums = {};
  for (int first = 0; first < queries.LeafCount(); first += kBlockPackets) {
    FindBlock(queries, transform, target, first, seed, nearest);
    AddBlock(queries, first, kept.data(), nearest, sums);
  }
  return TotalOf(sums, {kept.data(), kept.size()});
}

PairSums SurfaceSearch::Sum(const PackedMesh& queries,
                            const NearestOnSurface& nearest,
                            std::span<const uint16_t> kept) const {
  assert(kept.size() == static_cast<size_t>(queries.LeafCount()));
  PairSumLanes sums = {};
  for (int first = 0; first < queries.LeafCount(); first += kBlockPackets) {
    AddBlock(queries, first, kept.data(), nearest, sums);
  }
  return TotalOf(sums, kept);
}

}  // namespace cohort
