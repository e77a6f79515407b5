#include "common/analysis/ordination.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

#include <absl/strings/str_cat.h>

#include "common/analysis/distances.h"
#include "common/base/status_macros.h"

namespace cohort {
namespace {

/// Of the largest eigenvalue: what rounding leaves of a zero one.
constexpr double kZeroShare = 1e-10;
constexpr double kSameMagnitude = 1 - 1e-6;

/// -1/2 J D^2 J with J = I - 1/N: rows and columns have mean zero.
Eigen::MatrixXd DoublyCentred(const RowMajorMatrix& distances) {
  Eigen::MatrixXd B = -0.5 * distances.cwiseAbs2();
  B.diagonal().setZero();  // It may be missing.
  const Eigen::VectorXd means = B.rowwise().mean();
  const double mean = means.mean();
  B.colwise() -= means;
  B.rowwise() -= means.transpose();
  B.array() += mean;
  return B;
}

void FixSign(Eigen::Ref<Eigen::VectorXd> axis) {
  const double largest = axis.cwiseAbs().maxCoeff();
  for (const double coordinate : axis) {
    if (std::abs(coordinate) >= kSameMagnitude * largest) {
      if (coordinate < 0) {
        axis = -axis;
      }
      return;
    }
  }
}

}  // namespace

absl::StatusOr<Ordination> OrdinateMeshes(const MetricMatrix& distances, int axes) {
  if (axes < 1) {
    return absl::InvalidArgumentError(absl::StrCat("ordination: ", axes, " axes, at least 1"));
  }
  COHORT_RETURN_IF_ERROR(RequireDissimilarities(distances, 3));
  COHORT_RETURN_IF_ERROR(RequireComplete(distances));
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(DoublyCentred(distances.values));
  if (solver.info() != Eigen::Success) {
    return absl::InternalError("ordination: the eigenvalues were not found");
  }
  const Eigen::VectorXd& ascending = solver.eigenvalues();
  const Eigen::Index count = ascending.size();
  Ordination ordination;
  ordination.eigenvalues.assign(ascending.data(), ascending.data() + count);
  std::reverse(ordination.eigenvalues.begin(), ordination.eigenvalues.end());
  const double zero = kZeroShare * ascending.cwiseAbs().maxCoeff();
  ordination.negative = (ascending.array() < -zero).count();
  const double positive_sum = (ascending.array() > zero).select(ascending, 0).sum();
  const double negative_sum = (ascending.array() < -zero).select(ascending, 0).sum();
  ordination.negative_share = zero > 0 ? -negative_sum / (positive_sum - negative_sum) : 0;
  const Eigen::Index kept =
      std::min(Eigen::Index{axes}, Eigen::Index{(ascending.array() > zero).count()});
  ordination.coordinates.resize(count, kept);
  for (Eigen::Index axis = 0; axis < kept; ++axis) {
    const Eigen::Index from_end = count - 1 - axis;
    ordination.coordinates.col(axis) =
        solver.eigenvectors().col(from_end) * std::sqrt(ascending(from_end));
    FixSign(ordination.coordinates.col(axis));
    ordination.explained.push_back(ascending(from_end) / positive_sum);
  }
  return ordination;
}

}  // namespace cohort
