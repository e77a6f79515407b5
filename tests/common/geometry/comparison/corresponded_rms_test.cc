#include "common/geometry/comparison/corresponded_rms.h"

#include <cmath>
#include <limits>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/random.h"

namespace cohort {
namespace {

Eigen::Matrix3Xf SomeField(uint64_t seed, int64_t vertices) {
  Random random(seed);
  Eigen::Matrix3Xf field(3, vertices);
  for (Eigen::Index i = 0; i < field.size(); ++i) {
    field.data()[i] = static_cast<float>(6 * random.Uniform() - 3);
  }
  return field;
}

DisplacementFields SomeFields(uint64_t seed, int64_t meshes, int64_t vertices) {
  DisplacementFields fields(vertices);
  for (int64_t mesh = 0; mesh < meshes; ++mesh) {
    fields.Add(SomeField(seed + static_cast<uint64_t>(mesh), vertices));
  }
  return fields;
}

double RmsOf(const Eigen::Matrix3Xd& difference) {
  return std::sqrt(difference.squaredNorm() / static_cast<double>(difference.cols()));
}

/// Of the fields as they were rounded.
double Brute(const DisplacementFields& rows,
             int64_t row,
             const DisplacementFields& columns,
             int64_t column) {
  return RmsOf(rows.Of(row) - columns.Of(column));
}

/// Sums of doubles, here and in Brute.
constexpr double kRelative = 1e-12;

TEST(CorrespondedRms, EqualsBruteForceForAllSizes) {
  for (const int64_t vertices : {1, 5, 10, 11, 32, 341, 342, 9000}) {
    for (const int64_t meshes : {1, 3, 4, 17}) {
      const DisplacementFields rows = SomeFields(1, meshes, vertices);
      const DisplacementFields columns = SomeFields(100, meshes + 2, vertices);
      const Eigen::MatrixXd rms = CorrespondedRms(rows, columns);
      ASSERT_EQ(rms.rows(), meshes);
      ASSERT_EQ(rms.cols(), meshes + 2);
      for (int64_t i = 0; i < rms.rows(); ++i) {
        for (int64_t j = 0; j < rms.cols(); ++j) {
          const double truth = Brute(rows, i, columns, j);
          EXPECT_NEAR(rms(i, j), truth, kRelative * truth)
              << vertices << " vertices, " << i << ", " << j;
        }
      }
    }
  }
}

TEST(CorrespondedRms, EqualsBruteForceForFieldsOfUnlikeSize) {
  DisplacementFields fields(300);
  for (const float size : {1e-30F, 1e-3F, 1.0F, 1.4F, 300.0F, 1e20F, 0.0F}) {
    fields.Add(size * SomeField(5, 300));
  }
  const Eigen::MatrixXd rms = CorrespondedRms(fields, fields);
  for (int64_t i = 0; i < rms.rows(); ++i) {
    for (int64_t j = 0; j < rms.cols(); ++j) {
      const double truth = Brute(fields, i, fields, j);
      EXPECT_NEAR(rms(i, j), truth, kRelative * truth) << i << ", " << j;
    }
  }
}

TEST(CorrespondedRms, IsSymmetricWithAnExactlyZeroDiagonalWhateverTheBlocks) {
  const DisplacementFields fields = SomeFields(7, 21, 700);
  const Eigen::MatrixXd rms = CorrespondedRms(fields, fields);
  EXPECT_EQ(rms, Eigen::MatrixXd(rms.transpose()));
  EXPECT_EQ(rms.diagonal().cwiseAbs().maxCoeff(), 0);
  const DisplacementFields some = SomeFields(7 + 3, 2, 700);
  EXPECT_EQ(CorrespondedRms(fields, some), Eigen::MatrixXd(rms.middleCols(3, 2)));
  EXPECT_EQ(CorrespondedRms(some, fields), Eigen::MatrixXd(rms.middleRows(3, 2)));
}

/// As the header states it; the second field crosses from one step to the next.
TEST(CorrespondedRms, OfTheDisplacementsBeforeIsWithinTheStatedError) {
  const Eigen::Matrix3Xf field = SomeField(3, 500);
  for (const float change : {10.0F, 1.0F, 0.4F, 1e-1F, 1e-3F, 1e-5F, 0.0F}) {
    const Eigen::Matrix3Xf other = field + change * SomeField(4, 500);
    DisplacementFields fields(500);
    fields.Add(field);
    fields.Add(other);
    const double truth = RmsOf(field.cast<double>() - other.cast<double>());
    const double bound = std::sqrt(3.0) / 2 * (fields.Step(0) + fields.Step(1));
    const double largest = static_cast<double>(field.cwiseAbs().maxCoeff()) +
                           static_cast<double>(other.cwiseAbs().maxCoeff());
    EXPECT_LE(bound, largest / 4700) << change;
    EXPECT_NEAR(CorrespondedRms(fields, fields)(0, 1), truth, bound) << change;
  }
}

TEST(CorrespondedRms, GrowsByEvenlySpreadRoundingsAsStated) {
  constexpr int64_t kVertices = 20'000;
  const Eigen::Matrix3Xf field = SomeField(3, kVertices);
  const Eigen::Matrix3Xf other = field + SomeField(4, kVertices) * 0.01F;
  DisplacementFields fields(kVertices);
  fields.Add(field);
  fields.Add(other);
  const double s = fields.Step(0);
  const double t = fields.Step(1);
  const double truth = RmsOf(field.cast<double>() - other.cast<double>());
  const double growth = CorrespondedRms(fields, fields)(0, 1) - truth;
  // Of 60,000 roundings the spread is a few percent of this.
  EXPECT_NEAR(growth / ((s * s + t * t) / (8 * truth)), 1, 0.3);
}

TEST(CorrespondedRms, OfATranslationIsItsLength) {
  DisplacementFields fields(100);
  fields.Add(Eigen::Matrix3Xf::Zero(3, 100));
  fields.Add(Eigen::Matrix3Xf::Ones(3, 100) * 2);
  EXPECT_DOUBLE_EQ(CorrespondedRms(fields, fields)(0, 1), std::sqrt(12.0));
}

/// Where 32 bits would be too few at once: all products are as large as they come.
TEST(CorrespondedRms, OfTheLargestStepsDoesNotOverflow) {
  DisplacementFields fields(20'000);
  fields.Add(Eigen::Matrix3Xf::Constant(3, 20'000, 8191));
  fields.Add(Eigen::Matrix3Xf::Constant(3, 20'000, -8191));
  ASSERT_EQ(fields.Values(0)[0], 8191);
  EXPECT_DOUBLE_EQ(CorrespondedRms(fields, fields)(0, 1), std::sqrt(3.0) * 2 * 8191);
}

int32_t StepExponentOf(float largest) {
  DisplacementFields fields(2);
  Eigen::Matrix3Xf field = Eigen::Matrix3Xf::Zero(3, 2);
  field(1, 1) = -largest;
  fields.Add(field);
  return fields.StepExponent(0);
}

TEST(DisplacementFields, TakeTheSmallestStepThatIsLargeEnough) {
  EXPECT_EQ(StepExponentOf(8191), 0);
  EXPECT_EQ(StepExponentOf(8191.4375F), 0);
  EXPECT_EQ(StepExponentOf(8191.5F), 1);
  EXPECT_EQ(StepExponentOf(4095.75F), 0);
  EXPECT_EQ(StepExponentOf(4095.7F), -1);
  EXPECT_EQ(StepExponentOf(15.9F), -9);
  EXPECT_EQ(StepExponentOf(16.0F), -8);
  EXPECT_EQ(StepExponentOf(std::numeric_limits<float>::max()), 116);
  EXPECT_EQ(StepExponentOf(std::numeric_limits<float>::denorm_min()), -100);
}

TEST(DisplacementFields, AreWithinHalfAStepOfWhatWasAdded) {
  for (const float size : {1e-25F, 1e-3F, 1.0F, 1e6F, 1e37F}) {
    const Eigen::Matrix3Xf field = size * SomeField(11, 777);
    DisplacementFields fields(777);
    fields.Add(field);
    const Eigen::Matrix3Xd difference = fields.Of(0) - field.cast<double>();
    EXPECT_LE(difference.cwiseAbs().maxCoeff(), fields.Step(0) / 2) << size;
  }
}

TEST(DisplacementFields, ComeBackFromTheirSteps) {
  const DisplacementFields fields = SomeFields(1, 1, 45);
  DisplacementFields again(45);
  ASSERT_TRUE(DisplacementFields::MayAdd(fields.StepExponent(0), fields.Values(0)));
  again.AddSteps(fields.StepExponent(0), fields.Values(0));
  EXPECT_EQ(again.Of(0), fields.Of(0));
}

TEST(DisplacementFields, MayNotHaveMoreStepsThanTheProductsTake) {
  const std::vector<int16_t> most = {8191, -8191, 0};
  EXPECT_TRUE(DisplacementFields::MayAdd(-100, most));
  EXPECT_TRUE(DisplacementFields::MayAdd(116, most));
  EXPECT_FALSE(DisplacementFields::MayAdd(-101, most));
  EXPECT_FALSE(DisplacementFields::MayAdd(117, most));
  EXPECT_FALSE(DisplacementFields::MayAdd(0, std::vector<int16_t>{0, 8192, 0}));
  EXPECT_FALSE(DisplacementFields::MayAdd(0, std::vector<int16_t>{0, 0, -8192}));
}

}  // namespace
}  // namespace cohort
