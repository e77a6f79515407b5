#include "common/geometry/registration/fidentis_icp.h"

#include <cmath>
#include <cstddef>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"

// The order of operations here is part of the result: where the predecessor mixes float and double,
// so does this. Sums are written out, since Eigen may add in another order.

namespace cohort {
namespace {

/// Paired points: column i of `source` (3 x n) has its nearest target vertex in that of `nearest`.
struct Pairs {
  const Eigen::Matrix3Xf& source;
  Eigen::Matrix3Xf nearest;
};

Pairs FindPairs(const Eigen::Matrix3Xf& source, const NearestVertex& target) {
  std::vector<int32_t> indices(static_cast<size_t>(source.cols()));
  std::vector<float> squared_distances(indices.size());
  target.Find(source, indices, squared_distances);
  Pairs pairs{source, Eigen::Matrix3Xf(3, source.cols())};
  for (Eigen::Index i = 0; i < source.cols(); ++i) {
    pairs.nearest.col(i) = target.Vertices().col(indices[static_cast<size_t>(i)]);
  }
  return pairs;
}

/// Mean of the columns, 3 x n.
Eigen::Vector3f MeanOf(const Eigen::Matrix3Xf& points) {
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    sum += points.col(i);
  }
  return sum / static_cast<float>(points.cols());
}

float MeanDistance(const Pairs& pairs) {
  float sum = 0;
  for (Eigen::Index i = 0; i < pairs.source.cols(); ++i) {
    const Eigen::Vector3d d =
        Eigen::Vector3f(pairs.nearest.col(i) - pairs.source.col(i)).cast<double>();
    sum += static_cast<float>(std::sqrt(d.x() * d.x() + d.y() * d.y() + d.z() * d.z()));
  }
  return sum / static_cast<float>(pairs.source.cols());
}

/// Unit quaternion x, y, z, w of the rotation that turns a towards c: the eigenvector of the
/// largest eigenvalue of Horn's matrix, in double, then normalised as floats.
/// @param a, c  3 x n about their centroids.
Eigen::Vector4f RotationBetween(const Eigen::Matrix3Xf& a, const Eigen::Matrix3Xf& c) {
  Eigen::Matrix3d S = Eigen::Matrix3d::Zero();
  for (Eigen::Index i = 0; i < a.cols(); ++i) {
    const Eigen::Vector3d a_i = a.col(i).cast<double>();
    const Eigen::Vector3d c_i = c.col(i).cast<double>();
    S += a_i * c_i.transpose();
  }
  const Eigen::Vector3d delta(S(1, 2) - S(2, 1), S(2, 0) - S(0, 2), S(0, 1) - S(1, 0));
  Eigen::Matrix4d N;  // order x, y, z, w
  N.topLeftCorner<3, 3>() = S + S.transpose() - S.trace() * Eigen::Matrix3d::Identity();
  N.topRightCorner<3, 1>() = delta;
  N.bottomLeftCorner<1, 3>() = delta.transpose();
  N(3, 3) = S.trace();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> eigen(N);
  Eigen::Vector4f q = eigen.eigenvectors().col(3).cast<float>();  // the largest comes last
  if (q.w() < 0) {
    q = -q;
  }
  const float norm = std::sqrt(q.w() * q.w() + q.x() * q.x() + q.y() * q.y() + q.z() * q.z());
  return q * (1 / norm);
}

/// First row of the rotation matrix of a quaternion x, y, z, w.
Eigen::Vector3f RotationRowX(const Eigen::Vector4f& q) {
  return {1 - 2 * q.y() * q.y() - 2 * q.z() * q.z(), 2 * q.x() * q.y() - 2 * q.z() * q.w(),
          2 * q.x() * q.z() + 2 * q.y() * q.w()};
}

/// Scale from the x coordinates of the rotated a and of c, both 3 x n about their centroids.
float ScaleFromX(const Eigen::Matrix3Xf& a, const Eigen::Matrix3Xf& c, const Eigen::Vector4f& q) {
  const Eigen::Vector3d row = RotationRowX(q).cast<double>();
  float sum_cx_ax = 0;
  float sum_ax_ax = 0;
  for (Eigen::Index i = 0; i < a.cols(); ++i) {
    const double rotated_x =
        row.x() * double{a(0, i)} + row.y() * double{a(1, i)} + row.z() * double{a(2, i)};
    sum_cx_ax = static_cast<float>(double{sum_cx_ax} + double{c(0, i)} * rotated_x);
    sum_ax_ax = static_cast<float>(double{sum_ax_ax} + rotated_x * rotated_x);
  }
  return sum_cx_ax / sum_ax_ax;
}

/// Hamilton's product of quaternions x, y, z, w.
Eigen::Vector4f Product(const Eigen::Vector4f& p, const Eigen::Vector4f& q) {
  return {p.w() * q.x() + p.x() * q.w() + p.y() * q.z() - p.z() * q.y(),
          p.w() * q.y() + p.y() * q.w() + p.z() * q.x() - p.x() * q.z(),
          p.w() * q.z() + p.z() * q.w() + p.x() * q.y() - p.y() * q.x(),
          p.w() * q.w() - p.x() * q.x() - p.y() * q.y() - p.z() * q.z()};
}

/// The point goes in as a quaternion with w = 1, which changes nothing but the rounding.
Eigen::Vector3f MovedPoint(const FidentisStep& step, const Eigen::Vector3f& point) {
  const Eigen::Vector4f& q = step.rotation;
  const Eigen::Vector4f conjugate(-q.x(), -q.y(), -q.z(), q.w());
  const Eigen::Vector4f rotated =
      Product(q, Product(Eigen::Vector4f(point.x(), point.y(), point.z(), 1), conjugate));
  return rotated.head<3>() * step.scale + step.translation;
}

FidentisStep FitStep(const Pairs& pairs, FidentisScale scale) {
  const Eigen::Matrix3Xf a = pairs.source.colwise() - MeanOf(pairs.source);
  const Eigen::Matrix3Xf c = pairs.nearest.colwise() - MeanOf(pairs.nearest);
  FidentisStep step;
  step.mean_distance = MeanDistance(pairs);
  step.translation = MeanOf(pairs.nearest - pairs.source);
  step.rotation = RotationBetween(a, c);
  if (scale == FidentisScale::kFromX) {
    step.scale = ScaleFromX(a, c, step.rotation);
  }
  return step;
}

/// What the step does to exact points: q is a unit only up to a rounding, and scales with it.
Similarity SimilarityOf(const FidentisStep& step) {
  const Eigen::Quaterniond q(step.rotation.cast<double>());
  Similarity T;
  T.scale = double{step.scale} * q.squaredNorm();
  T.rotation = q.normalized().toRotationMatrix();
  T.translation = step.translation.cast<double>();
  return T;
}

absl::Status CheckStep(const FidentisStep& step, size_t number) {
  if (!std::isfinite(step.mean_distance) || !step.translation.allFinite() ||
      !step.rotation.allFinite() || !std::isfinite(step.scale) || step.scale <= 0) {
    return absl::FailedPreconditionError(
        absl::StrCat("fidentis ICP, step ", number, ": scale ", step.scale, ", mean distance ",
                     step.mean_distance, ": the mesh has no extent along x, or has collapsed"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status FidentisIcpOptions::Validate() const {
  if (max_iterations < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("max_iterations is ", max_iterations, "; it must be at least 1"));
  }
  if (!(tolerance >= 0) || !std::isfinite(tolerance)) {
    return absl::InvalidArgumentError(
        absl::StrCat("tolerance is ", tolerance, "; it must be 0 or more and finite"));
  }
  return absl::OkStatus();
}

Eigen::Vector3f FidentisCenter(const Eigen::Ref<const Eigen::Matrix3Xd>& vertices) {
  const Eigen::Vector3f low = vertices.rowwise().minCoeff().cast<float>();
  const Eigen::Vector3f high = vertices.rowwise().maxCoeff().cast<float>();
  return (high + low) / 2;
}

Eigen::Matrix3Xf FidentisCentered(const Eigen::Ref<const Eigen::Matrix3Xd>& vertices) {
  const Eigen::Vector3f center = FidentisCenter(vertices);
  return vertices.cast<float>().colwise() - center;
}

absl::StatusOr<FidentisAlignment> AlignByFidentisIcp(
    const Eigen::Ref<const Eigen::Matrix3Xf>& source,
    const NearestVertex& target,
    const FidentisIcpOptions& options) {
  COHORT_RETURN_IF_ERROR(options.Validate());
  if (source.cols() < 3) {
    return absl::InvalidArgumentError(
        absl::StrCat("fidentis ICP: needs at least 3 vertices, got ", source.cols()));
  }
  FidentisAlignment alignment;
  alignment.moved = source;
  const size_t max_steps = static_cast<size_t>(options.max_iterations) + 1;
  while (alignment.steps.size() < max_steps && !alignment.converged) {
    const FidentisStep step = FitStep(FindPairs(alignment.moved, target), options.scale);
    COHORT_RETURN_IF_ERROR(CheckStep(step, alignment.steps.size()));
    for (Eigen::Index i = 0; i < alignment.moved.cols(); ++i) {
      alignment.moved.col(i) = MovedPoint(step, alignment.moved.col(i));
    }
    alignment.T_target_source = SimilarityOf(step) * alignment.T_target_source;
    alignment.lookups += alignment.moved.cols();
    alignment.converged =
        !alignment.steps.empty() &&
        std::abs(alignment.steps.back().mean_distance - step.mean_distance) <= options.tolerance;
    alignment.steps.push_back(step);
  }
  if (!alignment.moved.allFinite()) {
    return absl::FailedPreconditionError(
        absl::StrCat("fidentis ICP: the mesh left the range of float32 after ",
                     alignment.steps.size(), " steps"));
  }
  return alignment;
}

}  // namespace cohort
