#include "common/geometry/registration/coarse_pose.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "common/base/status_macros.h"
#include "common/geometry/nearest/packet_search.h"
#include "common/geometry/registration/icp_mesh.h"
#include "common/geometry/registration/paired_sums.h"

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

/// The winner is improved until its score rests, but no longer than this.
constexpr int kMostPasses = 200;
constexpr double kRestShare = 1e-5;

struct Candidate {
  Similarity T;         ///< Rigid; from the source to the target, each about its centroid.
  double handicap = 1;  ///< Factor on `score` in the ranking.
  double score = 0;     ///< RMS of the kept points of both meshes.
};

/// Sampled points of one mesh and what lies nearest to them on the other.
class SampledSide {
 public:
  SampledSide(const PackedMesh& points, const PackedMesh& other)
      : points_(points), other_(other), kept_(AllVertices(points)) {}

  /// Searches the other mesh for the points of this side, moved there by T_other_this.
  /// @return sums over the pairs that are kept; a on this side, b on the other.
  PairSums LookUp(const Similarity& T_other_this, SearchSeed seed, PacketSearch& search) {
    search.FindMoved(points_, ToTransform(T_other_this), other_, seed, nearest_);
    const std::span<const float> distances(nearest_.squared_distances.data(),
                                           static_cast<size_t>(points_.VertexCount()));
    const float largest_kept = LargestKept(distances);
    std::fill(kept_.data(), kept_.data() + kept_.size(), uint16_t{0});
    for (size_t slot = 0; slot < distances.size(); ++slot) {
      const auto bit = static_cast<uint16_t>(distances[slot] <= largest_kept ? 1U : 0U);
      uint16_t& lanes = kept_[slot / PackedMesh::kLanes];
      lanes = static_cast<uint16_t>(lanes | bit << (slot % PackedMesh::kLanes));
    }
    return search.Sum(points_, other_, nearest_, {kept_.data(), kept_.size()});
  }

  [[nodiscard]] int64_t Count() const { return points_.VertexCount(); }

 private:
  float LargestKept(std::span<const float> distances) {
    partly_sorted_.assign(distances.begin(), distances.end());
    const auto kept = static_cast<std::ptrdiff_t>(kKeptShare * static_cast<double>(Count()));
    const auto last = partly_sorted_.begin() + std::max(kept, std::ptrdiff_t{1}) - 1;
    std::nth_element(partly_sorted_.begin(), last, partly_sorted_.end());
    return *last;
  }

  const PackedMesh& points_;
  const PackedMesh& other_;
  NearestSlots nearest_;
  AlignedArray<uint16_t> kept_;
  std::vector<float> partly_sorted_;
};

double MeanSquare(const PairSums& sums) {
  return sums.squared_distance / static_cast<double>(sums.count);
}

/// Pairs of both directions as pairs of source and target. `back` has them the other way around,
/// with the same distances: the pose is rigid.
PairSums BothWays(PairSums sums, const PairSums& back) {
  sums.count += back.count;
  sums.a += back.b;
  sums.b += back.a;
  sums.aa += back.bb;
  sums.bb += back.aa;
  sums.ba += back.ba.transpose();
  return sums;
}

/// Improves rigid poses by trimmed ICP that looks both ways: from the source alone, a part of it
/// could slide along a larger target without losing anything.
class PoseRefiner {
 public:
  PoseRefiner(const PackedMesh& source, const PackedMesh& target, PacketSearch& search)
      : source_(source, target), target_(target, source), search_(search) {}

  absl::Status Refine(int passes, Candidate& candidate) { return Run(passes, 0, candidate); }

  /// Goes on until the pose rests, so that starts of one basin end in one pose.
  absl::Status Settle(Candidate& candidate) { return Run(kMostPasses, kRestShare, candidate); }

  [[nodiscard]] int64_t Lookups() const { return lookups_; }

 private:
  /// @param rest_share  it rests once the score changes by less than this share of it.
  absl::Status Run(int passes, double rest_share, Candidate& candidate) {
    SearchSeed seed = SearchSeed::kDescent;
    for (int pass = 0;; ++pass) {
      const PairSums there = source_.LookUp(candidate.T, seed, search_);
      const PairSums back = target_.LookUp(candidate.T.Inverse(), seed, search_);
      lookups_ += source_.Count() + target_.Count();
      const double score = std::sqrt(0.5 * (MeanSquare(there) + MeanSquare(back)));
      const bool rests = pass > 0 && std::abs(score - candidate.score) < rest_share * score;
      candidate.score = score;
      if (rests || pass == passes) {
        return absl::OkStatus();
      }
      COHORT_ASSIGN_OR_RETURN(candidate.T, PairedSums(BothWays(there, back)).Fit(ScaleMode::kOff));
      seed = SearchSeed::kPrevious;
    }
  }

  SampledSide source_;
  SampledSide target_;
  PacketSearch& search_;
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
std::vector<Candidate> FirstCandidates(const PrincipalFrame& source, const PrincipalFrame& target) {
  Candidate candidate;
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

absl::StatusOr<PoseShape> PoseShape::Create(const TriangleMesh& mesh) {
  const SurfaceSampler sampler(mesh);
  PoseShape shape(sampler.Frame());
  if (!(shape.frame_.deviations(2) > 1e-12 * shape.frame_.centroid.norm())) {
    return absl::FailedPreconditionError("coarse pose: a mesh has no extent");
  }
  for (const Round& round : kRounds) {
    const Eigen::Matrix3Xd points = sampler.Sample(round.points).colwise() - shape.frame_.centroid;
    shape.samples_.emplace_back(points.cast<float>());
  }
  return shape;
}

int64_t PoseShape::ByteCount() const {
  int64_t bytes = 0;
  for (const PackedMesh& sample : samples_) {
    bytes += sample.ByteCount();
  }
  return bytes;
}

absl::StatusOr<CoarsePose> FindCoarsePose(const PoseShape& source, const PoseShape& target) {
  std::vector<Candidate> candidates = FirstCandidates(source.Frame(), target.Frame());
  PacketSearch search;
  CoarsePose pose;
  for (size_t i = 0; i < kRounds.size(); ++i) {
    const Round& round = kRounds.at(i);
    PoseRefiner refiner(source.Samples()[i], target.Samples()[i], search);
    for (Candidate& candidate : candidates) {
      COHORT_RETURN_IF_ERROR(refiner.Refine(round.passes, candidate));
    }
    candidates = BestOf(std::move(candidates), round.survivors);
    if (round.survivors == 1) {
      COHORT_RETURN_IF_ERROR(refiner.Settle(candidates.front()));
    }
    pose.lookups += refiner.Lookups();
  }
  const Candidate& winner = candidates.front();
  pose.score = winner.score;
  pose.T_target_source = winner.T;
  pose.T_target_source.translation =
      winner.T.ApplyToPoint(-source.Frame().centroid) + target.Frame().centroid;
  return pose;
}

absl::StatusOr<CoarsePose> FindCoarsePose(const TriangleMesh& source, const TriangleMesh& target) {
  COHORT_ASSIGN_OR_RETURN(const PoseShape source_shape, PoseShape::Create(source));
  COHORT_ASSIGN_OR_RETURN(const PoseShape target_shape, PoseShape::Create(target));
  return FindCoarsePose(source_shape, target_shape);
}

}  // namespace cohort
