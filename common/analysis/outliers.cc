#include "common/analysis/outliers.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cohort {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kMadOfNormal = 0.6745;   ///< MAD / standard deviation of normal values.
constexpr double kMeanOfNormal = 1.2533;  ///< Standard deviation / mean |x - median| of the same.

std::vector<double> Known(std::span<const double> values) {
  std::vector<double> known;
  for (const double value : values) {
    if (!std::isnan(value)) {
      known.push_back(value);
    }
  }
  return known;
}

double RobustDeviation(const std::vector<double>& deviations) {
  const double mad = MedianOf(deviations);
  if (mad > 0) {
    return mad / kMadOfNormal;
  }
  double sum = 0;
  for (const double deviation : deviations) {
    sum += deviation;
  }
  return kMeanOfNormal * sum / static_cast<double>(deviations.size());
}

}  // namespace

double MedianOf(std::span<const double> values) {
  std::vector<double> known = Known(values);
  if (known.empty()) {
    return kNaN;
  }
  std::sort(known.begin(), known.end());
  const size_t middle = known.size() / 2;
  return known.size() % 2 == 1 ? known[middle] : 0.5 * (known[middle - 1] + known[middle]);
}

std::vector<double> RobustZ(std::span<const double> values) {
  std::vector<double> deviations = Known(values);
  std::vector<double> z(values.size(), kNaN);
  if (deviations.size() < 3) {
    return z;
  }
  const double median = MedianOf(values);
  for (double& value : deviations) {
    value = std::abs(value - median);
  }
  const double deviation = RobustDeviation(deviations);
  for (size_t i = 0; i < values.size(); ++i) {
    if (!std::isnan(values[i])) {
      z[i] = deviation > 0 ? (values[i] - median) / deviation : 0;
    }
  }
  return z;
}

std::vector<double> MeanDistances(const MetricMatrix& matrix) {
  std::vector<double> means;
  for (Eigen::Index row = 0; row < matrix.values.rows(); ++row) {
    double sum = 0;
    int64_t count = 0;
    for (Eigen::Index column = 0; column < matrix.values.cols(); ++column) {
      if (column != row && !std::isnan(matrix.values(row, column))) {
        sum += matrix.values(row, column);
        ++count;
      }
    }
    means.push_back(count > 0 ? sum / static_cast<double>(count) : kNaN);
  }
  return means;
}

}  // namespace cohort
