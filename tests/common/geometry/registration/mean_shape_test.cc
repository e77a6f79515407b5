#include "common/geometry/registration/mean_shape.h"

#include <vector>

#include <gtest/gtest.h>

#include "tests/common/geometry/registration/bumpy_surface.h"

namespace cohort {
namespace {

using testing::BumpySurface;
using testing::MakeSimilarity;

Eigen::Matrix3Xd Displacement(const Eigen::Matrix3Xd& reference,
                              const Eigen::Matrix3Xd& source,
                              const Similarity& T_reference_source) {
  PacketSearch search;
  return DisplacementToMesh(reference, IcpMesh(reference), source, IcpMesh(source),
                            T_reference_source, search);
}

TEST(DisplacementToMesh, EqualsBruteForce) {
  const Eigen::Matrix3Xd reference = BumpySurface(15).vertices.colwise() + Eigen::Vector3d(9, 8, 7);
  const Eigen::Matrix3Xd source = BumpySurface(20, 2, 3).vertices;
  const Similarity T = MakeSimilarity(1.1, 12, {1, 2, 3}, {10, 8, 5});
  const Eigen::Matrix3Xd aligned = T.Apply(source);
  Eigen::Matrix3Xd expected(3, reference.cols());
  for (Eigen::Index k = 0; k < reference.cols(); ++k) {
    Eigen::Index nearest = 0;
    (aligned.colwise() - reference.col(k)).colwise().squaredNorm().minCoeff(&nearest);
    expected.col(k) = aligned.col(nearest) - reference.col(k);
  }
  EXPECT_TRUE(Displacement(reference, source, T).isApprox(expected, 1e-12));
}

TEST(DisplacementToSurface, OfATiltedPlaneIsTheDistanceToIt) {
  // Two triangles that reach far beyond the reference; all their vertices are far away.
  TriangleMesh plane;
  plane.vertices.resize(3, 4);
  plane.vertices << -500, 500, 500, -500, -500, -500, 500, 500, 0, 0, 0, 0;
  plane.faces.resize(3, 2);
  plane.faces << 0, 0, 1, 2, 2, 3;
  const Similarity T = MakeSimilarity(1.2, 20, {1, 2, 0}, {1, 2, 3});
  const Eigen::Vector3d normal = T.rotation * Eigen::Vector3d::UnitZ();
  const Eigen::Matrix3Xd reference = BumpySurface(15).vertices.colwise() + Eigen::Vector3d(1, 2, 9);
  SurfaceSearch search;
  const Eigen::Matrix3Xd found =
      DisplacementToSurface(reference, IcpMesh(reference), IcpMesh::WithSurface(plane), T, search);
  const Eigen::RowVectorXd heights =
      normal.transpose() * (reference.colwise() - T.ApplyToPoint(Eigen::Vector3d::Zero()));
  EXPECT_LT((found + normal * heights).cwiseAbs().maxCoeff(), 1e-4);
}

TEST(DisplacementToMesh, IsZeroToTheMeshItself) {
  const Eigen::Matrix3Xd reference = BumpySurface(15).vertices;
  EXPECT_EQ(Displacement(reference, reference, {}), Eigen::Matrix3Xd::Zero(3, reference.cols()));
}

TEST(DisplacementToMesh, IsASmallShiftOfACopy) {
  const Eigen::Matrix3Xd reference = BumpySurface(15).vertices;
  const Eigen::Vector3d shift(0.01, -0.02, 0.03);
  const Eigen::Matrix3Xd displacement = Displacement(reference, reference.colwise() + shift, {});
  EXPECT_TRUE(displacement.isApprox(shift.replicate(1, reference.cols()), 1e-10));
}

TEST(MoveByMeanDisplacement, AddsTheMeanOfAllBatches) {
  const Eigen::Matrix3Xd reference = BumpySurface(5).vertices;
  const Eigen::Vector3d step(3, -6, 9);
  const Eigen::Matrix3Xd once = step.replicate(1, reference.cols());
  const std::vector<Eigen::Matrix3Xd> partial_sums = {2 * once, -once, 5 * once};
  EXPECT_TRUE(
      MoveByMeanDisplacement(reference, partial_sums, 12).isApprox(reference + 0.5 * once, 1e-14));
}

TEST(MoveByMeanDisplacement, LeavesTheReferenceWithoutBatches) {
  const Eigen::Matrix3Xd reference = BumpySurface(5).vertices;
  EXPECT_EQ(MoveByMeanDisplacement(reference, {}, 3), reference);
}

TEST(MeanShape, MovesAFlatReferenceToTheMeanHeight) {
  // Sheets of one grid at heights 0, 1, 5, 6: each nearest vertex is straight above.
  Eigen::Matrix3Xd reference(3, 400);
  for (Eigen::Index i = 0; i < 400; ++i) {
    const Eigen::Index row = i / 20;
    reference.col(i) << 10.0 * static_cast<double>(row), 10.0 * static_cast<double>(i % 20), 0;
  }
  std::vector<Eigen::Matrix3Xd> displacements;
  for (const double height : {0.0, 1.0, 5.0, 6.0}) {
    displacements.push_back(
        Displacement(reference, reference.colwise() + Eigen::Vector3d(0, 0, height), {}));
  }
  const Eigen::Matrix3Xd mean = MoveByMeanDisplacement(reference, displacements, 4);
  EXPECT_EQ(mean, reference.colwise() + Eigen::Vector3d(0, 0, 3));
}

}  // namespace
}  // namespace cohort
