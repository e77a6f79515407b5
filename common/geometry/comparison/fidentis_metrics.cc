#include "common/geometry/comparison/fidentis_metrics.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <limits>

#include <Eigen/Geometry>

#include <absl/strings/str_cat.h>

#include "common/geometry/comparison/stable_log.h"

// The order of operations here is part of the result: where the predecessor mixes float and double,
// so does this.

namespace cohort {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

float CountOf(std::span<const float> values) {
  return static_cast<float>(values.size());
}

/// trunc(share * n - 0.5) as Java's (int): towards zero.
std::ptrdiff_t PlaceOf(double share, size_t n) {
  return static_cast<std::ptrdiff_t>(share * static_cast<double>(n) - 0.5);
}

/// -1, 0, 1 or NaN.
float SignOf(float value) {
  return value > 0 ? 1.0F : value < 0 ? -1.0F : value;
}

float Rms(std::span<const float> values) {
  float sum = 0;
  for (const float value : values) {
    sum += value * value;
  }
  return std::sqrt(sum / CountOf(values));
}

float Mean(std::span<const float> values) {
  float sum = 0;
  for (const float value : values) {
    sum += value;
  }
  return sum / CountOf(values);
}

/// The n-th roots are multiplied one by one, as floats.
float GeometricMean(std::span<const float> values) {
  const float exponent = 1 / CountOf(values);
  float product = 1;
  for (const float value : values) {
    if (value < 0) {
      return kNan;
    }
    product *= static_cast<float>(StableExp(double{exponent} * StableLog(double{value})));
  }
  return product;
}

/// The expectation here is a sum of shares, not the mean of above.
float Variance(std::span<const float> values) {
  const float share = 1 / CountOf(values);
  float expectation = 0;
  for (const float value : values) {
    expectation += value * share;
  }
  if (expectation == 0) {
    return 0;
  }
  float sum = 0;
  for (const float value : values) {
    const auto deviation = double{value - expectation};
    sum = static_cast<float>(double{sum} + deviation * deviation);
  }
  return sum / CountOf(values);
}

float Percentile75(std::span<const float> values) {
  std::vector<float> partly_sorted(values.begin(), values.end());
  const auto place = partly_sorted.begin() + PlaceOf(0.75, values.size());
  std::nth_element(partly_sorted.begin(), place, partly_sorted.end());
  return std::abs(*place);
}

/// Normal of a face with length 1; NaN without area.
Eigen::Vector3f FaceNormal(const Eigen::Ref<const Eigen::Matrix3Xf>& vertices,
                           const Eigen::Vector3i& face) {
  const Eigen::Vector3f edge_1 = vertices.col(face(1)) - vertices.col(face(0));
  const Eigen::Vector3f edge_2 = vertices.col(face(2)) - vertices.col(face(0));
  const Eigen::Vector3f normal = edge_1.cross(edge_2);
  return normal /
         std::sqrt(normal.x() * normal.x() + normal.y() * normal.y() + normal.z() * normal.z());
}

}  // namespace

Eigen::Matrix3Xf FidentisNormals(const Eigen::Ref<const Eigen::Matrix3Xf>& vertices,
                                 const Matrix3Xi& faces) {
  Eigen::Matrix3Xf normals = Eigen::Matrix3Xf::Zero(3, vertices.cols());
  std::vector<float> face_counts(static_cast<size_t>(vertices.cols()));
  for (Eigen::Index f = 0; f < faces.cols(); ++f) {
    const Eigen::Vector3f normal = FaceNormal(vertices, faces.col(f));
    for (const int32_t vertex : faces.col(f)) {
      normals.col(vertex) += normal;
      face_counts[static_cast<size_t>(vertex)] += 1;
    }
  }
  for (Eigen::Index i = 0; i < normals.cols(); ++i) {
    normals.col(i) /= face_counts[static_cast<size_t>(i)];
  }
  return normals;
}

std::vector<float> FidentisSignedDistances(const Eigen::Ref<const Eigen::Matrix3Xf>& vertices,
                                           const Eigen::Ref<const Eigen::Matrix3Xf>& normals,
                                           const NearestVertex& target) {
  assert(normals.cols() == vertices.cols());
  std::vector<int32_t> nearest(static_cast<size_t>(vertices.cols()));
  std::vector<float> distances(nearest.size());
  target.Find(vertices, nearest, distances);
  for (Eigen::Index i = 0; i < vertices.cols(); ++i) {
    const auto at = static_cast<size_t>(i);
    const Eigen::Vector3f step = vertices.col(i) - target.Vertices().col(nearest[at]);
    const Eigen::Vector3d d = step.cast<double>();
    const auto distance =
        static_cast<float>(std::sqrt(d.x() * d.x() + d.y() * d.y() + d.z() * d.z()));
    distances[at] =
        SignOf(step.x() * normals(0, i) + step.y() * normals(1, i) + step.z() * normals(2, i)) *
        distance;
  }
  return distances;
}

std::vector<float> FidentisAbsolute(std::span<const float> signed_distances) {
  std::vector<float> absolute(signed_distances.size());
  std::transform(signed_distances.begin(), signed_distances.end(), absolute.begin(),
                 [](float value) { return std::abs(value); });
  return absolute;
}

absl::Status FidentisThresholds::Validate() const {
  if (!(lower >= 0 && lower <= 1 && upper >= 0 && upper <= 1)) {
    return absl::InvalidArgumentError(
        absl::StrCat("thresholds are ", lower, " and ", upper, "; they must be within 0..1"));
  }
  return absl::OkStatus();
}

std::vector<float> FidentisWindow(std::span<const float> values,
                                  const FidentisThresholds& thresholds) {
  assert(thresholds.Validate().ok());
  std::vector<float> window(values.begin(), values.end());
  if (thresholds.lower == 0 && thresholds.upper == 1) {
    return window;
  }
  if (thresholds.upper <= thresholds.lower) {
    return {0};
  }
  // NaN comes last, as Java sorts it; it would break the order that std::sort needs.
  std::sort(window.begin(), window.end(),
            [](float a, float b) { return a < b || (std::isnan(b) && !std::isnan(a)); });
  return {window.begin() + PlaceOf(thresholds.lower, values.size()),
          window.begin() + PlaceOf(thresholds.upper, values.size())};
}

FidentisMetricValues ComputeFidentisMetrics(std::span<const float> values) {
  FidentisMetricValues metrics{};
  const auto is_nan = [](float value) { return std::isnan(value); };
  if (values.empty() || std::any_of(values.begin(), values.end(), is_nan)) {
    metrics.fill(kNan);
    return metrics;
  }
  return {Rms(values),
          Mean(values),
          GeometricMean(values),
          *std::min_element(values.begin(), values.end()),
          *std::max_element(values.begin(), values.end()),
          Variance(values),
          Percentile75(values)};
}

Eigen::MatrixXf FidentisSymmetric(const Eigen::Ref<const Eigen::MatrixXf>& matrix) {
  assert(matrix.rows() == matrix.cols());
  return (matrix + matrix.transpose()) / 2;
}

}  // namespace cohort
