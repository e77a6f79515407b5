#include "common/geometry/registration/scaling_icp.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <optional>
#include <span>
#include <utility>
#include <vector>

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
/// The run over a few vertices is off by their scatter, but where it ends must not depend on
/// roundings: from there the run over all goes on.
constexpr double kCoarseTolerance = 1e-5;
/// It takes less to see which of two starts is the better one.
constexpr double kTrialTolerance = 5e-3;
/// Of so many consecutive vertices one: the k-th of them 7 k further in, so that those of a grid do
/// not fall into few of its columns.
constexpr uint32_t kCoarseStride = 16;
constexpr uint32_t kCoarseShift = 7;
constexpr int kFewestCoarseVertices = 64;
/// Starts whose scales differ less are the same.
constexpr double kLeastScaleChange = 0.02;

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
  if (!(change >= 1 / kLargestScaleChange && change <= kLargestScaleChange)) {  // Or NaN.
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

/// Passes with one rule for the scale.
struct Phase {
  ScaleRule rule;
  StopRule stop;
  double start_scale = 1;  ///< What a collapse is judged by.
};

/// How a phase ended.
struct Outcome {
  bool converged = false;  ///< Else the iterations were used up.
  double error = 0;        ///< Before the last fit.
};

/// Passes from `pose` until the stop rule holds; leaves the last fit in `pose`.
absl::StatusOr<Outcome> Iterate(
    const Phase& phase, const IcpOptions& options, IcpRun& run, Similarity& pose, IcpTrace* trace) {
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
    has_converged = !is_first && phase.stop.Holds(best, distances);
    is_first = false;
    best = distances;
    COHORT_ASSIGN_OR_RETURN(step, run.Fit(phase.rule));
    COHORT_RETURN_IF_ERROR(CheckScale(step.scale, phase.start_scale));
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
  return Outcome{.converged = has_converged, .error = best.error};
}

/// Rigid first, if the options ask for it; then with the scale.
absl::StatusOr<Outcome> IterateInPhases(const StopRule& stop,
                                        double start_scale,
                                        const IcpOptions& options,
                                        IcpRun& run,
                                        Similarity& pose,
                                        IcpTrace* trace) {
  if (options.scale_mode != ScaleMode::kOff && options.rigid_first) {
    const Phase rigid = {.rule = {.mode = ScaleMode::kOff, .fixed = pose.scale},
                         .stop = {.relative_tolerance = kRigidTolerance},
                         .start_scale = pose.scale};
    COHORT_RETURN_IF_ERROR(Iterate(rigid, options, run, pose, trace).status());
  }
  const Phase scaled = {
      .rule = RuleFor(options, start_scale), .stop = stop, .start_scale = start_scale};
  return Iterate(scaled, options, run, pose, trace);
}

/// Counting passes means counting them all, and the textbook's run knows no other.
bool StartsCoarse(const IcpMesh& source, const IcpOptions& options) {
  return options.acceleration != Acceleration::kNone && options.tolerance > 0 &&
         source.Packed().VertexCount() >= int{kCoarseStride} * kFewestCoarseVertices;
}

/// The same vertices as seen from another origin: T takes x, the result x + `origin` - `moved_to`.
Similarity WithSourceOrigin(Similarity T,
                            const Eigen::Vector3d& origin,
                            const Eigen::Vector3d& moved_to) {
  T.translation = T.ApplyToPoint(moved_to - origin);
  return T;
}

/// Slots of a sixteenth of the vertices. They follow from the order of the vertices and not from
/// where they lie: a mesh that was turned has the same, and settles in the same place.
std::vector<int> CoarseSlots(const PackedMesh& packed) {
  std::vector<int> slots;
  slots.reserve(static_cast<size_t>(packed.VertexCount()) / kCoarseStride + 1);
  const std::span<const int32_t> vertices = packed.VertexOfSlot();
  for (int slot = 0; slot < packed.VertexCount(); ++slot) {
    const auto vertex = static_cast<uint32_t>(vertices[static_cast<size_t>(slot)]);
    if (vertex % kCoarseStride == vertex / kCoarseStride * kCoarseShift % kCoarseStride) {
      slots.push_back(slot);
    }
  }
  return slots;
}

/// The vertices that stand for all, in the packed frame.
IcpMesh CoarseMesh(const PackedMesh& packed, const std::vector<int>& slots) {
  Eigen::Matrix3Xd chosen(3, std::ssize(slots));
  for (Eigen::Index i = 0; i < chosen.cols(); ++i) {
    chosen.col(i) = packed.PointOfSlot(slots[static_cast<size_t>(i)]).cast<double>();
  }
  return IcpMesh(chosen);
}

/// RMS distance of the vertices from the center, over those that stand for all.
double RadiusOf(const PackedMesh& packed, const std::vector<int>& slots) {
  double sum = 0;
  for (const int slot : slots) {
    sum += packed.PointOfSlot(slot).cast<double>().squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(slots.size()));
}

/// The start, and where the scale is free also the start with the scale that makes the meshes
/// equally large: from the wrong size ICP may settle with a part of one mesh on a part of the
/// other.
std::vector<Similarity> CoarseStarts(double source_radius,
                                     const PackedMesh& target,
                                     const Similarity& pose,
                                     const ScaleRule& rule) {
  std::vector<Similarity> starts = {pose};
  if (rule.mode != ScaleMode::kOff) {
    const double scale = std::clamp(RadiusOf(target, CoarseSlots(target)) / source_radius,
                                    rule.least, rule.greatest);
    const double change = scale / pose.scale;  // NaN or infinite where a mesh has no extent.
    if (CheckScale(scale, pose.scale).ok() && std::abs(change - 1) > kLeastScaleChange) {
      starts.push_back(pose);
      starts.back().scale = scale;
    }
  }
  return starts;
}

/// Brings `pose` near the end at little cost: aligns a sixteenth of the source, the better
/// of the starts to the end.
/// @return false, and `pose` as it was, where those few cannot be aligned.
bool AlignCoarsely(const IcpMesh& source,
                   const IcpMesh& target,
                   const IcpOptions& options,
                   PacketSearch& search,
                   Similarity& pose,
                   int64_t& lookups) {
  const std::vector<int> slots = CoarseSlots(source.Packed());
  const IcpMesh coarse = CoarseMesh(source.Packed(), slots);
  const double radius = RadiusOf(source.Packed(), slots);
  const double start_scale = pose.scale;
  const ScaleRule rule = RuleFor(options, start_scale);
  StopRule stop = {.relative_tolerance = kTrialTolerance, .distance = &Distances::rms};
  std::optional<Similarity> nearest;
  double least_error = std::numeric_limits<double>::infinity();
  for (const Similarity& start : CoarseStarts(radius, target.Packed(), pose, rule)) {
    IcpRun run(coarse, target, options, search);
    Similarity found = WithSourceOrigin(start, Eigen::Vector3d::Zero(), coarse.Center());
    const auto outcome = IterateInPhases(stop, start_scale, options, run, found, nullptr);
    lookups += run.Passes() * int64_t{coarse.Packed().VertexCount()};
    if (outcome.ok() && outcome->error < least_error) {
      least_error = outcome->error;
      nearest = found;
    }
  }
  if (!nearest.has_value()) {
    return false;
  }
  stop.relative_tolerance = kCoarseTolerance;
  IcpRun run(coarse, target, options, search);
  const auto outcome = Iterate({.rule = rule, .stop = stop, .start_scale = start_scale}, options,
                               run, *nearest, nullptr);
  lookups += run.Passes() * int64_t{coarse.Packed().VertexCount()};
  if (outcome.ok()) {
    pose = WithSourceOrigin(*nearest, coarse.Center(), Eigen::Vector3d::Zero());
  }
  return outcome.ok();
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
  Similarity pose = T_target_source;
  pose.translation = T_target_source.ApplyToPoint(source.Center()) - target.Center();
  const double start_scale = pose.scale;
  const ScaleRule rule = RuleFor(options, start_scale);
  const StopRule stop = {
      .tolerance = options.tolerance,
      .distance = options.acceleration == Acceleration::kNone ? &Distances::mean : &Distances::rms};
  Alignment alignment;
  int64_t coarse_lookups = 0;
  const bool is_near = StartsCoarse(source, options) &&
                       AlignCoarsely(source, target, options, search, pose, coarse_lookups);
  IcpRun run(source, target, options, search);
  const absl::StatusOr<Outcome> outcome =
      is_near ? Iterate({.rule = rule, .stop = stop, .start_scale = start_scale}, options, run,
                        pose, trace)
              : IterateInPhases(stop, start_scale, options, run, pose, trace);
  COHORT_RETURN_IF_ERROR(outcome.status());
  alignment.converged = outcome->converged;
  run.Report(pose, alignment);
  alignment.lookups += coarse_lookups;
  alignment.at_scale_limit = options.scale_mode != ScaleMode::kOff &&
                             (pose.scale == rule.least || pose.scale == rule.greatest);
  alignment.T_target_source = pose;
  alignment.T_target_source.translation = pose.ApplyToPoint(-source.Center()) + target.Center();
  return alignment;
}

}  // namespace cohort
