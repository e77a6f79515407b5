#include "common/analysis/ordination.h"

#include <algorithm>
#include <cmath>

#include <absl/strings/str_cat.h>

#include "common/analysis/distances.h"
#include "common/analysis/leading_eigenpairs.h"
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
  const Eigen::MatrixXd B = DoublyCentred(distances.values);
  COHORT_ASSIGN_OR_RETURN(const LeadingEigenpairs pairs,
                          FindLeadingEigenpairs(B, std::min(Eigen::Index{axes}, B.rows())));
  const Eigen::VectorXd& values = pairs.values;
  const double zero = kZeroShare * values.cwiseAbs().maxCoeff();
  const double positive_sum = (values.array() > zero).select(values, 0).sum();
  const double negative_sum = (values.array() < -zero).select(values, 0).sum();
  Ordination ordination;
  ordination.eigenvalues.assign(values.data(), values.data() + values.size());
  ordination.negative = (values.array() < -zero).count();
  ordination.negative_share =
      ordination.negative > 0 ? -negative_sum / (positive_sum - negative_sum) : 0;
  const Eigen::Index positive = (values.array() > zero).count();
  const Eigen::Index kept = std::min(Eigen::Index{axes}, positive);
  ordination.coordinates.resize(B.rows(), kept);
  for (Eigen::Index axis = 0; axis < kept; ++axis) {
    ordination.coordinates.col(axis) = pairs.vectors.col(axis) * std::sqrt(values(axis));
    FixSign(ordination.coordinates.col(axis));
    ordination.explained.push_back(values(axis) / positive_sum);
  }
  return ordination;
}

}  // namespace cohort
