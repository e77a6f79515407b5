#include "common/geometry/registration/scaling_icp.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "common/geometry/registration/anderson.h"
#include "common/geometry/registration/paired_sums.h"

namespace cohort {
namespace {

constexpr int kLanes = PackedMesh::kLanes;

/// A fit whose scale is further than this factor from the start has collapsed: all vertices were
/// drawn to a few of the target.
constexpr double kLargestScaleChange = 10.0;

/// The rigid motion that comes first need not be exact.
constexpr double kRigidTolerance = 0.02;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// How far the moved source is from the target.
struct Distances {
  double error = kInfinity;  ///< That never rises.
  double mean = 0;
  double rms = 0;
};

/// One alignment while it runs. The similarities in here map the centred source to the centred
/// target.
class IcpRun {
 public:
  IcpRun(const IcpMesh& source,
         const IcpMesh& target,
         const IcpOptions& options,
         PacketSearch& search)
      : source_(source),
        target_(target),
        options_(options),
        search_(search),
        counts_all_(options.trimmed_share == 0 && options.distance_limit == 0 &&
                    (options.boundary_pairs == BoundaryPairs::kKeep || !target.HasBoundary())),
        kept_(AllVertices(source.Packed())) {}

  /// Finds the nearest vertices of the source at `pose`; the pairs stay until the next call.
  absl::StatusOr<Distances> LookUp(const Similarity& pose) {
    const SearchSeed seed = passes_ == 0 ? SearchSeed::kDescent : SearchSeed::kPrevious;
    const PointTransform transform = ToTransform(pose);
    if (counts_all_) {
      sums_ =
          search_.FindMovedAndSum(source_.Packed(), transform, target_.Packed(), seed, nearest_);
    } else {
      search_.FindMoved(source_.Packed(), transform, target_.Packed(), seed, nearest_);
      RejectPairs(pose);
      sums_ =
          search_.Sum(source_.Packed(), target_.Packed(), nearest_, {kept_.data(), kept_.size()});
    }
    ++passes_;
    if (sums_.count < 3) {
      return absl::FailedPreconditionError(absl::StrCat("ICP: ", sums_.count, " pairs of ",
                                                        source_.Packed().VertexCount(),
                                                        " vertices count, 3 are needed"));
    }
    return Measure(pose);
  }

  /// Best similarity to the vertices found last, from the untouched source.
  [[nodiscard]] absl::StatusOr<Similarity> Fit(const ScaleRule& rule) const {
    return PairedSums(sums_).Fit(rule);
  }

  /// RMS distance of the source from its centroid.
  [[nodiscard]] double Radius() const {
    return std::sqrt(sums_.aa / static_cast<double>(sums_.count));
  }
  [[nodiscard]] int Passes() const { return passes_; }

  /// Residuals of the vertices found last, shares.
  void Report(const Similarity& pose, Alignment& alignment) const {
    double sum = 0;
    double sum_of_squares = 0;
    int64_t beyond = 0;
    for (int slot = 0; slot < source_.Packed().VertexCount(); ++slot) {
      const int nearest = nearest_.slots[static_cast<size_t>(slot)];
      beyond += target_.HasBoundary() && target_.IsSlotOnBoundary(nearest) ? 1 : 0;
      if ((kept_[static_cast<size_t>(slot / kLanes)] >> (slot % kLanes) & 1) == 0) {
        continue;
      }
      const double squared = (pose.ApplyToPoint(source_.Packed().PointOfSlot(slot).cast<double>()) -
                              target_.Packed().PointOfSlot(nearest).cast<double>())
                                 .squaredNorm();
      sum += std::sqrt(squared);
      sum_of_squares += squared;
    }
    const auto n = static_cast<double>(sums_.count);
    const auto vertices = static_cast<double>(source_.Packed().VertexCount());
    alignment.mean_residual = sum / n;
    alignment.rms_residual = std::sqrt(sum_of_squares / n);
    alignment.kept_share = n / vertices;
    alignment.overlap = 1 - static_cast<double>(beyond) / vertices;
    alignment.iterations = passes_;
    alignment.lookups = passes_ * int64_t{source_.Packed().VertexCount()};
  }

 private:
  /// Marks the pairs that count.
  void RejectPairs(const Similarity& pose) {
    const int vertices = source_.Packed().VertexCount();
    const float limit = LargestSquaredDistance(pose);
    const bool drops_boundary =
        options_.boundary_pairs == BoundaryPairs::kReject && target_.HasBoundary();
    kept_ = AllVertices(source_.Packed());
    for (int slot = 0; slot < vertices; ++slot) {
      const auto s = static_cast<size_t>(slot);
      if (nearest_.squared_distances[s] > limit ||
          (drops_boundary && target_.IsSlotOnBoundary(nearest_.slots[s]))) {
        kept_[s / kLanes] = static_cast<uint16_t>(kept_[s / kLanes] & ~(1U << (s % kLanes)));
      }
    }
  }

  /// Squared error that a pair too far apart is charged with: what one at the limit costs, so that
  /// none is dropped for gain.
  [[nodiscard]] double SquaredLimit(const Similarity& pose) const {
    return options_.distance_limit * options_.distance_limit * ErrorUnit(pose);
  }
  /// What squared distances are divided by.
  [[nodiscard]] double ErrorUnit(const Similarity& pose) const {
    return options_.scale_mode == ScaleMode::kSymmetric ? pose.scale : 1;
  }

  [[nodiscard]] float LargestSquaredDistance(const Similarity& pose) {
    const auto vertices = static_cast<size_t>(source_.Packed().VertexCount());
    float limit = std::numeric_limits<float>::infinity();
    if (options_.distance_limit > 0) {
      limit = static_cast<float>(SquaredLimit(pose));
    }
    if (options_.trimmed_share > 0) {
      sorted_.assign(nearest_.squared_distances.data(),
                     nearest_.squared_distances.data() + vertices);
      const auto kept = static_cast<std::ptrdiff_t>(
          std::ceil((1 - options_.trimmed_share) * static_cast<double>(vertices)));
      const auto last = sorted_.begin() + std::max(kept, std::ptrdiff_t{1}) - 1;
      std::nth_element(sorted_.begin(), last, sorted_.end());
      limit = std::min(limit, *last);
    }
    return limit;
  }

  [[nodiscard]] Distances Measure(const Similarity& pose) const {
    const auto n = static_cast<double>(sums_.count);
    Distances distances;
    distances.mean = sums_.distance / n;
    distances.rms = std::sqrt(sums_.squared_distance / n);
    distances.error = sums_.squared_distance / n;
    if (options_.distance_limit > 0) {
      const auto all = static_cast<double>(source_.Packed().VertexCount());
      distances.error = (sums_.squared_distance + (all - n) * SquaredLimit(pose)) / all;
    }
    distances.error /= ErrorUnit(pose);
    return distances;
  }

  const IcpMesh& source_;
  const IcpMesh& target_;
  const IcpOptions& options_;
  PacketSearch& search_;
  const bool counts_all_;
  AlignedArray<uint16_t> kept_;
  NearestSlots nearest_;
  PairSums sums_;
  std::vector<float> sorted_;
  int passes_ = 0;
};

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
