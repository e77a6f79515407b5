#include "common/geometry/registration/fidentis_mean_shape.h"

#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/common/geometry/registration/bumpy_surface.h"

namespace cohort {
namespace {

using testing::BumpySurface;

TEST(FidentisDisplacement, IsTheStepToTheNearestVertexByBruteForce) {
  const Eigen::Matrix3Xf reference = BumpySurface(12).vertices.cast<float>();
  const Eigen::Matrix3Xf aligned = BumpySurface(15, 2, 3).vertices.cast<float>();
  const Eigen::Matrix3Xf displacement =
      FidentisDisplacement(reference, *NearestVertex::Build(aligned));
  Eigen::Matrix3Xf expected(3, reference.cols());
  for (Eigen::Index k = 0; k < reference.cols(); ++k) {
    Eigen::Index nearest = 0;
    (aligned.colwise() - reference.col(k)).colwise().squaredNorm().minCoeff(&nearest);
    expected.col(k) = aligned.col(nearest) - reference.col(k);
  }
  EXPECT_EQ(displacement, expected);
}

TEST(FidentisMeanShape, MovesByTheMeanDisplacement) {
  const Eigen::Matrix3Xf reference = Eigen::Matrix3Xf::Constant(3, 2, 10);
  FidentisMeanShape mean(reference);
  mean.Add(Eigen::Matrix3Xf::Constant(3, 2, 1));
  mean.Add(Eigen::Matrix3Xf::Constant(3, 2, 5));
  mean.Add(Eigen::Matrix3Xf::Constant(3, 2, -9));
  EXPECT_EQ(mean.Moved(), Eigen::Matrix3Xf::Constant(3, 2, 9));
}

TEST(FidentisMeanShape, AddsFloatsInTheOrderOfTheMeshes) {
  const Eigen::Matrix3Xf large = Eigen::Matrix3Xf::Constant(3, 1, 1e8F);
  const Eigen::Matrix3Xf small = Eigen::Matrix3Xf::Constant(3, 1, 2);
  FidentisMeanShape swallowed(Eigen::Matrix3Xf::Zero(3, 1));
  FidentisMeanShape kept(Eigen::Matrix3Xf::Zero(3, 1));
  for (const Eigen::Matrix3Xf& displacement : {large, small, Eigen::Matrix3Xf(-large)}) {
    swallowed.Add(displacement);
  }
  for (const Eigen::Matrix3Xf& displacement : {large, Eigen::Matrix3Xf(-large), small}) {
    kept.Add(displacement);
  }
  EXPECT_EQ(swallowed.Moved(), Eigen::Matrix3Xf::Zero(3, 1));
  EXPECT_EQ(kept.Moved(), small / 3.0F);
}

TEST(FidentisMeanShape, LeavesTheReferenceWithoutMeshes) {
  const Eigen::Matrix3Xf reference = BumpySurface(5).vertices.cast<float>();
  EXPECT_EQ(FidentisMeanShape(reference).Moved(), reference);
}

}  // namespace
}  // namespace cohort
