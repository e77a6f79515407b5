#include "common/geometry/registration/undersampling.h"

#include <algorithm>
#include <array>
#include <limits>
#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/geometry/mesh/curvature.h"
#include "tests/common/geometry/registration/bumpy_surface.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::BumpySurface;
using ::testing::ElementsAre;
using testing::IsOk;
using testing::IsOkAndHolds;
using testing::StatusIs;

UndersamplingOptions Options(UndersamplingMethod method) {
  UndersamplingOptions options;
  options.method = method;
  return options;
}

/// Lengths of the shortest paths along edges, by Floyd and Warshall.
Eigen::MatrixXd AllPaths(const TriangleMesh& mesh) {
  const Eigen::Index n = mesh.VertexCount();
  Eigen::MatrixXd paths = Eigen::MatrixXd::Constant(n, n, std::numeric_limits<double>::infinity());
  for (Eigen::Index f = 0; f < mesh.FaceCount(); ++f) {
    for (Eigen::Index c = 0; c < 3; ++c) {
      const int a = mesh.faces(c, f);
      const int b = mesh.faces((c + 1) % 3, f);
      paths(a, b) = paths(b, a) = (mesh.vertices.col(a) - mesh.vertices.col(b)).norm();
    }
  }
  paths.diagonal().setZero();
  for (Eigen::Index k = 0; k < n; ++k) {
    for (Eigen::Index i = 0; i < n; ++i) {
      paths.col(i) = paths.col(i).cwiseMin((paths.col(k).array() + paths(k, i)).matrix());
    }
  }
  return paths;
}

std::vector<int32_t> GreedyByDistance(const Eigen::MatrixXd& distance, double radius) {
  std::vector<int32_t> kept;
  for (int32_t v = 0; v < distance.cols(); ++v) {
    const bool far_enough = std::all_of(
        kept.begin(), kept.end(), [&](int32_t other) { return distance(other, v) >= radius; });
    if (far_enough) {
      kept.push_back(v);
    }
  }
  return kept;
}

TEST(Undersampling, NoneKeepsAll) {
  const auto kept = SelectVertices(BumpySurface(3), Options(UndersamplingMethod::kNone));
  EXPECT_THAT(kept, IsOkAndHolds(ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8)));
}

TEST(Undersampling, RandomDrawsTheCountAscendingAndNoneTwice) {
  UndersamplingOptions options = Options(UndersamplingMethod::kRandom);
  options.count = 300;
  const auto kept = SelectVertices(BumpySurface(20), options);
  ASSERT_THAT(kept, IsOk());
  EXPECT_EQ(kept->size(), 300U);
  EXPECT_TRUE(std::is_sorted(kept->begin(), kept->end()));
  EXPECT_EQ(std::set<int32_t>(kept->begin(), kept->end()).size(), 300U);
  EXPECT_GE(kept->front(), 0);
  EXPECT_LT(kept->back(), 400);
}

TEST(Undersampling, RandomFollowsTheSeed) {
  UndersamplingOptions options = Options(UndersamplingMethod::kRandom);
  options.share = 0.25;
  const auto first = SelectVertices(BumpySurface(20), options);
  const auto again = SelectVertices(BumpySurface(20), options);
  options.seed = 2;
  const auto other = SelectVertices(BumpySurface(20), options);
  ASSERT_THAT(first, IsOk());
  EXPECT_EQ(first->size(), 100U);
  EXPECT_EQ(*first, *again);
  EXPECT_NE(*first, *other);
}

TEST(Undersampling, RandomGivesEachVertexTheSameChance) {
  // The predecessor's draw favoured low indices by far (c4).
  const TriangleMesh mesh = BumpySurface(10);
  UndersamplingOptions options = Options(UndersamplingMethod::kRandom);
  options.count = 50;
  std::array<int, 100> draws{};
  for (options.seed = 1; options.seed <= 2000; ++options.seed) {
    const std::vector<int32_t> kept = SelectVertices(mesh, options).value();
    for (const int32_t v : kept) {
      ++draws[static_cast<size_t>(v)];
    }
  }
  // 1000 expected, standard deviation 22: five of them.
  EXPECT_GT(*std::min_element(draws.begin(), draws.end()), 890);
  EXPECT_LT(*std::max_element(draws.begin(), draws.end()), 1110);
}

TEST(Undersampling, CountBeyondTheMeshKeepsAll) {
  UndersamplingOptions options = Options(UndersamplingMethod::kRandom);
  options.count = 1000;
  const auto kept = SelectVertices(BumpySurface(5), options);
  ASSERT_THAT(kept, IsOk());
  EXPECT_EQ(kept->size(), 25U);
}

TEST(Undersampling, DiskKeepsTheGreedyChoiceByShortestPaths) {
  const TriangleMesh mesh = BumpySurface(15);
  const Eigen::MatrixXd paths = AllPaths(mesh);
  for (const double radius : {5.0, 20.0, 45.0}) {
    UndersamplingOptions options = Options(UndersamplingMethod::kDisk);
    options.radius = radius;
    EXPECT_THAT(SelectVertices(mesh, options), IsOkAndHolds(GreedyByDistance(paths, radius)))
        << radius;
  }
}

TEST(Undersampling, DiskOfAPointCloudGoesByStraightDistance) {
  TriangleMesh cloud = BumpySurface(15);
  cloud.faces.resize(3, 0);
  Eigen::MatrixXd distance(cloud.VertexCount(), cloud.VertexCount());
  for (Eigen::Index v = 0; v < cloud.VertexCount(); ++v) {
    distance.col(v) = (cloud.vertices.colwise() - cloud.vertices.col(v)).colwise().norm();
  }
  UndersamplingOptions options = Options(UndersamplingMethod::kDisk);
  options.radius = 25;
  EXPECT_THAT(SelectVertices(cloud, options), IsOkAndHolds(GreedyByDistance(distance, 25)));
}

TEST(Undersampling, CurvatureKeepsTheMostCurved) {
  const TriangleMesh mesh = BumpySurface(20);
  UndersamplingOptions options = Options(UndersamplingMethod::kCurvature);
  options.count = 40;
  const auto kept = SelectVertices(mesh, options);
  ASSERT_THAT(kept, IsOk());
  ASSERT_EQ(kept->size(), 40U);
  EXPECT_TRUE(std::is_sorted(kept->begin(), kept->end()));
  const Eigen::VectorXd curvature = CurvaturesOf(mesh).maximum;
  double least_kept = std::numeric_limits<double>::infinity();
  double largest_left = -least_kept;
  for (int32_t v = 0; v < mesh.VertexCount(); ++v) {
    if (std::binary_search(kept->begin(), kept->end(), v)) {
      least_kept = std::min(least_kept, curvature(v));
    } else {
      largest_left = std::max(largest_left, curvature(v));
    }
  }
  EXPECT_GE(least_kept, largest_left);
}

TEST(Undersampling, CurvatureGivesTiesToTheLowerIndex) {
  TriangleMesh plane = BumpySurface(10);
  for (int x = 0; x < 10; ++x) {
    for (int y = 0; y < 10; ++y) {
      plane.vertices.col(10 * x + y) << x, y, 0;
    }
  }
  UndersamplingOptions options = Options(UndersamplingMethod::kCurvature);
  options.count = 4;
  EXPECT_THAT(SelectVertices(plane, options), IsOkAndHolds(ElementsAre(0, 1, 2, 3)));
}

TEST(Undersampling, RefusesBadOptions) {
  const TriangleMesh mesh = BumpySurface(5);
  UndersamplingOptions options = Options(UndersamplingMethod::kRandom);
  options.count = 2;
  EXPECT_THAT(SelectVertices(mesh, options),
              StatusIs(absl::StatusCode::kInvalidArgument, "count 2"));
  options.count = 0;
  options.share = 1.5;
  EXPECT_THAT(SelectVertices(mesh, options),
              StatusIs(absl::StatusCode::kInvalidArgument, "share 1.5"));
  EXPECT_THAT(SelectVertices(mesh, Options(UndersamplingMethod::kDisk)),
              StatusIs(absl::StatusCode::kInvalidArgument, "radius 0"));
}

TEST(Undersampling, RefusesToKeepTooFew) {
  UndersamplingOptions options = Options(UndersamplingMethod::kDisk);
  options.radius = 1e6;
  EXPECT_THAT(SelectVertices(BumpySurface(5), options),
              StatusIs(absl::StatusCode::kFailedPrecondition, "keeps 1 of 25"));
  options = Options(UndersamplingMethod::kRandom);
  options.share = 0.05;
  EXPECT_THAT(SelectVertices(BumpySurface(5), options),
              StatusIs(absl::StatusCode::kFailedPrecondition, "keeps 1 of 25"));
}

TEST(Undersampling, RefusesCurvatureOfAPointCloud) {
  TriangleMesh cloud = BumpySurface(5);
  cloud.faces.resize(3, 0);
  EXPECT_THAT(SelectVertices(cloud, Options(UndersamplingMethod::kCurvature)),
              StatusIs(absl::StatusCode::kFailedPrecondition, "point cloud"));
}

}  // namespace
}  // namespace cohort
