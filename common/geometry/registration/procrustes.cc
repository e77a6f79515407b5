#include "common/geometry/registration/procrustes.h"

#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/SVD>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "common/geometry/mesh/bounds.h"
#include "common/geometry/registration/paired_sums.h"

namespace cohort {
namespace {

constexpr double kFidentisSize = 200;

// The sums are plain loops: Eigen's reductions change their order with the instruction set.

/// sqrt(sum |a_i - b_i|^2), 3 x k each.
double Distance(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b) {
  double sum = 0;
  for (Eigen::Index i = 0; i < a.cols(); ++i) {
    sum += (a.col(i) - b.col(i)).squaredNorm();
  }
  return std::sqrt(sum);
}

/// About the centroid.
double CentroidSize(const Eigen::Matrix3Xd& points) {
  const Eigen::Vector3d centroid = CentroidOf(points);
  return Distance(points, centroid.replicate(1, points.cols()));
}

Eigen::Matrix3Xd Rotated(const Eigen::Matrix3d& R, const Eigen::Matrix3Xd& points) {
  Eigen::Matrix3Xd rotated(3, points.cols());
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    rotated.col(i) = R * points.col(i);
  }
  return rotated;
}

Eigen::Matrix3Xd MeanOf(const std::vector<Eigen::Matrix3Xd>& configurations) {
  Eigen::Matrix3Xd mean = Eigen::Matrix3Xd::Zero(3, configurations.front().cols());
  for (const Eigen::Matrix3Xd& configuration : configurations) {
    mean += configuration;
  }
  return mean / static_cast<double>(configurations.size());
}

/// The proper rotation that minimises |R a - b|; both centred.
absl::StatusOr<Eigen::Matrix3d> BestRotation(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b) {
  PairedSums sums;
  for (Eigen::Index i = 0; i < a.cols(); ++i) {
    sums.Add(a.col(i), b.col(i));
  }
  COHORT_ASSIGN_OR_RETURN(const Similarity T, sums.Fit(ScaleMode::kOff));
  return T.rotation;
}

/// Row and column of each pair with its own best rotation.
absl::Status SetPairDistances(const std::vector<Eigen::Matrix3Xd>& configurations,
                              Eigen::MatrixXd& distances) {
  const auto count = static_cast<Eigen::Index>(configurations.size());
  distances = Eigen::MatrixXd::Zero(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index j = i + 1; j < count; ++j) {
      const Eigen::Matrix3Xd& a = configurations[static_cast<size_t>(i)];
      const Eigen::Matrix3Xd& b = configurations[static_cast<size_t>(j)];
      COHORT_ASSIGN_OR_RETURN(const Eigen::Matrix3d R, BestRotation(a, b));
      distances(i, j) = distances(j, i) = Distance(Rotated(R, a), b);
    }
  }
  return absl::OkStatus();
}

/// Index of the smallest sum of squared distances; the lowest of equal ones.
Eigen::Index Medoid(const Eigen::MatrixXd& distances) {
  Eigen::Index medoid = 0;
  double least = std::numeric_limits<double>::infinity();
  for (Eigen::Index i = 0; i < distances.rows(); ++i) {
    double sum = 0;
    for (Eigen::Index j = 0; j < distances.cols(); ++j) {
      sum += distances(i, j) * distances(i, j);
    }
    if (sum < least) {
      least = sum;
      medoid = i;
    }
  }
  return medoid;
}

/// Centred, and brought to size 1 if sizes are normalised.
std::vector<Eigen::Matrix3Xd> CentredConfigurations(const std::vector<Eigen::Matrix3Xd>& points,
                                                    const Eigen::VectorXd& sizes,
                                                    ProcrustesSize size) {
  std::vector<Eigen::Matrix3Xd> centred;
  for (size_t s = 0; s < points.size(); ++s) {
    const double divisor =
        size == ProcrustesSize::kNormalized ? sizes(static_cast<Eigen::Index>(s)) : 1.0;
    centred.emplace_back((points[s].colwise() - CentroidOf(points[s])) / divisor);
  }
  return centred;
}

absl::Status AnalyzeExactly(const std::vector<Eigen::Matrix3Xd>& points,
                            const ProcrustesOptions& options,
                            ProcrustesAnalysis& analysis) {
  const std::vector<Eigen::Matrix3Xd> given =
      CentredConfigurations(points, analysis.centroid_sizes, options.size);
  COHORT_RETURN_IF_ERROR(SetPairDistances(given, analysis.distances));
  const Eigen::Matrix3Xd& start = given[static_cast<size_t>(Medoid(analysis.distances))];
  Eigen::Matrix3Xd consensus = start;
  analysis.aligned = given;
  while (!analysis.converged && analysis.iterations < options.max_iterations) {
    for (size_t s = 0; s < given.size(); ++s) {
      COHORT_ASSIGN_OR_RETURN(const Eigen::Matrix3d R, BestRotation(given[s], consensus));
      analysis.aligned[s] = Rotated(R, given[s]);
    }
    Eigen::Matrix3Xd mean = MeanOf(analysis.aligned);
    // Turned back onto the start: the mean of rotated sets may drift about without changing shape.
    COHORT_ASSIGN_OR_RETURN(const Eigen::Matrix3d R, BestRotation(mean, start));
    mean = Rotated(R, mean);
    if (options.size == ProcrustesSize::kNormalized) {
      mean /= CentroidSize(mean);
    }
    ++analysis.iterations;
    analysis.converged = Distance(mean, consensus) <= options.tolerance * CentroidSize(mean);
    consensus = mean;
  }
  for (size_t s = 0; s < given.size(); ++s) {
    COHORT_ASSIGN_OR_RETURN(const Eigen::Matrix3d R, BestRotation(given[s], consensus));
    analysis.aligned[s] = Rotated(R, given[s]);
  }
  analysis.consensus = std::move(consensus);
  return absl::OkStatus();
}

/// Orthogonal matrix, perhaps a reflection, that minimises |R a - b| about the origin (c9: V U^T).
Eigen::Matrix3d FidentisRotation(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b) {
  Eigen::Matrix3d S = Eigen::Matrix3d::Zero();
  for (Eigen::Index i = 0; i < a.cols(); ++i) {
    S += b.col(i) * a.col(i).transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(S, Eigen::ComputeFullU | Eigen::ComputeFullV);
  return svd.matrixU() * svd.matrixV().transpose();
}

void AnalyzeAsFidentis(const std::vector<Eigen::Matrix3Xd>& points,
                       const ProcrustesOptions& options,
                       ProcrustesAnalysis& analysis) {
  const bool normalized = options.size == ProcrustesSize::kNormalized;
  const double unit = normalized ? kFidentisSize : 1.0;
  analysis.aligned = points;
  for (size_t s = 0; s < points.size() && normalized; ++s) {
    analysis.aligned[s] *= kFidentisSize / analysis.centroid_sizes(static_cast<Eigen::Index>(s));
  }
  Eigen::Matrix3Xd consensus = analysis.aligned.front();
  double last_change = std::numeric_limits<double>::infinity();
  bool grows = false;
  while (!analysis.converged && !grows && analysis.iterations < options.max_iterations) {
    for (Eigen::Matrix3Xd& configuration : analysis.aligned) {
      configuration = Rotated(FidentisRotation(configuration, consensus), configuration);
    }
    const Eigen::Matrix3Xd mean = MeanOf(analysis.aligned);
    const double change = Distance(mean, consensus) / unit;
    ++analysis.iterations;
    analysis.converged = change <= options.fidentis_threshold;
    grows = change > last_change;
    last_change = change;
    consensus = mean;
  }
  analysis.consensus = std::move(consensus);
  const auto count = static_cast<Eigen::Index>(points.size());
  analysis.distances = Eigen::MatrixXd::Zero(count, count);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index j = i + 1; j < count; ++j) {
      analysis.distances(i, j) = analysis.distances(j, i) =
          Distance(analysis.aligned[static_cast<size_t>(i)],
                   analysis.aligned[static_cast<size_t>(j)]) /
          unit;
    }
  }
}

}  // namespace

absl::Status ProcrustesOptions::Validate() const {
  if (!(tolerance >= 0) || !std::isfinite(tolerance)) {
    return absl::InvalidArgumentError(
        absl::StrCat("Procrustes analysis: tolerance ", tolerance, "; it must be >= 0"));
  }
  if (max_iterations < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("Procrustes analysis: ", max_iterations, " iterations; at least 1"));
  }
  if (!(fidentis_threshold >= 0) || !std::isfinite(fidentis_threshold)) {
    return absl::InvalidArgumentError(
        absl::StrCat("Procrustes analysis: threshold ", fidentis_threshold, "; it must be >= 0"));
  }
  return absl::OkStatus();
}

absl::StatusOr<ProcrustesAnalysis> AnalyzeProcrustes(std::span<const LandmarkSet> sets,
                                                     const ProcrustesOptions& options) {
  COHORT_RETURN_IF_ERROR(options.Validate());
  ProcrustesAnalysis analysis;
  analysis.names = CommonLandmarks(sets);
  if (analysis.names.size() < 3) {
    return absl::InvalidArgumentError(absl::StrCat("Procrustes analysis: the ", sets.size(),
                                                   " sets have ", analysis.names.size(),
                                                   " landmarks in common, 3 are needed"));
  }
  const auto count = static_cast<Eigen::Index>(sets.size());
  std::vector<Eigen::Matrix3Xd> points;
  analysis.centroid_sizes.resize(count);
  for (Eigen::Index s = 0; s < count; ++s) {
    points.push_back(PointsOf(sets[static_cast<size_t>(s)], analysis.names));
    analysis.centroid_sizes(s) = CentroidSize(points.back());
    if (!(analysis.centroid_sizes(s) > 1e-14 * points.back().cwiseAbs().maxCoeff())) {
      return absl::FailedPreconditionError(
          absl::StrCat("Procrustes analysis: the common landmarks of set ", s, " coincide"));
    }
  }
  if (options.variant == ProcrustesOptions::Variant::kFidentis) {
    AnalyzeAsFidentis(points, options, analysis);
  } else {
    COHORT_RETURN_IF_ERROR(AnalyzeExactly(points, options, analysis));
  }
  const bool in_fidentis_units = options.variant == ProcrustesOptions::Variant::kFidentis &&
                                 options.size == ProcrustesSize::kNormalized;
  analysis.distances_to_mean.resize(count);
  for (Eigen::Index s = 0; s < count; ++s) {
    analysis.distances_to_mean(s) =
        Distance(analysis.aligned[static_cast<size_t>(s)], analysis.consensus) /
        (in_fidentis_units ? kFidentisSize : 1.0);
  }
  return analysis;
}

}  // namespace cohort
