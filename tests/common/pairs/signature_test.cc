#include "common/pairs/signature.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cohort {
namespace {

using ::testing::ElementsAre;

TEST(SignatureVertices, AreAllOfAFew) {
  EXPECT_THAT(SignatureVertices(1), ElementsAre(0));
  EXPECT_THAT(SignatureVertices(3), ElementsAre(0, 1, 2));
  EXPECT_EQ(SignatureVertices(kSignaturePoints).back(), kSignaturePoints - 1);
}

class SignatureVerticesOf : public ::testing::TestWithParam<int64_t> {};

TEST_P(SignatureVerticesOf, AreSpreadEvenlyOverTheOrder) {
  const int64_t n = GetParam();
  const std::vector<int32_t> vertices = SignatureVertices(n);
  ASSERT_EQ(std::ssize(vertices), kSignaturePoints);
  const int64_t least = n / kSignaturePoints;
  for (size_t k = 1; k < vertices.size(); ++k) {
    EXPECT_GE(vertices[k] - vertices[k - 1], least);
    EXPECT_LE(vertices[k] - vertices[k - 1], least + 1);
  }
  EXPECT_LT(vertices.back(), n);
}

INSTANTIATE_TEST_SUITE_P(Sizes,
                         SignatureVerticesOf,
                         ::testing::Values(513, 1000, 1024, 20'000, 2'000'000'000));

TEST(SignatureOf, TakesTheDisplacementsThere) {
  Eigen::Matrix3Xd displacements(3, 2000);
  for (Eigen::Index i = 0; i < displacements.cols(); ++i) {
    displacements.col(i) << static_cast<double>(i), -1, 0.5;
  }
  const Eigen::Matrix3Xf signature = SignatureOf(displacements);
  const std::vector<int32_t> vertices = SignatureVertices(2000);
  ASSERT_EQ(signature.cols(), kSignaturePoints);
  for (Eigen::Index k = 0; k < signature.cols(); ++k) {
    EXPECT_EQ(signature.col(k),
              Eigen::Vector3f(static_cast<float>(vertices[static_cast<size_t>(k)]), -1, 0.5F));
  }
}

}  // namespace
}  // namespace cohort
