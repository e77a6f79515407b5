#include "common/geometry/nearest/packet_find.h"
#include "common/geometry/nearest/packet_pairs.h"
#include "common/geometry/nearest/simd_avx2.h"

namespace cohort {

const PacketKernels& Avx2Kernels() {
  static constexpr PacketKernels kKernels = {
      .find = FindFused<Avx2Simd>, .move = Move<Avx2Simd>, .add_pairs = AddPairs<Avx2Simd>};
  return kKernels;
}

}  // namespace cohort
