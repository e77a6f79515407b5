#include "tests/bench/rivals/plain_icp.h"

#include <cmath>
#include <cstddef>
#include <limits>

#include <Eigen/Core>

#include "common/geometry/registration/paired_sums.h"

namespace cohort {
namespace {

PairSums ToPairSums(const RivalSums& sums) {
  PairSums result;
  result.count = static_cast<int64_t>(sums.count);
  result.a = Eigen::Vector3d(sums.a.data());
  result.b = Eigen::Vector3d(sums.b.data());
  result.aa = sums.aa;
  result.bb = sums.bb;
  result.ba = Eigen::Matrix3d(sums.ba.data()).transpose();  // Eigen reads column by column.
  result.squared_distance = sums.squared_distance;
  return result;
}

}  // namespace

std::array<double, 12> RowsOf(const Similarity& T) {
  std::array<double, 12> rows{};
  size_t next = 0;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) {
      rows[next++] = T.scale * T.rotation(r, c);
    }
    rows[next++] = T.translation(r);
  }
  return rows;
}

PlainIcpResult PlainIcp(PointList source,
                        const IcpRival& target,
                        const Similarity& T_target_source,
                        ScaleMode scale_mode,
                        double tolerance) {
  constexpr int kMostIterations = 1000;
  Similarity pose = T_target_source;
  PlainIcpResult result;
  double before = std::numeric_limits<double>::infinity();
  while (result.iterations < kMostIterations) {
    const RivalSums sums = target.Pass(source, RowsOf(pose));
    ++result.iterations;
    result.rms = std::sqrt(sums.squared_distance / sums.count);
    if (std::abs(before - result.rms) < tolerance) {
      break;
    }
    before = result.rms;
    const absl::StatusOr<Similarity> fit = PairedSums(ToPairSums(sums)).Fit(scale_mode);
    if (!fit.ok()) {
      break;
    }
    pose = *fit;
  }
  return result;
}

}  // namespace cohort
