#pragma once

#include <array>

#include "common/geometry/registration/similarity.h"
#include "tests/bench/rivals/rival.h"

namespace cohort {

struct PlainIcpResult {
  int iterations = 0;
  double rms = 0;  ///< Of the last pass, mm.
};

/// The textbook's scaling ICP on nanoflann, with our closed form: look up, fit, repeat until the
/// RMS changes by less than `tolerance`.
[[nodiscard]] PlainIcpResult PlainIcp(PointList source,
                                      const IcpRival& target,
                                      const Similarity& T_target_source,
                                      ScaleMode scale_mode,
                                      double tolerance);

/// 3 x 4, row by row.
[[nodiscard]] std::array<double, 12> RowsOf(const Similarity& T);

}  // namespace cohort
