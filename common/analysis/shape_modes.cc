#include "common/analysis/shape_modes.h"

#include <algorithm>
#include <cmath>

#include <absl/strings/str_cat.h>
#include <Eigen/Eigenvalues>

namespace cohort {
namespace {

/// Of the largest variance: what rounding leaves of none.
constexpr double kZeroShare = 1e-10;
constexpr double kSameMagnitude = 1 - 1e-6;

absl::Status Check(const std::vector<Eigen::Matrix3Xf>& displacements,
                   Eigen::Index vertices,
                   int count) {
  if (count < 1) {
    return absl::InvalidArgumentError(absl::StrCat("shape modes: ", count, " asked, at least 1"));
  }
  if (displacements.size() < 2) {
    return absl::InvalidArgumentError(
        absl::StrCat("shape modes: ", displacements.size(), " shapes, at least 2"));
  }
  for (const Eigen::Matrix3Xf& shape : displacements) {
    if (shape.cols() != vertices) {
      return absl::InvalidArgumentError(absl::StrCat("shape modes: a shape of ", shape.cols(),
                                                     " vertices among those of ", vertices));
    }
  }
  return absl::OkStatus();
}

/// Inner products of the shapes less their mean, divided by the vertices.
Eigen::MatrixXd CentredProducts(const std::vector<Eigen::Matrix3Xf>& displacements,
                                const Eigen::Matrix3Xd& mean) {
  const auto n = std::ssize(displacements);
  Eigen::MatrixXd products(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Eigen::Matrix3Xd centred = displacements[static_cast<size_t>(i)].cast<double>() - mean;
    for (Eigen::Index j = 0; j <= i; ++j) {
      const Eigen::Matrix3Xf& other = displacements[static_cast<size_t>(j)];
      products(i, j) = centred.cwiseProduct(other.cast<double>() - mean).sum();
      products(j, i) = products(i, j);
    }
  }
  return products / static_cast<double>(mean.cols());
}

/// 1 or -1, such that the largest entry becomes positive.
double SignOf(const Eigen::VectorXd& scores) {
  const double largest = scores.cwiseAbs().maxCoeff();
  for (const double score : scores) {
    if (std::abs(score) >= kSameMagnitude * largest) {
      return score < 0 ? -1 : 1;
    }
  }
  return 1;
}

}  // namespace

absl::StatusOr<ShapeModes> FindShapeModes(const std::vector<Eigen::Matrix3Xf>& displacements,
                                          const Eigen::Ref<const Eigen::Matrix3Xd>& common,
                                          int count) {
  if (absl::Status checked = Check(displacements, common.cols(), count); !checked.ok()) {
    return checked;
  }
  const auto n = std::ssize(displacements);
  Eigen::Matrix3Xd mean = Eigen::Matrix3Xd::Zero(3, common.cols());
  for (const Eigen::Matrix3Xf& shape : displacements) {
    mean += shape.cast<double>();
  }
  mean /= static_cast<double>(n);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(CentredProducts(displacements, mean));
  if (solver.info() != Eigen::Success) {
    return absl::InternalError("shape modes: the eigenvalues were not found");
  }
  const Eigen::VectorXd& ascending = solver.eigenvalues();
  ShapeModes found;
  found.mean = common + mean;
  const double freedom = static_cast<double>(n - 1);
  found.total_variance = ascending.cwiseMax(0).sum() / freedom;
  const double largest = ascending(n - 1);
  const auto kept = static_cast<Eigen::Index>(
      std::count_if(ascending.begin(), ascending.end(),
                    [&](double value) { return value > kZeroShare * largest && value > 0; }));
  const Eigen::Index k = std::min<Eigen::Index>(kept, count);
  found.scores.resize(n, k);
  for (Eigen::Index mode = 0; mode < k; ++mode) {
    const Eigen::Index at = n - 1 - mode;
    const double length = std::sqrt(ascending(at));
    Eigen::VectorXd scores = solver.eigenvectors().col(at) * length;
    scores *= SignOf(scores);
    Eigen::Matrix3Xd direction = Eigen::Matrix3Xd::Zero(3, common.cols());
    for (Eigen::Index i = 0; i < n; ++i) {
      direction += (displacements[static_cast<size_t>(i)].cast<double>() - mean) *
                   (scores(i) / ascending(at));
    }
    found.scores.col(mode) = scores;
    found.modes.push_back(std::move(direction));
    found.deviations.push_back(std::sqrt(ascending(at) / freedom));
    found.explained.push_back(ascending(at) / freedom / found.total_variance);
  }
  return found;
}

}  // namespace cohort
