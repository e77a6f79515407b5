#include "common/geometry/comparison/product_kernels.h"

#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/random.h"

namespace cohort {
namespace {

constexpr int64_t kSides = int64_t{2} * kProductTile;

std::vector<int16_t> RandomValues(Random& random, int64_t rows) {
  std::vector<int16_t> values(static_cast<size_t>(rows * kProductRow));
  for (int16_t& value : values) {
    value = static_cast<int16_t>(static_cast<int>(random.Below(2 * kLargestFactor + 1)) -
                                 kLargestFactor);
  }
  return values;
}

/// Every second field of the largest values, the others of the smallest.
std::vector<int16_t> ExtremeValues(int64_t field, int64_t rows) {
  const int value = field % 2 == 0 ? kLargestFactor : -kLargestFactor;
  return std::vector<int16_t>(static_cast<size_t>(rows * kProductRow), static_cast<int16_t>(value));
}

void ExpectProductsOfBruteForce(const std::vector<std::vector<int16_t>>& fields, int64_t rows) {
  std::array<const int16_t*, kSides> sides{};
  for (size_t k = 0; k < sides.size(); ++k) {
    sides[k] = fields[k].data();
  }
  for (const ProductKernels* kernels : RunnableProductKernels()) {
    std::vector<int64_t> lanes(kProductTileLanes, 3);
    kernels->add_products(sides.data(), sides.data() + kProductTile, rows, lanes.data());
    for (size_t i = 0; i < kProductTile; ++i) {
      for (size_t j = 0; j < kProductTile; ++j) {
        const std::vector<int16_t>& a = fields[i];
        const std::vector<int16_t>& b = fields[kProductTile + j];
        const int64_t truth =
            std::inner_product(a.begin(), a.end(), b.begin(), int64_t{3} * kProductLanes,
                               std::plus<>(), [](int16_t x, int16_t y) { return int64_t{x} * y; });
        const auto begin =
            lanes.begin() + static_cast<int64_t>(i * kProductTile + j) * kProductLanes;
        EXPECT_EQ(std::accumulate(begin, begin + kProductLanes, int64_t{0}), truth)
            << kernels->name << ", " << rows << " rows, " << i << ", " << j;
      }
    }
  }
}

class ProductsOfRows : public ::testing::TestWithParam<int64_t> {};

TEST_P(ProductsOfRows, AreThoseOfBruteForceOnAllInstructionSets) {
  Random random(1);
  std::vector<std::vector<int16_t>> fields;
  fields.reserve(kSides);
  for (int64_t k = 0; k < kSides; ++k) {
    fields.push_back(RandomValues(random, GetParam()));
  }
  ExpectProductsOfBruteForce(fields, GetParam());
}

TEST_P(ProductsOfRows, DoNotOverflowForTheLargestValues) {
  std::vector<std::vector<int16_t>> fields;
  fields.reserve(kSides);
  for (int64_t k = 0; k < kSides; ++k) {
    fields.push_back(ExtremeValues(k, GetParam()));
  }
  ExpectProductsOfBruteForce(fields, GetParam());
}

INSTANTIATE_TEST_SUITE_P(Sizes, ProductsOfRows, ::testing::Values(0, 1, 7, 8, 15, 16, 17, 64, 701));

TEST(ProductKernels, RoundToTheNearestAndTiesToTheEven) {
  Random random(2);
  std::vector<float> values(size_t{40} * kProductRow);
  for (float& value : values) {
    value = static_cast<float>(random.Uniform(-kLargestFactor, kLargestFactor));
  }
  for (int k = 0; k < 600; ++k) {
    values[static_cast<size_t>(k)] = static_cast<float>(k - 300) / 2;
  }
  values[600] = kLargestFactor;
  values[601] = -kLargestFactor;
  values[602] = -0.0F;
  values[603] = std::numeric_limits<float>::denorm_min();
  for (const float factor : {0x1p-100F, 0.25F, 1.0F}) {
    for (const ProductKernels* kernels : RunnableProductKernels()) {
      std::vector<int16_t> result(values.size());
      kernels->quantize(values.data(), 40, factor, result.data());
      for (size_t i = 0; i < values.size(); ++i) {
        ASSERT_EQ(result[i], std::nearbyint(values[i] * factor))
            << kernels->name << ": " << values[i] << " * " << factor;
      }
    }
  }
}

TEST(ProductKernels, FindTheLargestMagnitudeWhereverItIs) {
  constexpr int64_t kRows = 3;
  Random random(3);
  for (size_t at = 0; at < size_t{kRows} * kProductRow; ++at) {
    std::vector<float> values(size_t{kRows} * kProductRow);
    for (float& value : values) {
      value = static_cast<float>(random.Uniform(-1, 1));
    }
    values[at] = at % 2 == 0 ? 1.5F : -1.5F;
    for (const ProductKernels* kernels : RunnableProductKernels()) {
      EXPECT_EQ(std::bit_cast<float>(kernels->largest(values.data(), kRows)), 1.5F)
          << kernels->name << " at " << at;
    }
  }
}

TEST(ProductKernels, TellOfValuesThatAreNotFinite) {
  for (const float bad :
       {std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity(),
        std::numeric_limits<float>::quiet_NaN(), -std::numeric_limits<float>::quiet_NaN()}) {
    std::vector<float> values(kProductRow, -std::numeric_limits<float>::max());
    for (const ProductKernels* kernels : RunnableProductKernels()) {
      values[17] = 0;
      EXPECT_EQ(kernels->largest(values.data(), 1), 0x7F7FFFFFU) << kernels->name;
      values[17] = bad;
      EXPECT_GE(kernels->largest(values.data(), 1), 0x7F800000U) << kernels->name << ", " << bad;
    }
  }
}

TEST(RunnableProductKernels, BeginWithThePortableOnesAndHoldTheBest) {
  EXPECT_EQ(RunnableProductKernels().front()->name, "portable");
  EXPECT_THAT(RunnableProductKernels(), ::testing::Contains(&BestProductKernels()));
}

}  // namespace
}  // namespace cohort
