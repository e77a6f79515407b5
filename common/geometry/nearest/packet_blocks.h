#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "common/geometry/nearest/instruction_set.h"
#include "common/geometry/nearest/packet_search.h"

namespace cohort {

// What the searches for vertices and for surfaces share. Internal to this folder; not for the files
// that are compiled for one instruction set.

inline constexpr size_t kPacketFloats = size_t{3} * PackedMesh::kLanes;
inline constexpr size_t kBoxFloats = 8;

/// @param set  must be available.
[[nodiscard]] const PacketKernels& PacketKernelsOf(InstructionSet set);

/// Packets of the block that begins with leaf `first`.
[[nodiscard]] inline int PacketsFrom(const PackedMesh& queries, int first) {
  return std::min(kBlockPackets, queries.LeafCount() - first);
}

/// Adds the lanes in their order.
/// @param kept  one entry per leaf: the lanes that count.
[[nodiscard]] PairSums TotalOf(const PairSumLanes& lanes, std::span<const uint16_t> kept);

}  // namespace cohort
