#include "common/geometry/registration/coarse_pose.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "common/base/status_macros.h"
#include "common/geometry/mesh/bounds.h"
#include "common/geometry/nearest/nearest_vertex.h"
#include "common/geometry/registration/paired_sums.h"
#include "common/geometry/registration/surface_sample.h"

namespace cohort {
namespace {

/// Points that count, of those sampled: the nearest. The rest may lie where the other mesh has a
/// hole, a border further in, or nothing (spikes, floating pieces).
constexpr double kKeptShare = 0.85;

/// The given pose must be this much better than a pose found from the shape alone. So an alignment
/// does not depend on how the scanner held the mesh, unless the shape cannot tell.
constexpr double kGivenPoseHandicap = 1.05;

/// Poses nearer than this are one pose found twice.
constexpr double kDistinctDegrees = 3.0;

/// One round of the tournament: each candidate is improved, the best `survivors` go on.
struct Round {
  Eigen::Index points;  ///< Sampled on each mesh.
  int passes;
  size_t survivors;
};
// Measured on generated (rough) faces, averages of scans and femurs, whole and cropped by 15-30 %.
constexpr std::array<Round, 3> kRounds = {{{100, 4, 16}, {200, 6, 4}, {600, 8, 1}}};

struct Candidate {
  Similarity T;         ///< Rigid; from the source about its centroid to the target about Center().
  double handicap = 1;  ///< Factor on `score` in the ranking.
  double score = 0;     ///< RMS of the kept points of both meshes.
};

/// Sampled points of one mesh and what lies nearest to them on the other.
class SampledSide {
 public:
  explicit SampledSide(Eigen::Matrix3Xd points)
      : points_(std::move(points)),
        index_(NearestVertex::Build(points_.cast<float>())),
        queries_(3, points_.cols()),
        nearest_(static_cast<size_t>(points_.cols())),
        squared_distances_(nearest_.size()) {}

  /// Searches `other` for the points of this side, moved there by T_other_this.
  void LookUp(const Similarity& T_other_this, const SampledSide& other) {
    for (Eigen::Index i = 0; i < points_.cols(); ++i) {
      queries_.col(i) = T_other_this.ApplyToPoint(points_.col(i)).cast<float>();
    }
    other.index_->Find(queries_, nearest_, squared_distances_);
    partly_sorted_ = squared_distances_;
    const auto kept = static_cast<std::ptrdiff_t>(kKeptShare * static_cast<double>(Count()));
    const auto last = partly_sorted_.begin() + std::max(kept, std::ptrdiff_t{1}) - 1;
    std::nth_element(partly_sorted_.begin(), last, partly_sorted_.end());
    largest_kept_ = *last;
  }

  /// Calls visit(point of this side, its nearest point of the other, squared distance) for the
  /// pairs that are kept, in index order.
  template <class Visitor>
  void ForEachKept(const SampledSide& other, Visitor visit) const {
    for (Eigen::Index i = 0; i < points_.cols(); ++i) {
      const float squared_distance = squared_distances_[static_cast<size_t>(i)];
      if (squared_distance <= largest_kept_) {
        visit(points_.col(i), other.points_.col(nearest_[static_cast<size_t>(i)]),
              squared_distance);
      }
    }
  }

  [[nodiscard]] int64_t Count() const { return points_.cols(); }

 private:
  Eigen::Matrix3Xd points_;
  std::unique_ptr<const NearestVertex> index_;
  Eigen::Matrix3Xf queries_;
  std::vector<int32_t> nearest_;
  std::vector<float> squared_distances_;
  std::vector<float> partly_sorted_;
  float largest_kept_ = 0;
};

/// Improves rigid poses by trimmed ICP that looks both ways: from the source alone, a part of it
/// could slide along a larger target without losing anything.
class PoseRefiner {
 public:
  PoseRefiner(Eigen::Matrix3Xd source_points, Eigen::Matrix3Xd target_points)
      : source_(std::move(source_points)), target_(std::move(target_points)) {}

  absl::Status Refine(int passes, Candidate& candidate) {
    for (int pass = 0; pass < passes; ++pass) {
      LookUp(candidate.T);
      PairedSums sums;
      source_.ForEachKept(target_, [&](const auto& a, const auto& b, float) { sums.Add(a, b); });
      target_.ForEachKept(source_, [&](const auto& b, const auto& a, float) { sums.Add(a, b); });
      COHORT_ASSIGN_OR_RETURN(candidate.T, sums.Fit(ScaleMode::kOff));
    }
    LookUp(candidate.T);
    candidate.score =
        std::sqrt(0.5 * (KeptMeanSquare(source_, target_) + KeptMeanSquare(target_, source_)));
    return absl::OkStatus();
  }

  [[nodiscard]] int64_t Lookups() const { return lookups_; }

 private:
  void LookUp(const Similarity& T_target_source) {
    source_.LookUp(T_target_source, target_);
    target_.LookUp(T_target_source.Inverse(), source_);
    lookups_ += source_.Count() + target_.Count();
  }

  static double KeptMeanSquare(const SampledSide& side, const SampledSide& other) {
    double sum = 0;
    int64_t count = 0;
    side.ForEachKept(other, [&](const auto&, const auto&, float squared_distance) {
      sum += double{squared_distance};
      ++count;
    });
    return sum / static_cast<double>(count);
  }

  SampledSide source_;
  SampledSide target_;
  int64_t lookups_ = 0;
};

/// The 24 rotations that map the axes onto the axes.
std::vector<Eigen::Matrix3d> OctahedralRotations() {
  std::vector<Eigen::Matrix3d> rotations;
  std::array<int, 3> axis = {0, 1, 2};
  do {
    for (unsigned signs = 0; signs < 8; ++signs) {
      Eigen::Matrix3d R = Eigen::Matrix3d::Zero();
      for (int column = 0; column < 3; ++column) {
        R(axis.at(static_cast<size_t>(column)), column) = ((signs >> column) & 1U) != 0 ? -1 : 1;
      }
      if (R.determinant() > 0) {
        rotations.push_back(R);
      }
    }
  } while (std::next_permutation(axis.begin(), axis.end()));
  return rotations;
}

/// Whether an even number of swaps sorts it.
bool IsEven(const std::array<int, 4>& order) {
  int inversions = 0;
  for (size_t i = 0; i < order.size(); ++i) {
    for (size_t j = i + 1; j < order.size(); ++j) {
      inversions += order.at(i) > order.at(j) ? 1 : 0;
    }
  }
  return inversions % 2 == 0;
}

/// The 48 rotations of the icosahedron that are not among the 24 of the axes: even permutations of
/// (phi, 1, 1 / phi, 0) / 2 with any signs, as quaternions (Conway, Smith 2003), q and -q once.
std::vector<Eigen::Matrix3d> IcosahedralRotations() {
  constexpr double kPhi = 1.618033988749895;
  constexpr std::array<double, 4> kParts = {kPhi / 2, 0.5, 0.5 / kPhi, 0};
  std::vector<Eigen::Matrix3d> rotations;
  std::array<int, 4> order = {0, 1, 2, 3};
  do {
    if (!IsEven(order)) {
      continue;
    }
    for (unsigned signs = 0; signs < 4; ++signs) {  // the largest part stays positive
      Eigen::Vector4d q;
      for (Eigen::Index i = 0; i < 4; ++i) {
        const int part = order.at(static_cast<size_t>(i));
        const bool negative = (part == 1 && (signs & 1U) != 0) || (part == 2 && (signs & 2U) != 0);
        q(i) = kParts.at(static_cast<size_t>(part)) * (negative ? -1 : 1);
      }
      rotations.push_back(Eigen::Quaterniond(q(0), q(1), q(2), q(3)).toRotationMatrix());
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return rotations;
}

/// Given pose first, then the axes onto the axes, then turns in between: borders and near-equal
/// extents can turn the axes of a shell by any angle, and ICP finds back from some 40 degrees.
std::vector<Candidate> FirstCandidates(const PrincipalFrame& source,
                                       const PrincipalFrame& target,
                                       const Eigen::Vector3d& target_center) {
  Candidate candidate;
  candidate.T.translation = target.centroid - target_center;
  candidate.handicap = kGivenPoseHandicap;
  std::vector<Candidate> candidates = {candidate};
  candidate.handicap = 1;
  for (const std::vector<Eigen::Matrix3d>& group :
       {OctahedralRotations(), IcosahedralRotations()}) {
    for (const Eigen::Matrix3d& turn : group) {
      candidate.T.rotation = target.axes * turn * source.axes.transpose();
      candidates.push_back(candidate);
    }
  }
  return candidates;
}

bool IsSamePose(const Candidate& a, const Candidate& b) {
  // trace(R) = 1 + 2 cos(angle)
  constexpr double kDegree = 0.017453292519943295;
  const double trace = (a.T.rotation.transpose() * b.T.rotation).trace();
  return trace > 1 + 2 * std::cos(kDistinctDegrees * kDegree);
}

/// The best `count` different poses, best first; the earlier one on a tie.
std::vector<Candidate> BestOf(std::vector<Candidate> candidates, size_t count) {
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) {
                     return a.handicap * a.score < b.handicap * b.score;
                   });
  std::vector<Candidate> best;
  for (const Candidate& candidate : candidates) {
    const bool known = std::any_of(best.begin(), best.end(), [&](const Candidate& better) {
      return IsSamePose(better, candidate);
    });
    if (!known && best.size() < count) {
      best.push_back(candidate);
    }
  }
  return best;
}

}  // namespace

absl::StatusOr<CoarsePose> FindCoarsePose(const TriangleMesh& source, const TriangleMesh& target) {
  const Eigen::Vector3d target_center = CentroidOf(target.vertices);
  const PrincipalFrame source_frame = PrincipalFrameOf(source);
  const PrincipalFrame target_frame = PrincipalFrameOf(target);
  for (const PrincipalFrame* frame : {&source_frame, &target_frame}) {
    if (!(frame->deviations(2) > 1e-12 * frame->centroid.norm())) {
      return absl::FailedPreconditionError("coarse pose: a mesh has no extent");
    }
  }
  std::vector<Candidate> candidates = FirstCandidates(source_frame, target_frame, target_center);
  CoarsePose pose;
  for (const Round& round : kRounds) {
    PoseRefiner refiner(SampleSurface(source, round.points).colwise() - source_frame.centroid,
                        SampleSurface(target, round.points).colwise() - target_center);
    for (Candidate& candidate : candidates) {
      COHORT_RETURN_IF_ERROR(refiner.Refine(round.passes, candidate));
    }
    pose.lookups += refiner.Lookups();
    candidates = BestOf(std::move(candidates), round.survivors);
  }
  const Candidate& winner = candidates.front();
  pose.score = winner.score;
  pose.T_target_source = winner.T;
  pose.T_target_source.translation = winner.T.ApplyToPoint(-source_frame.centroid) + target_center;
  return pose;
}

}  // namespace cohort
