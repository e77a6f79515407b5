#include "common/geometry/comparison/distance_sketch.h"

#include <algorithm>
#include <cmath>

namespace cohort {

double SketchBinWidth(DistanceSign sign, double max_absolute, double rms) {
  int exponent = 0;
  // x = m 2^e with m in [1/2, 1): 2^e is the smallest power of two above x.
  std::frexp(std::min(max_absolute, 8 * rms), &exponent);
  const int bins = sign == DistanceSign::kSigned ? kSketchBins / 2 : kSketchBins;
  return max_absolute > 0 ? std::ldexp(1.0 / bins, std::max(exponent, -100))
                          : std::ldexp(1.0 / bins, -100);
}

}  // namespace cohort
