#include "common/geometry/nearest/packet_find.h"
#include "common/geometry/nearest/packet_pairs.h"
#include "common/geometry/nearest/simd_avx512.h"

namespace cohort {

const PacketKernels& Avx512Kernels() {
  static constexpr PacketKernels kKernels = {
      .find = FindFused<Avx512Simd>, .move = Move<Avx512Simd>, .add_pairs = AddPairs<Avx512Simd>};
  return kKernels;
}

}  // namespace cohort
