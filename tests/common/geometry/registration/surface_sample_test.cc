#include "common/geometry/registration/surface_sample.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/common/geometry/registration/bumpy_surface.h"

namespace cohort {
namespace {

using testing::BumpySurface;
using testing::MakeSimilarity;

/// Rectangle 0..2a x 0..b; the left half has cells * cells squares, the right half two triangles.
TriangleMesh UnevenRectangle(double a, double b, int cells) {
  TriangleMesh mesh;
  const int rows = cells + 1;
  mesh.vertices.resize(3, rows * rows + 4);
  mesh.faces.resize(3, 2 * cells * cells + 2);
  Eigen::Index face = 0;
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < rows; ++j) {
      mesh.vertices.col(i * rows + j) << a * i / cells, b * j / cells, 0;
      if (i < cells && j < cells) {
        const int corner = i * rows + j;
        mesh.faces.col(face++) << corner, corner + rows, corner + rows + 1;
        mesh.faces.col(face++) << corner, corner + rows + 1, corner + 1;
      }
    }
  }
  const int first = rows * rows;
  mesh.vertices.rightCols(4) << a, 2 * a, 2 * a, a, 0, 0, b, b, 0, 0, 0, 0;
  mesh.faces.col(face++) << first, first + 1, first + 2;
  mesh.faces.col(face++) << first, first + 2, first + 3;
  return mesh;
}

Eigen::Matrix3Xd SampleSurface(const TriangleMesh& mesh, Eigen::Index count) {
  return SurfaceSampler(mesh).Sample(count);
}

PrincipalFrame FrameOf(const TriangleMesh& mesh) {
  return SurfaceSampler(mesh).Frame();
}

TEST(SurfaceSampler, SpreadsThePointsByArea) {
  const Eigen::Matrix3Xd points = SampleSurface(UnevenRectangle(10, 7, 20), 1000);
  ASSERT_EQ(points.cols(), 1000);
  EXPECT_NEAR(static_cast<double>((points.row(0).array() > 10).count()), 500, 1);
  EXPECT_NEAR(static_cast<double>((points.row(0).array() > 15).count()), 250, 10);
  EXPECT_NEAR(static_cast<double>((points.row(1).array() > 3.5).count()), 500, 20);
}

TEST(SurfaceSampler, StaysOnTheSurface) {
  const Eigen::Matrix3Xd points = SampleSurface(UnevenRectangle(10, 7, 20), 1000);
  EXPECT_GE(points.row(0).minCoeff(), 0);
  EXPECT_LE(points.row(0).maxCoeff(), 20);
  EXPECT_GE(points.row(1).minCoeff(), 0);
  EXPECT_LE(points.row(1).maxCoeff(), 7);
  EXPECT_TRUE(points.row(2).isZero(0));
}

TEST(SurfaceSampler, MovesWithTheMesh) {
  const TriangleMesh mesh = BumpySurface(20);
  const Similarity T = MakeSimilarity(1, 100, {1, 2, 3}, {4, 5, 6});
  TriangleMesh moved = mesh;
  moved.vertices = T.Apply(mesh.vertices);
  EXPECT_TRUE(SampleSurface(moved, 300).isApprox(T.Apply(SampleSurface(mesh, 300)), 1e-9));
}

TEST(SurfaceSampler, TakesVerticesOfAPointCloud) {
  TriangleMesh cloud = BumpySurface(20);
  cloud.faces.resize(3, 0);
  EXPECT_EQ(SampleSurface(cloud, 100).cols(), 100);
  EXPECT_EQ(SampleSurface(cloud, 1000), cloud.vertices);
}

TEST(SurfaceSamplerFrame, DoesNotDependOnDensity) {
  // Closed form of a 20 x 7 rectangle: variance of a uniform distribution, length^2 / 12.
  const PrincipalFrame frame = FrameOf(UnevenRectangle(10, 7, 40));
  EXPECT_TRUE(frame.centroid.isApprox(Eigen::Vector3d(10, 3.5, 0), 1e-12));
  EXPECT_NEAR(frame.deviations(0), 0, 1e-9);
  EXPECT_NEAR(frame.deviations(1), 7 / std::sqrt(12), 1e-9);
  EXPECT_NEAR(frame.deviations(2), 20 / std::sqrt(12), 1e-9);
  EXPECT_NEAR(std::abs(frame.axes(0, 2)), 1, 1e-9);
}

TEST(SurfaceSamplerFrame, IsARotationThatTurnsWithTheMesh) {
  const TriangleMesh mesh = BumpySurface(20);
  const Similarity T = MakeSimilarity(1, 100, {1, 2, 3}, {4, 5, 6});
  TriangleMesh moved = mesh;
  moved.vertices = T.Apply(mesh.vertices);
  const PrincipalFrame frame = FrameOf(mesh);
  const PrincipalFrame moved_frame = FrameOf(moved);
  EXPECT_NEAR(frame.axes.determinant(), 1, 1e-12);
  EXPECT_NEAR(moved_frame.axes.determinant(), 1, 1e-12);
  EXPECT_TRUE(moved_frame.centroid.isApprox(T.ApplyToPoint(frame.centroid), 1e-12));
  EXPECT_TRUE(moved_frame.deviations.isApprox(frame.deviations, 1e-9));
  const Eigen::Matrix3d cosines = moved_frame.axes.transpose() * (T.rotation * frame.axes);
  EXPECT_TRUE(cosines.cwiseAbs().isApprox(Eigen::Matrix3d::Identity(), 1e-9));
}

}  // namespace
}  // namespace cohort
