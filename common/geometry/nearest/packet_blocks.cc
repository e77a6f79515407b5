#include "common/geometry/nearest/packet_blocks.h"

#include <bit>
#include <cassert>

namespace cohort {

const PacketKernels& PacketKernelsOf(InstructionSet set) {
#if defined(COHORT_X86_KERNELS)
  switch (set) {
    case InstructionSet::kAvx512:
      return Avx512Kernels();
    case InstructionSet::kAvx2:
      return Avx2Kernels();
    case InstructionSet::kPortable:
      return PortableKernels();
  }
#endif
  assert(set == InstructionSet::kPortable);
  return PortableKernels();
}

PairSums TotalOf(const PairSumLanes& lanes, std::span<const uint16_t> kept) {
  double sums[PairSumLanes::kSums];
  for (int i = 0; i < PairSumLanes::kSums; ++i) {
    sums[i] = 0;
    for (const double lane : lanes.lanes[i]) {
      sums[i] += lane;
    }
  }
  PairSums total;
  for (const uint16_t lanes_kept : kept) {
    total.count += std::popcount(lanes_kept);
  }
  total.a = Eigen::Vector3d(sums[0], sums[1], sums[2]);
  total.b = Eigen::Vector3d(sums[3], sums[4], sums[5]);
  total.aa = sums[6];
  total.bb = sums[7];
  total.squared_distance = sums[8];
  total.distance = sums[9];
  for (int row = 0; row < 3; ++row) {
    total.ba.row(row) =
        Eigen::RowVector3d(sums[10 + 3 * row], sums[11 + 3 * row], sums[12 + 3 * row]);
  }
  return total;
}

}  // namespace cohort
