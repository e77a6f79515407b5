#pragma once

#include <cstdint>

#include "common/geometry/nearest/packed_mesh.h"

namespace cohort {

/// Packets (runs of 16 queries) that one kernel call advances together.
inline constexpr int kBlockPackets = 16;

/// Up to kBlockPackets packets of queries. 64-byte aligned.
struct QueryBlock {
  const float* points;  ///< Per packet 16 x, 16 y, 16 z.
  const float* boxes;   ///< Per packet low x, y, z, high x, y, z, two unused.
  int packets;
};

/// Memory that a search needs: each of `size` >= QueueSize(target), 64-byte aligned.
struct SearchQueues {
  uint32_t* first;
  uint32_t* second;
  static int64_t Size(const PackedMesh::View& target) {
    return int64_t{kBlockPackets} * target.leaf_count + PackedMesh::kLanes;
  }
};

enum class SearchSeed : uint8_t {
  kDescent,   ///< One descent per packet.
  kPrevious,  ///< The slots given: good when the queries have moved little since they were found.
};

/// x' = rows * (x, 1), in double without fused multiply-add, rounded to float32 once.
struct PointTransform {
  double rows[3][4];
};

/// Sums over pairs of a source point a and a target point b, each kept in 16 lanes.
struct PairSumLanes {
  static constexpr int kSums = 19;
  /// a (3), b (3), a . a, b . b, squared distance, distance, b a^T (9, row by row).
  alignas(64) double lanes[kSums][16];
};

/// Packets of source points and what the search found for them.
struct PairBlock {
  const float* points;
  const int32_t* slots;
  const float* squared_distances;
  const uint16_t* kept;  ///< Per packet: only lanes with a bit here are added.
  int packets;
};

/// One implementation per instruction set; all give the same bytes.
struct PacketKernels {
  /// Nearest slot of the target and squared distance, for each query.
  void (*find)(const QueryBlock& block,
               const PackedMesh::View& target,
               SearchSeed seed,
               const SearchQueues& queues,
               int32_t* slots,
               float* squared_distances);
  /// Moves packets; writes their points and boxes.
  void (*move)(const float* points,
               int packets,
               const PointTransform& transform,
               float* moved_points,
               float* moved_boxes);
  /// Adds the pairs of the packets of `block`.
  void (*add_pairs)(const PairBlock& block, const PackedMesh::View& target, PairSumLanes& sums);
};

[[nodiscard]] const PacketKernels& PortableKernels();
#if defined(COHORT_X86_KERNELS)
[[nodiscard]] const PacketKernels& Avx2Kernels();
[[nodiscard]] const PacketKernels& Avx512Kernels();
#endif

}  // namespace cohort
