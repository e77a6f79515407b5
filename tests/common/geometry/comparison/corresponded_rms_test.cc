#include "common/geometry/comparison/corresponded_rms.h"

#include <cmath>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/random.h"
#include "common/geometry/comparison/field_kernels.h"

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

double Brute(const DisplacementFields& rows,
             int64_t row,
             const DisplacementFields& columns,
             int64_t column) {
  const Eigen::Matrix3Xd difference =
      rows.Of(row).cast<double>() - columns.Of(column).cast<double>();
  return std::sqrt(difference.squaredNorm() / static_cast<double>(rows.VertexCount()));
}

TEST(CorrespondedRms, EqualsBruteForceForAllSizes) {
  for (const int64_t vertices : {1, 5, 16, 17, 341, 342, 9000}) {
    for (const int64_t meshes : {1, 3, 4, 17}) {
      const DisplacementFields rows = SomeFields(1, meshes, vertices);
      const DisplacementFields columns = SomeFields(100, meshes + 2, vertices);
      const Eigen::MatrixXd rms = CorrespondedRms(rows, columns);
      ASSERT_EQ(rms.rows(), meshes);
      ASSERT_EQ(rms.cols(), meshes + 2);
      for (int64_t i = 0; i < rms.rows(); ++i) {
        for (int64_t j = 0; j < rms.cols(); ++j) {
          const double truth = Brute(rows, i, columns, j);
          EXPECT_NEAR(rms(i, j), truth, 5e-6 * truth)
              << vertices << " vertices, " << i << ", " << j;
        }
      }
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

TEST(CorrespondedRms, LosesNoDigitsWhereFieldsAreNearlyTheSame) {
  for (const float change : {1e-1F, 1e-3F, 1e-5F, 0.0F}) {
    DisplacementFields fields(500);
    const Eigen::Matrix3Xf field = SomeField(3, 500);
    fields.Add(field);
    fields.Add(field + change * SomeField(4, 500));
    const double truth = Brute(fields, 0, fields, 1);
    EXPECT_NEAR(CorrespondedRms(fields, fields)(0, 1), truth, 1e-4 * truth) << change;
  }
}

TEST(CorrespondedRms, OfATranslationIsItsLength) {
  DisplacementFields fields(100);
  fields.Add(Eigen::Matrix3Xf::Zero(3, 100));
  fields.Add(Eigen::Matrix3Xf::Ones(3, 100) * 2);
  EXPECT_DOUBLE_EQ(CorrespondedRms(fields, fields)(0, 1), std::sqrt(12.0));
}

TEST(FieldKernels, AddTheSameProductsOnAllInstructionSets) {
  constexpr int64_t kRows = 700;
  std::vector<Eigen::Matrix3Xf> fields;
  fields.reserve(size_t{2} * kFieldTile);
  for (uint64_t seed = 0; seed < uint64_t{2} * kFieldTile; ++seed) {
    fields.push_back(SomeField(seed, kRows * kFieldLanes));
  }
  std::vector<const float*> sides;
  sides.reserve(fields.size());
  for (const Eigen::Matrix3Xf& field : fields) {
    sides.push_back(field.data());
  }
  std::vector<double> expected;
  for (const FieldKernels* kernels : RunnableFieldKernels()) {
    std::vector<double> lanes(kFieldTileLanes, 0.5);
    kernels->add_products(sides.data(), sides.data() + kFieldTile, kRows, lanes.data());
    if (expected.empty()) {
      expected = lanes;
    }
    EXPECT_EQ(lanes, expected) << kernels->name;
  }
}

}  // namespace
}  // namespace cohort
