#include "common/geometry/registration/scaling_icp.h"

#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

#include <gtest/gtest.h>

#include "common/geometry/synthetic/demo_cohort.h"
#include "tests/common/geometry/registration/bumpy_surface.h"
#include "tests/testing/bits.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::BitsOf;
using testing::BumpySurface;
using testing::DegreesBetween;
using testing::IsOk;
using testing::MakeSimilarity;
using testing::StatusIs;

constexpr int kRows = 40;

absl::StatusOr<Alignment> TryAlign(const Eigen::Matrix3Xd& source,
                                   const Eigen::Matrix3Xd& target,
                                   const Similarity& start = {},
                                   const IcpOptions& options = {},
                                   IcpTrace* trace = nullptr) {
  PacketSearch search;
  return AlignByIcp(IcpMesh(source), IcpMesh(target), start, options, search, trace);
}

/// The textbook's loop and nothing else.
constexpr IcpOptions kPlain = {.rigid_first = false, .acceleration = Acceleration::kNone};

Alignment Align(const Eigen::Matrix3Xd& source,
                const Eigen::Matrix3Xd& target,
                const IcpOptions& options,
                const Similarity& start = {}) {
  const absl::StatusOr<Alignment> alignment = TryAlign(source, target, start, options);
  EXPECT_THAT(alignment, IsOk());
  return alignment.value_or(Alignment{});
}

/// The method as the header describes it, with brute force and the general fit.
Alignment TextbookIcp(const Eigen::Matrix3Xd& source,
                      const Eigen::Matrix3Xd& target,
                      const IcpOptions& options) {
  Alignment alignment;
  double previous = std::numeric_limits<double>::infinity();
  Eigen::Matrix3Xd matched(3, source.cols());
  while (alignment.iterations < options.max_iterations) {
    const Eigen::Matrix3Xd moved = alignment.T_target_source.Apply(source);
    double sum = 0;
    for (Eigen::Index i = 0; i < source.cols(); ++i) {
      Eigen::Index nearest = 0;
      sum +=
          std::sqrt((target.colwise() - moved.col(i)).colwise().squaredNorm().minCoeff(&nearest));
      matched.col(i) = target.col(nearest);
    }
    alignment.T_target_source = FitSimilarity(source, matched, options.scale_mode).value();
    ++alignment.iterations;
    const double mean = sum / static_cast<double>(source.cols());
    if (std::abs(previous - mean) <= options.tolerance) {
      alignment.converged = true;
      break;
    }
    previous = mean;
  }
  const Eigen::Matrix3Xd difference = alignment.T_target_source.Apply(source) - matched;
  alignment.rms_residual = std::sqrt(difference.squaredNorm() / static_cast<double>(source.cols()));
  alignment.mean_residual = difference.colwise().norm().mean();
  return alignment;
}

TEST(AlignByIcp, BringsACopyBack) {
  const Eigen::Matrix3Xd target = BumpySurface(kRows).vertices;
  const Similarity moved = MakeSimilarity(1.05, 8, {1, 2, 3}, {3, -4, 5});
  const Alignment alignment = Align(moved.Apply(target), target, {});
  EXPECT_TRUE(alignment.converged);
  EXPECT_LT(DegreesBetween(alignment.T_target_source.rotation, moved.Inverse().rotation), 0.01);
  EXPECT_NEAR(alignment.T_target_source.scale, 1 / 1.05, 1e-4);
  EXPECT_LT(alignment.rms_residual, 1e-3);  // mm; the target is known in float32
}

TEST(AlignByIcp, BringsACopyBackRigidly) {
  const Eigen::Matrix3Xd target = BumpySurface(kRows).vertices;
  const Similarity moved = MakeSimilarity(1, 8, {1, 2, 3}, {3, -4, 5});
  const Alignment alignment = Align(moved.Apply(target), target, {.scale_mode = ScaleMode::kOff});
  EXPECT_LT(DegreesBetween(alignment.T_target_source.rotation, moved.Inverse().rotation), 0.01);
  EXPECT_EQ(alignment.T_target_source.scale, 1);
}

TEST(AlignByIcp, EqualsTheTextbookLoop) {
  const Eigen::Matrix3Xd source = BumpySurface(20, 2, 3).vertices;
  const Eigen::Matrix3Xd target = BumpySurface(25).vertices;
  IcpOptions options = kPlain;
  options.max_iterations = 60;
  options.tolerance = 0.003;
  const Alignment alignment = Align(source, target, options);
  const Alignment expected = TextbookIcp(source, target, options);
  EXPECT_EQ(alignment.iterations, expected.iterations);
  EXPECT_TRUE(alignment.converged);
  EXPECT_TRUE(alignment.T_target_source.Matrix().isApprox(expected.T_target_source.Matrix(), 1e-6));
  EXPECT_NEAR(alignment.rms_residual, expected.rms_residual, 1e-5);
  EXPECT_NEAR(alignment.mean_residual, expected.mean_residual, 1e-5);
}

TEST(AlignByIcp, RunsAllIterationsIfTheToleranceIsZero) {
  const Eigen::Matrix3Xd target = BumpySurface(20).vertices;
  const Alignment alignment = Align(target, target, {.max_iterations = 37, .tolerance = 0});
  EXPECT_EQ(alignment.iterations, 37);
  EXPECT_EQ(alignment.lookups, 37 * target.cols());
  EXPECT_FALSE(alignment.converged);
}

TEST(AlignByIcp, CountsOneLookupPerVertexAndIteration) {
  const Eigen::Matrix3Xd source = BumpySurface(kRows, 2, 3).vertices;
  const Alignment alignment = Align(source, BumpySurface(20).vertices, kPlain);
  EXPECT_GT(alignment.iterations, 2);
  EXPECT_EQ(alignment.lookups, alignment.iterations * source.cols());
}

TEST(AlignByIcp, CountsTheLookupsOfItsCoarseRun) {
  const Eigen::Matrix3Xd source = BumpySurface(kRows, 2, 3).vertices;
  const Alignment alignment = Align(source, BumpySurface(20).vertices, {});
  const int64_t coarse = alignment.lookups - alignment.iterations * source.cols();
  EXPECT_GE(coarse, 2 * (source.cols() / 16));
  EXPECT_EQ(coarse % (source.cols() / 16), 0);
  const Alignment counted =
      Align(source, BumpySurface(20).vertices, {.max_iterations = 5, .tolerance = 0});
  EXPECT_EQ(counted.lookups, 5 * source.cols());
}

TEST(AlignByIcp, RefusesASourceWithoutExtentWhereTheScaleIsFree) {
  const Eigen::Matrix3Xd target = BumpySurface(kRows).vertices;
  const Eigen::Matrix3Xd point = Eigen::Vector3d(1, 2, 3).replicate(1, 2000);
  for (const ScaleMode mode : {ScaleMode::kFree, ScaleMode::kSymmetric}) {
    PacketSearch search;
    EXPECT_FALSE(
        AlignByIcp(IcpMesh(point), IcpMesh(target), {}, {.scale_mode = mode}, search).ok());
  }
}

TEST(AlignByIcp, FindsTheOptimumWhereItsCoarseRunFindsNoPairs) {
  // 16 vertices lie on the target, one or two of them where the coarse run looks.
  constexpr int kNear = 16;
  constexpr int kFar = 4000;
  const Eigen::Matrix3Xd target = BumpySurface(kRows).vertices;
  Eigen::Matrix3Xd source(3, kNear + kFar);
  for (int i = 0; i < kNear; ++i) {
    source.col(i) = target.col(i * (target.cols() / kNear));
  }
  for (int i = 0; i < kFar; ++i) {
    source.col(kNear + i) << 100 + 0.01 * i, 0, 0;
  }
  const Alignment alignment =
      Align(source, target, {.scale_mode = ScaleMode::kOff, .distance_limit = 1e-3});
  EXPECT_LT(alignment.rms_residual, 1e-5);
  EXPECT_EQ(alignment.kept_share * (kNear + kFar), kNear);
}

TEST(AlignByIcp, NeedsTwoPassesToConverge) {
  const Eigen::Matrix3Xd target = BumpySurface(20).vertices;
  const Alignment alignment = Align(target, target, kPlain);
  EXPECT_EQ(alignment.iterations, 2);
  EXPECT_TRUE(alignment.converged);
  EXPECT_FALSE(Align(target, target, {.max_iterations = 1}).converged);
  EXPECT_EQ(Align(target, target, {}).iterations, 4);  // two of them rigid
}

using ErrorCase = std::tuple<ScaleMode, Acceleration, double>;
class IcpErrorOf : public ::testing::TestWithParam<ErrorCase> {};

/// Largest rise of the error from one pose to the next, relative.
double LargestRise(const IcpTrace& trace) {
  double rise = 0;
  for (size_t i = 1; i < trace.size(); ++i) {
    rise = std::max(rise, (trace[i] - trace[i - 1]) / trace[i]);
  }
  return rise;
}

Eigen::Matrix3Xd FaceVertices(int person, int capture) {
  DemoOptions options;
  options.vertices = 1500;
  return MakeDemoScan(options, person, capture)->mesh.vertices;
}

TEST_P(IcpErrorOf, NeverRises) {
  const auto [scale_mode, acceleration, degrees] = GetParam();
  const IcpOptions options{.scale_mode = scale_mode, .acceleration = acceleration};
  for (int person = 0; person < 2; ++person) {
    const Eigen::Matrix3Xd target = FaceVertices(0, 0);
    const Eigen::Matrix3Xd source = FaceVertices(person, 1);
    const Eigen::Vector3d gap = target.rowwise().mean() - source.rowwise().mean();
    for (const Eigen::Vector3d& axis :
         {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(1, -1, 2)}) {
      Similarity start = MakeSimilarity(1, degrees, axis, {0, 0, 0});
      start.translation = source.rowwise().mean() + gap - start.rotation * source.rowwise().mean();
      IcpTrace trace;
      const auto alignment = TryAlign(source, target, start, options, &trace);
      ASSERT_THAT(alignment, IsOk());
      EXPECT_GT(trace.size(), 3U);
      EXPECT_LE(trace.size(), static_cast<size_t>(alignment->iterations));
      EXPECT_LT(LargestRise(trace), 1e-6);  // queries are rounded to float32
      EXPECT_LT(trace.back(), trace.front());
    }
  }
}
INSTANTIATE_TEST_SUITE_P(
    AllModes,
    IcpErrorOf,
    ::testing::Combine(::testing::Values(ScaleMode::kOff, ScaleMode::kFree, ScaleMode::kSymmetric),
                       ::testing::Values(Acceleration::kNone, Acceleration::kAnderson),
                       ::testing::Values(0, 20, 45)));

TEST(IcpError, NeverRisesWhenPairsAreTrimmedOrTooFarApart) {
  const Eigen::Matrix3Xd target = FaceVertices(0, 0);
  const Eigen::Matrix3Xd source = FaceVertices(1, 1);
  for (IcpOptions options : {IcpOptions{.trimmed_share = 0.2}, IcpOptions{.distance_limit = 3}}) {
    for (const Acceleration acceleration : {Acceleration::kNone, Acceleration::kAnderson}) {
      options.acceleration = acceleration;
      IcpTrace trace;
      ASSERT_THAT(TryAlign(source, target, {}, options, &trace), IsOk());
      EXPECT_GT(trace.size(), 3U);
      EXPECT_LT(LargestRise(trace), 1e-6);
    }
  }
}

TEST(AlignByIcp, AcceleratesToTheSameOptimumInFewerPasses) {
  const Eigen::Matrix3Xd target = FaceVertices(0, 0);
  int plain_iterations = 0;
  int iterations = 0;
  for (int person = 0; person < 4; ++person) {
    const Eigen::Matrix3Xd source = FaceVertices(person, 1);
    IcpOptions options = kPlain;
    options.max_iterations = 1000;
    const Alignment plain = Align(source, target, options);
    options.acceleration = Acceleration::kAnderson;
    const Alignment accelerated = Align(source, target, options);
    EXPECT_TRUE(accelerated.converged);
    EXPECT_NEAR(accelerated.rms_residual, plain.rms_residual, 0.02);  // mm; both are local optima
    plain_iterations += plain.iterations;
    iterations += accelerated.iterations;
  }
  EXPECT_LT(iterations, 0.7 * plain_iterations);
}

TEST(AlignByIcp, KeepsTheScaleWithinItsLimit) {
  const Eigen::Matrix3Xd target = BumpySurface(kRows).vertices;
  const Eigen::Matrix3Xd source = 0.8 * target;
  EXPECT_NEAR(Align(source, target, {}).T_target_source.scale, 1.25, 1e-3);
  const Alignment limited = Align(source, target, {.scale_limit = 1.1});
  EXPECT_EQ(limited.T_target_source.scale, 1.1);
  EXPECT_TRUE(limited.at_scale_limit);
  const Alignment free = Align(source, target, {.scale_limit = 1.5});
  EXPECT_NEAR(free.T_target_source.scale, 1.25, 1e-3);
  EXPECT_FALSE(free.at_scale_limit);
}

TEST(AlignByIcp, TrimsWhatHasNoPartner) {
  const Eigen::Matrix3Xd target = BumpySurface(kRows).vertices;
  const Similarity moved = MakeSimilarity(1, 6, {1, 2, 3}, {3, -4, 5});
  Eigen::Matrix3Xd source = moved.Apply(target);
  source.leftCols(300).colwise() += Eigen::Vector3d(0, -40, 60);  // a piece that floats
  const IcpOptions options{.scale_mode = ScaleMode::kOff, .trimmed_share = 0.25};
  const Alignment trimmed = Align(source, target, options);
  EXPECT_LT(DegreesBetween(trimmed.T_target_source.rotation, moved.Inverse().rotation), 0.01);
  EXPECT_GE(trimmed.kept_share, 0.75);
  EXPECT_LT(trimmed.kept_share, 0.76);  // Of a copy many are equally near: all of them count.
  EXPECT_LT(trimmed.rms_residual, 1e-3);
  const Alignment limited =
      Align(source, target, {.scale_mode = ScaleMode::kOff, .distance_limit = 8});
  EXPECT_LT(DegreesBetween(limited.T_target_source.rotation, moved.Inverse().rotation), 0.01);
  EXPECT_LT(limited.kept_share, 0.9);
}

/// 1 where a vertex lies at the edge of BumpySurface.
std::vector<uint8_t> EdgeOfBumpySurface(int rows) {
  std::vector<uint8_t> on_boundary;
  for (int i = 0; i < rows * rows; ++i) {
    const int row = i / rows;
    const int column = i % rows;
    on_boundary.push_back(row == 0 || column == 0 || row == rows - 1 || column == rows - 1 ? 1 : 0);
  }
  return on_boundary;
}

TEST(AlignByIcp, RejectsPairsOnTheOpenBoundary) {
  const Eigen::Matrix3Xd source = BumpySurface(kRows).vertices;
  const int rows = 20;  // the lower half of u: the source reaches beyond it
  const Eigen::Matrix3Xd part = source.leftCols(Eigen::Index{rows} * kRows);
  std::vector<uint8_t> on_boundary;
  for (int i = 0; i < rows * kRows; ++i) {
    const int row = i / kRows;
    const int column = i % kRows;
    on_boundary.push_back(row == 0 || row == rows - 1 || column == 0 || column == kRows - 1 ? 1
                                                                                            : 0);
  }
  PacketSearch search;
  const IcpMesh target(part, on_boundary);
  const Similarity start = MakeSimilarity(1, 4, {1, 2, 3}, {1, -2, 1});
  IcpOptions options{.scale_mode = ScaleMode::kOff};
  const auto kept = AlignByIcp(IcpMesh(source), target, start, options, search);
  options.boundary_pairs = BoundaryPairs::kReject;
  const auto rejected = AlignByIcp(IcpMesh(source), target, start, options, search);
  ASSERT_THAT(kept, IsOk());
  ASSERT_THAT(rejected, IsOk());
  EXPECT_LT(DegreesBetween(rejected->T_target_source.rotation, Eigen::Matrix3d::Identity()), 2.5);
  EXPECT_GT(DegreesBetween(kept->T_target_source.rotation, Eigen::Matrix3d::Identity()), 15);
  EXPECT_NEAR(rejected->overlap, 0.45, 0.1);
  EXPECT_NEAR(rejected->overlap, rejected->kept_share, 1e-12);
}

TEST(AlignByIcp, RefusesIfAllPairsAreRejected) {
  const Eigen::Matrix3Xd source = BumpySurface(20).vertices;
  EXPECT_THAT(
      TryAlign(source, source.colwise() + Eigen::Vector3d(500, 0, 0), {}, {.distance_limit = 1}),
      StatusIs(absl::StatusCode::kFailedPrecondition, "0 pairs of 400 vertices count"));
}

TEST(AlignByIcp, SeesWhatLiesBeyondTheBorder) {
  const Eigen::Matrix3Xd target = BumpySurface(kRows).vertices;
  PacketSearch search;
  const auto alignment =
      AlignByIcp(IcpMesh(target), IcpMesh(target, EdgeOfBumpySurface(kRows)), {}, {}, search);
  ASSERT_THAT(alignment, IsOk());
  EXPECT_DOUBLE_EQ(alignment->overlap, 38.0 * 38 / (40 * 40));
}

class IcpPath : public ::testing::TestWithParam<InstructionSet> {};

TEST_P(IcpPath, GivesTheSameBytes) {
  const IcpMesh source(FaceVertices(1, 1));
  const IcpMesh target(FaceVertices(0, 0));
  PacketSearch portable(InstructionSet::kPortable);
  PacketSearch search(GetParam());
  const Alignment expected = *AlignByIcp(source, target, {}, {}, portable);
  const Alignment alignment = *AlignByIcp(source, target, {}, {}, search);
  EXPECT_EQ(alignment.T_target_source.Matrix(), expected.T_target_source.Matrix());
  EXPECT_EQ(alignment.iterations, expected.iterations);
  EXPECT_EQ(alignment.rms_residual, expected.rms_residual);
}
INSTANTIATE_TEST_SUITE_P(All, IcpPath, ::testing::ValuesIn(AvailableInstructionSets()));

TEST(AlignByIcp, DoesNotSeeACommonRigidMotion) {
  const Eigen::Matrix3Xd source = BumpySurface(kRows, 2, 3).vertices;
  const Eigen::Matrix3Xd target = BumpySurface(kRows).vertices;
  const Similarity motion = MakeSimilarity(1, 110, {3, -1, 2}, {500, -300, 40});
  // A fixed number of passes: near the end, one neighbour that flips could stop one run earlier.
  const IcpOptions options{.max_iterations = 15, .tolerance = 0};
  const Alignment still = Align(source, target, options);
  const Alignment moved = Align(motion.Apply(source), motion.Apply(target), options);
  EXPECT_NEAR(moved.rms_residual, still.rms_residual, 1e-4);
  EXPECT_NEAR(moved.T_target_source.scale, still.T_target_source.scale, 1e-5);
  const Similarity back = motion.Inverse() * moved.T_target_source * motion;
  EXPECT_LT(DegreesBetween(back.rotation, still.T_target_source.rotation), 0.01);
}

TEST(AlignByIcp, GivesTheSameBytesAgain) {
  const Eigen::Matrix3Xd source = BumpySurface(kRows, 2, 3).vertices;
  const Eigen::Matrix3Xd target = BumpySurface(kRows).vertices;
  const Alignment first = Align(source, target, {});
  const Alignment second = Align(source, target, {});
  const Eigen::Matrix4d a = first.T_target_source.Matrix();
  const Eigen::Matrix4d b = second.T_target_source.Matrix();
  EXPECT_EQ(BitsOf(a), BitsOf(b));
  EXPECT_EQ(first.rms_residual, second.rms_residual);
}

TEST(AlignByIcp, ReportsMeanResidualBelowRms) {
  const Alignment alignment =
      Align(BumpySurface(kRows, 2, 3).vertices, BumpySurface(kRows).vertices, {});
  EXPECT_GT(alignment.mean_residual, 0);
  EXPECT_LE(alignment.mean_residual, alignment.rms_residual);
}

TEST(AlignByIcp, RefusesACollapse) {
  const Eigen::Matrix3Xd source = BumpySurface(20).vertices;
  EXPECT_THAT(TryAlign(source, 0.01 * source),
              StatusIs(absl::StatusCode::kFailedPrecondition, "collapse"));
  const Eigen::Matrix3Xd one_vertex = Eigen::Matrix3Xd::Zero(3, 1);
  EXPECT_THAT(TryAlign(source, one_vertex),
              StatusIs(absl::StatusCode::kFailedPrecondition, "scale"));
}

TEST(AlignByIcp, MeasuresTheCollapseFromTheStart) {
  const Eigen::Matrix3Xd source = BumpySurface(20).vertices;
  Similarity start;
  start.scale = 0.01;
  EXPECT_THAT(TryAlign(source, 0.01 * source, start), IsOk());
}

TEST(AlignByIcp, RefusesASourceWithoutExtent) {
  const Eigen::Matrix3Xd source = Eigen::Vector3d(0.1, 0.2, 0.3).replicate(1, 5);
  EXPECT_THAT(TryAlign(source, BumpySurface(20).vertices),
              StatusIs(absl::StatusCode::kFailedPrecondition, ""));
}

TEST(AlignByIcp, RefusesTooFewVertices) {
  EXPECT_THAT(TryAlign(Eigen::Matrix3Xd::Zero(3, 2), BumpySurface(20).vertices),
              StatusIs(absl::StatusCode::kInvalidArgument, "2 vertices"));
}

TEST(IcpOptions, RefuseNonsense) {
  EXPECT_THAT(IcpOptions{}.Validate(), IsOk());
  EXPECT_THAT((IcpOptions{.max_iterations = 0}.Validate()),
              StatusIs(absl::StatusCode::kInvalidArgument, "max_iterations is 0"));
  EXPECT_THAT((IcpOptions{.tolerance = -1}.Validate()),
              StatusIs(absl::StatusCode::kInvalidArgument, "tolerance is -1"));
  EXPECT_THAT((IcpOptions{.tolerance = std::nan("")}.Validate()),
              StatusIs(absl::StatusCode::kInvalidArgument, "tolerance"));
  EXPECT_THAT((IcpOptions{.scale_limit = 0.5}.Validate()),
              StatusIs(absl::StatusCode::kInvalidArgument, "scale_limit is 0.5"));
  EXPECT_THAT((IcpOptions{.trimmed_share = 0.95}.Validate()),
              StatusIs(absl::StatusCode::kInvalidArgument, "trimmed_share is 0.95"));
  EXPECT_THAT((IcpOptions{.distance_limit = -2}.Validate()),
              StatusIs(absl::StatusCode::kInvalidArgument, "distance_limit is -2"));
  const Eigen::Matrix3Xd points = BumpySurface(20).vertices;
  EXPECT_THAT(TryAlign(points, points, {}, {.max_iterations = -3}),
              StatusIs(absl::StatusCode::kInvalidArgument, "-3"));
}

}  // namespace
}  // namespace cohort
