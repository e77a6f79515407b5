// g++ 12 takes the undefined operands inside its own intrinsics for a mistake.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
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
