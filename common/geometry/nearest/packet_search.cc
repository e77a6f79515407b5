#include "common/geometry/nearest/packet_search.h"

#include <algorithm>

#include "common/geometry/nearest/packet_blocks.h"

namespace cohort {
AlignedArray<uint16_t> AllVertices(const PackedMesh& mesh) {
  AlignedArray<uint16_t> kept(static_cast<size_t>(mesh.LeafCount()));
  std::fill_n(kept.data(), kept.size(), uint16_t{0xFFFF});
  const int rest = mesh.VertexCount() % PackedMesh::kLanes;
  if (rest != 0) {
    kept[kept.size() - 1] = static_cast<uint16_t>((1U << static_cast<unsigned>(rest)) - 1U);
  }
  return kept;
}

PacketSearch::PacketSearch()
    : PacketSearch(ChooseInstructionSet().value_or(AvailableInstructionSets().back())) {}

PacketSearch::PacketSearch(InstructionSet set)
    : kernels_(&PacketKernelsOf(set)),
      moved_points_(kBlockPackets * kPacketFloats),
      moved_boxes_(kBlockPackets * kBoxFloats) {}

SearchQueues PacketSearch::Queues(const PackedMesh& target) {
  const auto size = static_cast<size_t>(SearchQueues::Size(target.Addresses()));
  first_queue_.Reset(size);
  second_queue_.Reset(size);
  return {.first = first_queue_.data(), .second = second_queue_.data()};
}

void PacketSearch::Find(const PackedMesh& queries,
                        const PackedMesh& target,
                        NearestSlots& nearest) {
  nearest.Reset(queries.SlotCount());
  const SearchQueues queues = Queues(target);
  for (int first = 0; first < queries.LeafCount(); first += kBlockPackets) {
    const auto leaf = static_cast<size_t>(first);
    const QueryBlock block = {.points = queries.Addresses().points + leaf * kPacketFloats,
                              .boxes = queries.Addresses().boxes + leaf * kBoxFloats,
                              .packets = PacketsFrom(queries, first)};
    kernels_->find(block, target.Addresses(), SearchSeed::kDescent, queues,
                   nearest.slots.data() + leaf * PackedMesh::kLanes,
                   nearest.squared_distances.data() + leaf * PackedMesh::kLanes);
  }
}

void PacketSearch::FindBlock(const PackedMesh& queries,
                             const PointTransform& transform,
                             const PackedMesh& target,
                             int first,
                             SearchSeed seed,
                             NearestSlots& nearest) {
  const auto leaf = static_cast<size_t>(first);
  const int packets = PacketsFrom(queries, first);
  kernels_->move(queries.Addresses().points + leaf * kPacketFloats, packets, transform,
                 moved_points_.data(), moved_boxes_.data());
  const QueryBlock block = {
      .points = moved_points_.data(), .boxes = moved_boxes_.data(), .packets = packets};
  kernels_->find(block, target.Addresses(), seed, Queues(target),
                 nearest.slots.data() + leaf * PackedMesh::kLanes,
                 nearest.squared_distances.data() + leaf * PackedMesh::kLanes);
}

void PacketSearch::FindMoved(const PackedMesh& queries,
                             const PointTransform& transform,
                             const PackedMesh& target,
                             SearchSeed seed,
                             NearestSlots& nearest) {
  if (seed == SearchSeed::kDescent) {
    nearest.Reset(queries.SlotCount());
  }
  assert(nearest.slots.size() == static_cast<size_t>(queries.SlotCount()));
  for (int first = 0; first < queries.LeafCount(); first += kBlockPackets) {
    FindBlock(queries, transform, target, first, seed, nearest);
  }
}

PairSums PacketSearch::FindMovedAndSum(const PackedMesh& queries,
                                       const PointTransform& transform,
                                       const PackedMesh& target,
                                       SearchSeed seed,
                                       NearestSlots& nearest) {
  if (seed == SearchSeed::kDescent) {
    nearest.Reset(queries.SlotCount());
  }
  assert(nearest.slots.size() == static_cast<size_t>(queries.SlotCount()));
  const AlignedArray<uint16_t> kept = AllVertices(queries);
  PairSumLanes sums = {};
  for (int first = 0; first < queries.LeafCount(); first += kBlockPackets) {
    FindBlock(queries, transform, target, first, seed, nearest);
    const auto leaf = static_cast<size_t>(first);
    kernels_->add_pairs(
        {.points = queries.Addresses().points + leaf * kPacketFloats,
         .slots = nearest.slots.data() + leaf * PackedMesh::kLanes,
         .squared_distances = nearest.squared_distances.data() + leaf * PackedMesh::kLanes,
         .kept = kept.data() + leaf,
         .packets = PacketsFrom(queries, first)},
        target.Addresses(), sums);
  }
  return TotalOf(sums, {kept.data(), kept.size()});
}

PairSums PacketSearch::Sum(const PackedMesh& queries,
                           const PackedMesh& target,
                           const NearestSlots& nearest,
                           std::span<const uint16_t> kept) const {
  assert(kept.size() == static_cast<size_t>(queries.LeafCount()));
  PairSumLanes sums = {};
  for (int first = 0; first < queries.LeafCount(); first += kBlockPackets) {
    const auto leaf = static_cast<size_t>(first);
    kernels_->add_pairs(
        {.points = queries.Addresses().points + leaf * kPacketFloats,
         .slots = nearest.slots.data() + leaf * PackedMesh::kLanes,
         .squared_distances = nearest.squared_distances.data() + leaf * PackedMesh::kLanes,
         .kept = kept.data() + leaf,
         .packets = PacketsFrom(queries, first)},
        target.Addresses(), sums);
  }
  return TotalOf(sums, kept);
}

}  // namespace cohort
