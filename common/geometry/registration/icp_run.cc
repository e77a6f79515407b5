#include "common/geometry/registration/icp_run.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <absl/strings/str_cat.h>

namespace cohort {
namespace {

constexpr int kLanes = PackedMesh::kLanes;

}  // namespace

IcpRun::IcpRun(const IcpMesh& source,
               const IcpMesh& target,
               const IcpOptions& options,
               PacketSearch& search)
    : source_(source),
      target_(target),
      options_(options),
      counts_all_(options.trimmed_share == 0 && options.distance_limit == 0 &&
                  (options.boundary_pairs == BoundaryPairs::kKeep || !target.HasBoundary())),
      pairs_(MakePairFinder(source, target, options.correspondence, search)),
      kept_(AllVertices(source.Packed())) {}

absl::StatusOr<Distances> IcpRun::LookUp(const Similarity& pose) {
  if (counts_all_) {
    sums_ = pairs_->FindAndSum(ToTransform(pose));
  } else {
    pairs_->Find(ToTransform(pose));
    RejectPairs(pose);
    sums_ = pairs_->Sum({kept_.data(), kept_.size()});
  }
  ++passes_;
  if (sums_.count < 3) {
    return absl::FailedPreconditionError(absl::StrCat("ICP: ", sums_.count, " pairs of ",
                                                      source_.Packed().VertexCount(),
                                                      " vertices count, 3 are needed"));
  }
  return Measure(pose);
}

double IcpRun::Radius() const {
  return std::sqrt(sums_.aa / static_cast<double>(sums_.count));
}

void IcpRun::Report(const Similarity& pose, Alignment& alignment) const {
  double sum = 0;
  double sum_of_squares = 0;
  int64_t beyond = 0;
  for (int slot = 0; slot < source_.Packed().VertexCount(); ++slot) {
    beyond += pairs_->IsOnBoundary(slot) ? 1 : 0;
    if ((kept_[static_cast<size_t>(slot / kLanes)] >> (slot % kLanes) & 1) == 0) {
      continue;
    }
    const Eigen::Vector3d moved =
        pose.ApplyToPoint(source_.Packed().PointOfSlot(slot).cast<double>());
    const double squared = (moved - pairs_->PartnerOf(slot)).squaredNorm();
    sum += std::sqrt(squared);
    sum_of_squares += squared;
  }
  const auto n = static_cast<double>(sums_.count);
  const int vertices = source_.Packed().VertexCount();
  alignment.mean_residual = sum / n;
  alignment.rms_residual = std::sqrt(sum_of_squares / n);
  alignment.kept_share = n / vertices;
  alignment.overlap = 1 - static_cast<double>(beyond) / vertices;
  alignment.iterations = passes_;
  alignment.lookups = passes_ * int64_t{vertices};
}

void IcpRun::RejectPairs(const Similarity& pose) {
  const float limit = LargestSquaredDistance(pose);
  const bool drops_boundary =
      options_.boundary_pairs == BoundaryPairs::kReject && target_.HasBoundary();
  const std::span<const float> squared_distances = pairs_->SquaredDistances();
  kept_ = AllVertices(source_.Packed());
  for (int slot = 0; slot < source_.Packed().VertexCount(); ++slot) {
    const auto s = static_cast<size_t>(slot);
    if (squared_distances[s] > limit || (drops_boundary && pairs_->IsOnBoundary(slot))) {
      kept_[s / kLanes] = static_cast<uint16_t>(kept_[s / kLanes] & ~(1U << (s % kLanes)));
    }
  }
}

double IcpRun::SquaredLimit(const Similarity& pose) const {
  return options_.distance_limit * options_.distance_limit * ErrorUnit(pose);
}

double IcpRun::ErrorUnit(const Similarity& pose) const {
  return options_.scale_mode == ScaleMode::kSymmetric ? pose.scale : 1;
}

float IcpRun::LargestSquaredDistance(const Similarity& pose) {
  float limit = std::numeric_limits<float>::infinity();
  if (options_.distance_limit > 0) {
    limit = static_cast<float>(SquaredLimit(pose));
  }
  if (options_.trimmed_share > 0) {
    const auto vertices = static_cast<size_t>(source_.Packed().VertexCount());
    const std::span<const float> all = pairs_->SquaredDistances().first(vertices);
    sorted_.assign(all.begin(), all.end());
    const auto kept = static_cast<std::ptrdiff_t>(
        std::ceil((1 - options_.trimmed_share) * static_cast<double>(vertices)));
    const auto last = sorted_.begin() + std::max(kept, std::ptrdiff_t{1}) - 1;
    std::nth_element(sorted_.begin(), last, sorted_.end());
    limit = std::min(limit, *last);
  }
  return limit;
}

Distances IcpRun::Measure(const Similarity& pose) const {
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

}  // namespace cohort
