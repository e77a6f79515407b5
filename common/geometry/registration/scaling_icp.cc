#include "common/geometry/registration/scaling_icp.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "common/geometry/registration/anderson.h"
#include "common/geometry/registration/icp_run.h"
#include "common/geometry/registration/paired_sums.h"

namespace cohort {
namespace {

/// A fit whose scale is further than this factor from the start has collapsed: all vertices were
/// drawn to a few of the target.
constexpr double kLargestScaleChange = 10.0;

/// The rigid motion that comes first need not be exact.
constexpr double kRigidTolerance = 0.02;

/// When a phase of the run is over.
struct StopRule {
  double tolerance = 0;           ///< Largest change of the distance.
  double relative_tolerance = 0;  ///< The same, as a share of it.
  double Distances::*distance = &Distances::mean;

  [[nodiscard]] bool Holds(const Distances& before, const Distances& now) const {
    return (tolerance > 0 || relative_tolerance > 0) &&
           std::abs(before.*distance - now.*distance) <=
               std::max(tolerance, relative_tolerance * now.*distance);
  }
};

absl::Status CheckScale(double scale, double start_scale) {
  const double change = scale / start_scale;
  if (change < 1 / kLargestScaleChange || change > kLargestScaleChange) {
    return absl::FailedPreconditionError(
        absl::StrCat("ICP: scale went from ", start_scale, " to ", scale, " (collapse)"));
  }
  return absl::OkStatus();
}

ScaleRule RuleFor(const IcpOptions& options, double start_scale) {
  ScaleRule rule{.mode = options.scale_mode};
  if (options.scale_limit > 0) {
    rule.least = start_scale / options.scale_limit;
    rule.greatest = start_scale * options.scale_limit;
  }
  return rule;
}

/// Passes from `pose` until the stop rule holds (true) or the iterations are used up (false);
/// leaves the last fit in `pose`.
absl::StatusOr<bool> Iterate(const ScaleRule& rule,
                             const StopRule& stop,
                             const IcpOptions& options,
                             IcpRun& run,
                             Similarity& pose,
                             IcpTrace* trace) {
  const double start_scale = rule.mode == ScaleMode::kOff ? rule.fixed : pose.scale;
  Distances best;
  Similarity step = pose;  // The textbook's step from the last pose that was gone on from.
  std::optional<AndersonMixing> mixing;
  bool is_textbook_step = true;
  bool has_converged = false;
  for (bool is_first = true; run.Passes() < options.max_iterations && !has_converged;) {
    COHORT_ASSIGN_OR_RETURN(const Distances distances, run.LookUp(pose));
    if (!is_textbook_step && distances.error > best.error) {
      mixing->Restart();
      pose = step;
      is_textbook_step = true;
      continue;
    }
    if (trace != nullptr) {
      trace->push_back(distances.error);
    }
    has_converged = !is_first && stop.Holds(best, distances);
    is_first = false;
    best = distances;
    COHORT_ASSIGN_OR_RETURN(step, run.Fit(rule));
    COHORT_RETURN_IF_ERROR(CheckScale(step.scale, start_scale));
    if (options.acceleration == Acceleration::kNone || has_converged) {
      pose = step;
      continue;
    }
    if (!mixing.has_value()) {
      mixing.emplace(step, run.Radius());
    }
    pose = mixing->Next(pose, step);
    is_textbook_step = !mixing->HasHistory();
  }
  pose = step;
  return has_converged;
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
  if (!std::isfinite(scale_limit) || (scale_limit != 0 && scale_limit < 1)) {
    return absl::InvalidArgumentError(
        absl::StrCat("ICP: scale_limit is ", scale_limit, ", must be 0 (none) or >= 1"));
  }
  if (!(trimmed_share >= 0 && trimmed_share <= 0.9)) {
    return absl::InvalidArgumentError(
        absl::StrCat("ICP: trimmed_share is ", trimmed_share, ", must be in [0, 0.9]"));
  }
  if (!std::isfinite(distance_limit) || distance_limit < 0) {
    return absl::InvalidArgumentError(
        absl::StrCat("ICP: distance_limit is ", distance_limit, ", must be >= 0 (0: none)"));
  }
  if (correspondence == Correspondence::kSurface && boundary_pairs == BoundaryPairs::kReject) {
    return absl::InvalidArgumentError(
        "ICP: boundary pairs can be rejected with vertex correspondences only");
  }
  return absl::OkStatus();
}

absl::StatusOr<Alignment> AlignByIcp(const IcpMesh& source,
                                     const IcpMesh& target,
                                     const Similarity& T_target_source,
                                     const IcpOptions& options,
                                     PacketSearch& search,
                                     IcpTrace* trace) {
  COHORT_RETURN_IF_ERROR(options.Validate());
  if (source.Packed().VertexCount() < 3) {
    return absl::InvalidArgumentError(
        absl::StrCat("ICP: source has ", source.Packed().VertexCount(), " vertices, needs >= 3"));
  }
  if (options.correspondence == Correspondence::kSurface && target.Surface() == nullptr) {
    return absl::FailedPreconditionError(
        "ICP: surface correspondences need faces, the target is a point cloud");
  }
  IcpRun run(source, target, options, search);
  Similarity pose = T_target_source;
  pose.translation = T_target_source.ApplyToPoint(source.Center()) - target.Center();
  if (options.scale_mode != ScaleMode::kOff && options.rigid_first) {
    COHORT_RETURN_IF_ERROR(Iterate({.mode = ScaleMode::kOff, .fixed = pose.scale},
                                   {.relative_tolerance = kRigidTolerance}, options, run, pose,
                                   trace)
                               .status());
  }
  Alignment alignment;
  const StopRule stop = {
      .tolerance = options.tolerance,
      .distance = options.acceleration == Acceleration::kNone ? &Distances::mean : &Distances::rms};
  const ScaleRule rule = RuleFor(options, pose.scale);
  COHORT_ASSIGN_OR_RETURN(alignment.converged, Iterate(rule, stop, options, run, pose, trace));
  run.Report(pose, alignment);
  alignment.at_scale_limit = options.scale_mode != ScaleMode::kOff &&
                             (pose.scale == rule.least || pose.scale == rule.greatest);
  alignment.T_target_source = pose;
  alignment.T_target_source.translation = pose.ApplyToPoint(-source.Center()) + target.Center();
  return alignment;
}

}  // namespace cohort
