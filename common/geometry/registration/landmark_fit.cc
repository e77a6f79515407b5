#include "common/geometry/registration/landmark_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>

#include <Eigen/Eigenvalues>

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include "common/base/status_macros.h"
#include "common/geometry/mesh/bounds.h"

namespace cohort {
namespace {

constexpr double kOnALineShare = 1e-3;
constexpr size_t kMostNamesListed = 20;

/// "a, b, c" of the names in `there` that `here` lacks, "none" if it lacks none.
std::string NamesMissing(const LandmarkSet& here, const LandmarkSet& there) {
  std::vector<std::string> own = here.names;
  std::vector<std::string> other = there.names;
  std::sort(own.begin(), own.end());
  std::sort(other.begin(), other.end());
  std::vector<std::string> missing;
  std::set_difference(other.begin(), other.end(), own.begin(), own.end(),
                      std::back_inserter(missing));
  if (missing.empty()) {
    return "none";
  }
  const size_t more = missing.size() - std::min(missing.size(), kMostNamesListed);
  missing.resize(missing.size() - more);
  return absl::StrCat(absl::StrJoin(missing, ", "),
                      more > 0 ? absl::StrCat(" and ", more, " more") : "");
}

absl::Status CheckNotOnALine(const Eigen::Matrix3Xd& points, const char* role) {
  const Eigen::Vector3d centroid = CentroidOf(points);
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Vector3d offset = points.col(i) - centroid;
    covariance += offset * offset.transpose();
  }
  const Eigen::Vector3d variances =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance, Eigen::EigenvaluesOnly)
          .eigenvalues();
  if (!(variances(1) > kOnALineShare * kOnALineShare * variances(2))) {
    return absl::FailedPreconditionError(absl::StrCat("landmark fit: the ", points.cols(),
                                                      " common landmarks of the ", role,
                                                      " lie on one line; add one beside it"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<LandmarkFit> FitLandmarks(const LandmarkSet& source,
                                         const LandmarkSet& target,
                                         ScaleMode scale_mode) {
  LandmarkFit fit;
  fit.names = CommonLandmarks(std::array<LandmarkSet, 2>{source, target});
  if (fit.names.size() < 3) {
    return absl::InvalidArgumentError(absl::StrCat(
        "landmark fit: ", fit.names.size(), " common landmarks, 3 are needed; missing in the ",
        "source: ", NamesMissing(source, target),
        "; missing in the target: ", NamesMissing(target, source)));
  }
  const Eigen::Matrix3Xd a = PointsOf(source, fit.names);
  const Eigen::Matrix3Xd b = PointsOf(target, fit.names);
  COHORT_RETURN_IF_ERROR(CheckNotOnALine(a, "source"));
  COHORT_RETURN_IF_ERROR(CheckNotOnALine(b, "target"));
  COHORT_ASSIGN_OR_RETURN(fit.T_target_source, FitSimilarity(a, b, scale_mode));

  fit.residuals.resize(a.cols());
  double sum = 0;
  for (Eigen::Index i = 0; i < a.cols(); ++i) {
    fit.residuals(i) = (fit.T_target_source.ApplyToPoint(a.col(i)) - b.col(i)).norm();
    sum += fit.residuals(i) * fit.residuals(i);
  }
  fit.rms = std::sqrt(sum / static_cast<double>(a.cols()));
  return fit;
}

}  // namespace cohort
