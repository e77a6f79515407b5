#pragma once

#include <cstdint>

#include "common/geometry/nearest/packed_surface.h"
#include "common/geometry/nearest/packet_search_kernels.h"

namespace cohort {

/// Memory that a surface search needs, 64-byte aligned.
struct SurfaceQueues {
  SearchQueues leaves;  ///< Each of SearchQueues::Size(target.boxes).
  float* distances;     ///< 16 per leaf of the target.
};

/// What a surface search writes for each query.
struct SurfaceResults {
  int32_t* slots;  ///< Triangle of the target; read first with SearchSeed::kPrevious.
  float* squared_distances;
  float* points;  ///< Nearest points: per packet 16 x, 16 y, 16 z.
};

/// One implementation per instruction set; all give the same bytes.
struct SurfaceKernels {
  void (*find)(const QueryBlock& block,
               const PackedSurface::View& target,
               SearchSeed seed,
               const SurfaceQueues& queues,
               const SurfaceResults& results);
};

[[nodiscard]] const SurfaceKernels& PortableSurfaceKernels();
#if defined(COHORT_X86_KERNELS)
[[nodiscard]] const SurfaceKernels& Avx2SurfaceKernels();
[[nodiscard]] const SurfaceKernels& Avx512SurfaceKernels();
#endif

}  // namespace cohort
