#include "common/geometry/comparison/curvature_difference.h"

#include <cassert>
#include <cmath>

namespace cohort {

std::vector<float> CurvatureDifferences(std::span<const double> source_curvatures,
                                        std::span<const double> target_curvatures,
                                        std::span<const int32_t> nearest) {
  assert(source_curvatures.size() == nearest.size());
  std::vector<float> differences(nearest.size());
  for (size_t i = 0; i < nearest.size(); ++i) {
    assert(nearest[i] >= 0 && static_cast<size_t>(nearest[i]) < target_curvatures.size());
    const double target = target_curvatures[static_cast<size_t>(nearest[i])];
    differences[i] = static_cast<float>(std::abs(target - source_curvatures[i]));
  }
  return differences;
}

}  // namespace cohort
