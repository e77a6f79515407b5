#include "common/geometry/nearest/packet_find_plain.h"
#include "common/geometry/nearest/packet_pairs.h"
#include "common/geometry/nearest/simd_portable.h"

namespace cohort {

const PacketKernels& PortableKernels() {
  static constexpr PacketKernels kKernels = {.find = FindPlain<PortableSimd>,
                                             .move = Move<PortableSimd>,
                                             .add_pairs = AddPairs<PortableSimd>};
  return kKernels;
}

}  // namespace cohort
