#include "common/geometry/registration/scaling_icp.h"

#include <cmath>
#include <cstddef>
#include <vector>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "common/geometry/mesh/bounds.h"
#include "common/geometry/registration/paired_sums.h"

namespace cohort {
namespace {

/// A fit whose scale is further than this factor from the start has collapsed: all vertices were
/// drawn to a few of the target.
constexpr double kLargestScaleChange = 10.0;

/// One alignment while it runs. Source and target are centred: the similarity kept here maps
/// A = source - mean to target - Center().
class IcpRun {
 public:
  IcpRun(const Eigen::Ref<const Eigen::Matrix3Xd>& source,
         const IcpTarget& target,
         const Similarity& T_target_source)
      : target_(target),
        source_mean_(CentroidOf(source)),
        A_(source.colwise() - source_mean_),
        T_(T_target_source),
        queries_(3, source.cols()),
        nearest_(static_cast<size_t>(source.cols())),
        squared_distances_(static_cast<size_t>(source.cols())) {
    T_.translation = T_target_source.ApplyToPoint(source_mean_) - target.Center();
  }

  /// Nearest vertices of the source as T places it. Returns their mean distance.
  double LookUp() {
    const Eigen::Matrix3d sR = T_.scale * T_.rotation;
    for (Eigen::Index i = 0; i < A_.cols(); ++i) {
      const Eigen::Vector3d moved = sR * A_.col(i) + T_.translation;
      queries_.col(i) = moved.cast<float>();
    }
    target_.Index().Find(queries_, nearest_, squared_distances_);
    double sum = 0;
    for (const float squared_distance : squared_distances_) {
      sum += double{std::sqrt(squared_distance)};
    }
    return sum / static_cast<double>(A_.cols());
  }

  /// Least-squares similarity to the vertices found last, from the untouched source.
  absl::Status Refit(ScaleMode scale_mode) {
    PairedSums sums;
    for (Eigen::Index i = 0; i < A_.cols(); ++i) {
      sums.Add(A_.col(i), NearestOf(i));
    }
    COHORT_ASSIGN_OR_RETURN(T_, sums.Fit(scale_mode));
    return absl::OkStatus();
  }

  [[nodiscard]] double Scale() const { return T_.scale; }

  /// Similarity in the caller's frames, residuals of the vertices found last.
  void Finish(Alignment& alignment) const {
    double sum = 0;
    double sum_of_squares = 0;
    for (Eigen::Index i = 0; i < A_.cols(); ++i) {
      const double squared = (T_.ApplyToPoint(A_.col(i)) - NearestOf(i)).squaredNorm();
      sum += std::sqrt(squared);
      sum_of_squares += squared;
    }
    const auto n = static_cast<double>(A_.cols());
    alignment.mean_residual = sum / n;
    alignment.rms_residual = std::sqrt(sum_of_squares / n);
    alignment.T_target_source = T_;
    alignment.T_target_source.translation = T_.ApplyToPoint(-source_mean_) + target_.Center();
  }

 private:
  [[nodiscard]] Eigen::Vector3d NearestOf(Eigen::Index i) const {
    return target_.Index().Vertices().col(nearest_[static_cast<size_t>(i)]).cast<double>();
  }

  const IcpTarget& target_;
  const Eigen::Vector3d source_mean_;
  const Eigen::Matrix3Xd A_;
  Similarity T_;
  Eigen::Matrix3Xf queries_;
  std::vector<int32_t> nearest_;
  std::vector<float> squared_distances_;
};

absl::Status CheckScale(double scale, double start_scale) {
  const double change = scale / start_scale;
  if (change < 1 / kLargestScaleChange || change > kLargestScaleChange) {
    return absl::FailedPreconditionError(
        absl::StrCat("ICP: scale went from ", start_scale, " to ", scale, " (collapse)"));
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status IcpOptions::Validate() const {
  if (max_iterations < 1) {
    return absl::InvalidArgumentError(
        absl::StrCat("ICP: max_iterations is ", max_iterations, ", must be >= 1"));
  }
  if (!std::isfinite(tolerance) || tolerance < 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("ICP: tolerance is ", tolerance, ", must be >= 0"));
  }
  return absl::OkStatus();
}

IcpTarget::IcpTarget(const Eigen::Ref<const Eigen::Matrix3Xd>& vertices)
    : center_(CentroidOf(vertices)),
      index_(NearestVertex::Build((vertices.colwise() - center_).cast<float>())) {}

absl::StatusOr<Alignment> AlignByIcp(const Eigen::Ref<const Eigen::Matrix3Xd>& source,
                                     const IcpTarget& target,
                                     const Similarity& T_target_source,
                                     const IcpOptions& options) {
  COHORT_RETURN_IF_ERROR(options.Validate());
  if (source.cols() < 3) {
    return absl::InvalidArgumentError(
        absl::StrCat("ICP: source has ", source.cols(), " vertices, needs >= 3"));
  }
  IcpRun run(source, target, T_target_source);
  // A rigid run has scale 1 from its first fit on, whatever the start.
  const double start_scale = options.scale_mode == ScaleMode::kOff ? 1.0 : T_target_source.scale;
  Alignment alignment;
  double previous_mean = 0;
  while (alignment.iterations < options.max_iterations && !alignment.converged) {
    const double mean = run.LookUp();
    COHORT_RETURN_IF_ERROR(run.Refit(options.scale_mode));
    COHORT_RETURN_IF_ERROR(CheckScale(run.Scale(), start_scale));
    alignment.converged = alignment.iterations > 0 && options.tolerance > 0 &&
                          std::abs(previous_mean - mean) <= options.tolerance;
    previous_mean = mean;
    ++alignment.iterations;
  }
  alignment.lookups = alignment.iterations * int64_t{source.cols()};
  run.Finish(alignment);
  return alignment;
}

}  // namespace cohort
