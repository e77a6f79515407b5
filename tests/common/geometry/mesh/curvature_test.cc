#include "common/geometry/mesh/curvature.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "common/base/random.h"
#include "tests/common/geometry/mesh/shapes.h"

namespace cohort {
namespace {

using testing::Tetrahedron;
using testing::Together;

/// An open sheet of points(u, v), u and v in [-1, 1], jittered, outward along du x dv.
TriangleMesh Sheet(int side, const std::function<Eigen::Vector3d(double, double)>& point) {
  Random random(3);
  TriangleMesh mesh;
  mesh.vertices.resize(3, Eigen::Index{side} * side);
  mesh.faces.resize(3, Eigen::Index{2} * (side - 1) * (side - 1));
  Eigen::Index face = 0;
  for (int i = 0; i < side; ++i) {
    for (int j = 0; j < side; ++j) {
      const double u = 2 * (i + random.Uniform(-0.2, 0.2)) / (side - 1) - 1;
      const double v = 2 * (j + random.Uniform(-0.2, 0.2)) / (side - 1) - 1;
      const int corner = i * side + j;
      mesh.vertices.col(corner) = point(u, v);
      if (i + 1 < side && j + 1 < side) {
        mesh.faces.col(face++) << corner, corner + side, corner + side + 1;
        mesh.faces.col(face++) << corner, corner + side + 1, corner + 1;
      }
    }
  }
  return mesh;
}

/// A closed sphere: an octahedron, each face cut into 4 `levels` times.
TriangleMesh Sphere(double radius, int levels) {
  TriangleMesh mesh = testing::MakeMesh(
      {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
      {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}});
  for (int level = 0; level < levels; ++level) {
    const TriangleMesh coarse = mesh;
    std::map<std::pair<int, int>, int> middle_of;
    std::vector<Eigen::Vector3d> middles;
    mesh.faces.resize(3, 4 * coarse.FaceCount());
    for (Eigen::Index f = 0; f < coarse.FaceCount(); ++f) {
      std::array<int, 3> m{};
      for (Eigen::Index c = 0; c < 3; ++c) {
        const auto [a, b] = std::minmax({coarse.faces(c, f), coarse.faces((c + 1) % 3, f)});
        const int next = static_cast<int>(coarse.VertexCount()) + static_cast<int>(middles.size());
        const auto [found, is_new] = middle_of.try_emplace({a, b}, next);
        if (is_new) {
          middles.emplace_back((coarse.vertices.col(a) + coarse.vertices.col(b)).normalized());
        }
        m[static_cast<size_t>(c)] = found->second;
      }
      const Eigen::Vector3i corner = coarse.faces.col(f);
      mesh.faces.col(4 * f) << corner[0], m[0], m[2];
      mesh.faces.col(4 * f + 1) << corner[1], m[1], m[0];
      mesh.faces.col(4 * f + 2) << corner[2], m[2], m[1];
      mesh.faces.col(4 * f + 3) << m[0], m[1], m[2];
    }
    mesh.vertices.conservativeResize(Eigen::NoChange, mesh.vertices.cols() + std::ssize(middles));
    for (size_t i = 0; i < middles.size(); ++i) {
      mesh.vertices.col(coarse.vertices.cols() + static_cast<Eigen::Index>(i)) = middles[i];
    }
  }
  mesh.vertices *= radius;
  return mesh;
}

TEST(Curvature, OfASphereIsOneOverItsRadiusEverywhere) {
  const VertexCurvatures curvatures = CurvaturesOf(Sphere(20, 4));
  // Edges of 2 mm, surroundings of 4: a quadric differs from the sphere by (4 / 20)^2 or so.
  constexpr double kShare = 0.03;
  EXPECT_LT((20 * curvatures.maximum.array() - 1).abs().maxCoeff(), kShare);
  EXPECT_LT((20 * curvatures.minimum.array() - 1).abs().maxCoeff(), kShare);
  EXPECT_LT((400 * curvatures.Gaussian().array() - 1).abs().maxCoeff(), 2 * kShare);
  EXPECT_LT((20 * curvatures.Mean().array() - 1).abs().maxCoeff(), kShare);
}

TEST(Curvature, ComesNearerWithTheSquareOfTheEdges) {
  const auto error = [](int levels) {
    return (20 * CurvaturesOf(Sphere(20, levels)).maximum.array() - 1).abs().maxCoeff();
  };
  EXPECT_LT(error(4), error(3) / 3);
  EXPECT_LT(error(5), error(4) / 3);
}

TEST(Curvature, ChangesItsSignWithTheSideOfTheSurface) {
  const TriangleMesh sphere = Sphere(20, 2);
  TriangleMesh inside_out = sphere;
  inside_out.faces.row(0).swap(inside_out.faces.row(1));
  const VertexCurvatures outside = CurvaturesOf(sphere);
  const VertexCurvatures inside = CurvaturesOf(inside_out);
  EXPECT_TRUE(inside.maximum.isApprox(-outside.minimum, 1e-9));
  EXPECT_TRUE(inside.minimum.isApprox(-outside.maximum, 1e-9));
}

TEST(Curvature, OfAPlaneIsZeroAlsoAtItsBoundary) {
  const TriangleMesh plane =
      Sheet(12, [](double u, double v) { return Eigen::Vector3d(30 * u, 40 * v, 10 * u - 7 * v); });
  const VertexCurvatures curvatures = CurvaturesOf(plane);
  EXPECT_LT(curvatures.maximum.cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_LT(curvatures.minimum.cwiseAbs().maxCoeff(), 1e-13);
}

TEST(Curvature, OfACylinderIsOneOverItsRadiusAroundAndZeroAlong) {
  constexpr double kRadius = 25;
  const TriangleMesh cylinder = Sheet(60, [](double u, double v) {
    return Eigen::Vector3d(kRadius * std::sin(1.5 * u), 40 * v, kRadius * std::cos(1.5 * u));
  });
  const VertexCurvatures curvatures = CurvaturesOf(cylinder);
  // Irregular triangles of about 1.3 mm; the boundary counts too.
  EXPECT_LT((kRadius * curvatures.maximum.array() - 1).abs().maxCoeff(), 0.02);
  EXPECT_LT((kRadius * curvatures.minimum.array()).abs().maxCoeff(), 0.02);
}

TEST(Curvature, OfASaddleHasBothSigns) {
  constexpr double kA = 0.02;  // z = a (x^2 - y^2): at the origin -2a and +2a
  const TriangleMesh saddle = Sheet(81, [](double u, double v) {
    const double x = 10 * u;
    const double y = 10 * v;
    return Eigen::Vector3d(x, y, kA * (x * x - y * y));
  });
  const VertexCurvatures curvatures = CurvaturesOf(saddle);
  const Eigen::Index middle = 40 * 81 + 40;
  EXPECT_NEAR(curvatures.maximum(middle), 2 * kA, 0.001 * 2 * kA);
  EXPECT_NEAR(curvatures.minimum(middle), -2 * kA, 0.001 * 2 * kA);
  EXPECT_NEAR(curvatures.Mean()(middle), 0, 0.001 * 2 * kA);
  EXPECT_NEAR(curvatures.Gaussian()(middle), -4 * kA * kA, 0.002 * 4 * kA * kA);
}

TEST(Curvature, FollowsTheClosedFormOfAParaboloid) {
  constexpr double kA = 0.01;  // z = -a (x^2 + 2 y^2), convex seen from +z
  const TriangleMesh paraboloid = Sheet(101, [](double u, double v) {
    const double x = 20 * u;
    const double y = 20 * v;
    return Eigen::Vector3d(x, y, -kA * (x * x + 2 * y * y));
  });
  const VertexCurvatures curvatures = CurvaturesOf(paraboloid);
  const Eigen::VectorXd gaussian = curvatures.Gaussian();
  double inside = 0;
  double at_boundary = 0;  // On one side only, the error falls with the edges, not their square.
  for (int v = 0; v < paraboloid.VertexCount(); ++v) {
    const double x = paraboloid.vertices(0, v);
    const double y = paraboloid.vertices(1, v);
    const double slope = 1 + 4 * kA * kA * (x * x + 4 * y * y);
    const double truth = 8 * kA * kA / (slope * slope);
    const auto [low, high] = std::minmax({v / 101, v % 101});
    double& worst = low >= 3 && high <= 97 ? inside : at_boundary;
    worst = std::max(worst, std::abs(gaussian(v) - truth) / truth);
  }
  EXPECT_LT(inside, 0.02);
  EXPECT_LT(at_boundary, 0.08);
}

TEST(Curvature, DoesNotMindSlivers) {
  // Rows 0.2 and 1.8 mm apart by turns, vertices 1.2 mm apart: flat triangles on a cylinder.
  constexpr double kRadius = 30;
  TriangleMesh cylinder = testing::WavySheet(40);
  for (int row = 0; row < 40; ++row) {
    for (int column = 0; column < 40; ++column) {
      const double angle = 0.04 * column + (row % 2 == 0 ? 0 : 0.02);
      const double height = row % 2 == 0 ? row : row - 0.8;
      cylinder.vertices.col(row * 40 + column) << kRadius * std::sin(angle), height,
          kRadius * std::cos(angle);
    }
  }
  const VertexCurvatures curvatures = CurvaturesOf(cylinder);
  EXPECT_LT((kRadius * curvatures.maximum.array() - 1).abs().maxCoeff(), 0.02);
  EXPECT_LT((kRadius * curvatures.minimum.array()).abs().maxCoeff(), 0.02);
}

TEST(Curvature, ScalesInverselyWithTheMesh) {
  TriangleMesh sheet = testing::WavySheet(20);
  const VertexCurvatures before = CurvaturesOf(sheet);
  sheet.vertices *= 4;
  const VertexCurvatures after = CurvaturesOf(sheet);
  EXPECT_TRUE(after.maximum.isApprox(before.maximum / 4, 1e-9));
  EXPECT_TRUE(after.minimum.isApprox(before.minimum / 4, 1e-9));
}

TEST(Curvature, DoesNotChangeWithThePose) {
  TriangleMesh sheet = testing::WavySheet(20);
  const VertexCurvatures before = CurvaturesOf(sheet);
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(1.1, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  sheet.vertices = (R * sheet.vertices).colwise() + Eigen::Vector3d(10, -20, 300);
  const VertexCurvatures after = CurvaturesOf(sheet);
  EXPECT_TRUE(after.maximum.isApprox(before.maximum, 1e-9));
  EXPECT_TRUE(after.minimum.isApprox(before.minimum, 1e-9));
}

TEST(Curvature, HoldsAtAnOpenBoundary) {
  const TriangleMesh cap = Sheet(40, [](double u, double v) {
    return Eigen::Vector3d(50 * u, 50 * v, std::sqrt(100 * 100 - 2500 * (u * u + v * v)));
  });
  const VertexCurvatures curvatures = CurvaturesOf(cap);
  EXPECT_LT((100 * curvatures.maximum.array() - 1).abs().maxCoeff(), 0.02);
  EXPECT_LT((100 * curvatures.minimum.array() - 1).abs().maxCoeff(), 0.02);
}

TEST(Curvature, LooksAtNoMoreThanItsShareOfAFan) {
  constexpr int kRim = 20000;  // all of them around vertex 0, and around each other through it
  TriangleMesh cone;
  cone.vertices.resize(3, kRim + 1);
  cone.faces.resize(3, kRim);
  cone.vertices.col(0) << 0, 0, 10;
  for (int i = 0; i < kRim; ++i) {
    const double angle = 2 * M_PI * i / kRim;
    cone.vertices.col(i + 1) << 50 * std::cos(angle), 50 * std::sin(angle), 0;
    cone.faces.col(i) << 0, i + 1, (i + 1) % kRim + 1;
  }
  const VertexCurvatures curvatures = CurvaturesOf(cone);  // quadratic time would not end
  EXPECT_TRUE(curvatures.maximum.allFinite());
}

TEST(Curvature, IsFiniteWhereThereIsNothingToMeasure) {
  // Too few vertices for a quadric; a face without area; a vertex without faces.
  TriangleMesh odd = Together(
      testing::MakeMesh({{0, 0, 0}, {9, 0, 0}, {0, 9, 0}, {9, 9, 4}}, {{0, 1, 2}, {1, 3, 2}}),
      testing::MakeMesh({{0, 0, 0}, {1, 1, 1}, {2, 2, 2}, {5, 6, 7}}, {{0, 1, 2}}), {100, 0, 0});
  const VertexCurvatures curvatures = CurvaturesOf(odd);
  EXPECT_EQ(curvatures.maximum, Eigen::VectorXd::Zero(8));
  EXPECT_EQ(curvatures.minimum, Eigen::VectorXd::Zero(8));
  TriangleMesh cloud = Tetrahedron();
  cloud.faces.resize(3, 0);
  EXPECT_EQ(CurvaturesOf(cloud).maximum, Eigen::VectorXd::Zero(4));
}

}  // namespace
}  // namespace cohort
