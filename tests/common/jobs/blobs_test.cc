#include "common/jobs/blobs.h"

#include <cmath>
#include <functional>
#include <limits>

#include <gtest/gtest.h>

#include "common/base/byte_io.h"
#include "common/base/random.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::cohort::testing::IsOk;
using ::cohort::testing::StatusIs;

constexpr auto kDataLoss = absl::StatusCode::kDataLoss;

std::vector<MeshAlignment> SomeAlignments() {
  std::vector<MeshAlignment> alignments(2);
  alignments[0].mesh = 3;
  alignments[1].mesh = 7;
  Alignment& alignment = alignments[1].alignment;
  alignment.T_target_source.scale = 1.0 / 3;
  alignment.T_target_source.rotation << 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9;
  alignment.T_target_source.translation << 1e-300, -0.0, 12345.678901234567;
  alignment.iterations = 17;
  alignment.converged = true;
  alignment.rms_residual = 0.1 + 0.2;
  alignment.mean_residual = std::nextafter(1.0, 2.0);
  alignment.lookups = int64_t{1} << 40;
  return alignments;
}

MetricValues SomeValues(double first) {
  MetricValues values{};
  for (size_t i = 0; i < values.size(); ++i) {
    values[i] = first + static_cast<double>(i) / 3;
  }
  return values;
}

std::vector<MetricBlock> SomeTile() {
  MetricBlock down{.sources = {0, 1}, .targets = {2, 3, 4}, .values = {}};
  for (int i = 0; i < 6; ++i) {
    down.values.push_back(SomeValues(i));
  }
  const MetricBlock across{.sources = {9}, .targets = {0}, .values = {SomeValues(-0.0)}};
  return {down, across, MetricBlock{}};
}

VariationPart SomeVariation() {
  VariationPart part;
  part.meshes = {4, 6};
  part.distances = Eigen::MatrixXf::Random(3, 2);
  part.displacement.mesh_count = 2;
  part.displacement.sum = Eigen::Matrix3Xf::Random(3, 3);
  return part;
}

VariationSummary SomeSummary() {
  return {.mesh_count = 5, .values = {SomeValues(1), SomeValues(2)}};
}

// One kind of blob: a valid one, and what its Decode says of any bytes (the bytes again, if read).
struct Kind {
  std::string name;
  std::string valid;
  std::function<absl::StatusOr<std::string>(std::string_view)> decode_and_encode;
};

template <typename T>
Kind MakeKind(const std::string& name,
              const T& value,
              std::string (*encode)(const T&),
              absl::StatusOr<T> (*decode)(std::string_view)) {
  return {name, encode(value), [=](std::string_view bytes) -> absl::StatusOr<std::string> {
            absl::StatusOr<T> decoded = decode(bytes);
            if (!decoded.ok()) {
              return decoded.status();
            }
            return encode(*decoded);
          }};
}

std::vector<Kind> AllKinds() {
  const DisplacementSum displacement{.mesh_count = 2, .sum = Eigen::Matrix3Xf::Random(3, 4)};
  return {MakeKind("alignment", SomeAlignments(), EncodeAlignmentBlob, DecodeAlignmentBlob),
          MakeKind("displacement", displacement, EncodeDisplacementBlob, DecodeDisplacementBlob),
          MakeKind("tile", SomeTile(), EncodeTileBlob, DecodeTileBlob),
          MakeKind("variation", SomeVariation(), EncodeVariationBlob, DecodeVariationBlob),
          MakeKind("summary", SomeSummary(), EncodeSummaryBlob, DecodeSummaryBlob)};
}

class EveryBlob : public ::testing::TestWithParam<Kind> {};

TEST_P(EveryBlob, IsReadBackToTheSameBytes) {
  EXPECT_THAT(GetParam().decode_and_encode(GetParam().valid),
              cohort::testing::IsOkAndHolds(GetParam().valid));
}

TEST_P(EveryBlob, IsRefusedWhenCutAnywhere) {
  for (size_t size = 0; size < GetParam().valid.size(); ++size) {
    EXPECT_THAT(GetParam().decode_and_encode(GetParam().valid.substr(0, size)),
                StatusIs(kDataLoss, GetParam().name + " blob"))
        << "cut to " << size;
  }
}

TEST_P(EveryBlob, IsRefusedWithBytesToSpare) {
  EXPECT_THAT(GetParam().decode_and_encode(GetParam().valid + '\0'),
              StatusIs(kDataLoss, "1 bytes too many"));
}

TEST_P(EveryBlob, IsRefusedWithAnotherMagic) {
  std::string bytes = GetParam().valid;
  bytes[7] = '9';
  EXPECT_THAT(GetParam().decode_and_encode(bytes), StatusIs(kDataLoss, "does not begin with COH"));
}

// Counts may be anything; neither memory nor the reader's position may follow them blindly.
TEST_P(EveryBlob, SurvivesHostileNumbersAtEveryPlace) {
  const uint64_t numbers[] = {0,
                              1,
                              255,
                              uint64_t{1} << 31,
                              uint64_t{1} << 61,
                              uint64_t{1} << 63,
                              std::numeric_limits<uint64_t>::max()};
  for (size_t at = 8; at + 8 <= GetParam().valid.size(); ++at) {
    for (const uint64_t number : numbers) {
      std::string bytes = GetParam().valid;
      std::memcpy(bytes.data() + at, &number, sizeof(number));
      const absl::StatusOr<std::string> result = GetParam().decode_and_encode(bytes);
      if (result.ok()) {
        EXPECT_EQ(*result, bytes) << "number " << number << " at " << at;
      } else {
        EXPECT_EQ(result.status().code(), kDataLoss);
      }
    }
  }
}

TEST_P(EveryBlob, SurvivesRandomDamage) {
  for (uint64_t seed = 0; seed < 2000; ++seed) {
    Random random(seed);
    std::string bytes = GetParam().valid;
    for (int64_t flips = 1 + random.Below(8); flips > 0; --flips) {
      const auto at = static_cast<size_t>(random.Below(static_cast<int64_t>(bytes.size())));
      bytes[at] = static_cast<char>(random.Below(256));
    }
    const absl::StatusOr<std::string> result = GetParam().decode_and_encode(bytes);
    EXPECT_TRUE(result.ok() || result.status().code() == kDataLoss) << "seed " << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, EveryBlob, ::testing::ValuesIn(AllKinds()), [](const auto& kind) {
  return kind.param.name;
});

TEST(AlignmentBlob, KeepsEveryNumber) {
  const auto decoded = DecodeAlignmentBlob(EncodeAlignmentBlob(SomeAlignments()));
  ASSERT_THAT(decoded, IsOk());
  ASSERT_EQ(decoded->size(), 2u);
  const MeshAlignment expected = SomeAlignments()[1];
  const MeshAlignment& actual = (*decoded)[1];
  EXPECT_EQ(actual.mesh, 7);
  EXPECT_EQ(actual.alignment.iterations, 17);
  EXPECT_TRUE(actual.alignment.converged);
  EXPECT_EQ(actual.alignment.lookups, int64_t{1} << 40);
  EXPECT_EQ(actual.alignment.rms_residual, 0.1 + 0.2);
  EXPECT_EQ(actual.alignment.mean_residual, std::nextafter(1.0, 2.0));
  EXPECT_EQ(actual.alignment.T_target_source.scale, 1.0 / 3);
  EXPECT_EQ(actual.alignment.T_target_source.rotation, expected.alignment.T_target_source.rotation);
  EXPECT_EQ(actual.alignment.T_target_source.translation,
            expected.alignment.T_target_source.translation);
}

TEST(AlignmentBlob, IsLaidOutAsTheHeaderSays) {
  const std::string bytes = EncodeAlignmentBlob(SomeAlignments());
  EXPECT_EQ(bytes.size(), 8 + 8 + 2 * (4 + 4 + 2 + 8 + 17 * 8u));
  ByteReader reader(std::string_view(bytes).substr(16 + 154 + 18 + 5 * 8 + 8));
  double second_of_first_row = 0;
  ASSERT_TRUE(reader.Get(second_of_first_row));
  EXPECT_EQ(second_of_first_row, 0.2);
}

TEST(TileBlob, KeepsBlocksInOrder) {
  const auto decoded = DecodeTileBlob(EncodeTileBlob(SomeTile()));
  ASSERT_THAT(decoded, IsOk());
  ASSERT_EQ(decoded->size(), 3u);
  EXPECT_EQ((*decoded)[0].sources, (std::vector<int32_t>{0, 1}));
  EXPECT_EQ((*decoded)[0].targets, (std::vector<int32_t>{2, 3, 4}));
  EXPECT_EQ((*decoded)[0].values[5], SomeValues(5));
  EXPECT_EQ((*decoded)[1].values[0], SomeValues(-0.0));
  EXPECT_TRUE((*decoded)[2].values.empty());
}

TEST(TileBlob, RefusesAnotherNumberOfMetrics) {
  ByteWriter writer;
  writer.PutBytes("COHTILE1");
  writer.PutArray<uint64_t>(std::vector<uint64_t>{1, 0, 0, 8});
  EXPECT_THAT(DecodeTileBlob(std::move(writer).Take()),
              StatusIs(kDataLoss, "tile blob of 40 bytes: has 8 metrics, expected 7"));
}

TEST(TileBlob, RefusesACountWhoseSizeOverflows) {
  ByteWriter writer;
  writer.PutBytes("COHTILE1");
  writer.PutArray<uint64_t>(std::vector<uint64_t>{1, uint64_t{1} << 62, uint64_t{1} << 62, 7});
  EXPECT_THAT(DecodeTileBlob(std::move(writer).Take()),
              StatusIs(kDataLoss, "announces 4611686018427387904 rows in the last 16 bytes"));
}

TEST(VariationBlob, KeepsEveryNumber) {
  const VariationPart expected = SomeVariation();
  const auto decoded = DecodeVariationBlob(EncodeVariationBlob(expected));
  ASSERT_THAT(decoded, IsOk());
  EXPECT_EQ(decoded->meshes, expected.meshes);
  EXPECT_EQ(decoded->distances, expected.distances);
  EXPECT_EQ(decoded->displacement.mesh_count, 2);
  EXPECT_EQ(decoded->displacement.sum, expected.displacement.sum);
}

TEST(VariationBlob, DoesWithoutASum) {
  VariationPart expected = SomeVariation();
  expected.displacement.sum.resize(3, 0);
  const auto decoded = DecodeVariationBlob(EncodeVariationBlob(expected));
  ASSERT_THAT(decoded, IsOk());
  EXPECT_EQ(decoded->distances, expected.distances);
  EXPECT_EQ(decoded->displacement.sum.cols(), 0);
}

TEST(VariationBlob, RefusesASumOfOtherVertices) {
  VariationPart part = SomeVariation();
  part.displacement.sum = Eigen::Matrix3Xf::Zero(3, 2);
  EXPECT_THAT(DecodeVariationBlob(EncodeVariationBlob(part)),
              StatusIs(kDataLoss, "has 2 displacements of 3 vertices"));
}

TEST(SummaryBlob, KeepsEveryNumber) {
  const auto decoded = DecodeSummaryBlob(EncodeSummaryBlob(SomeSummary()));
  ASSERT_THAT(decoded, IsOk());
  EXPECT_EQ(decoded->mesh_count, 5);
  EXPECT_EQ(decoded->values, SomeSummary().values);
}

TEST(DisplacementBlob, RefusesANegativeCount) {
  const DisplacementSum displacement{.mesh_count = -1, .sum = Eigen::Matrix3Xf::Zero(3, 1)};
  EXPECT_THAT(DecodeDisplacementBlob(EncodeDisplacementBlob(displacement)),
              StatusIs(kDataLoss, "mesh count is -1"));
}

}  // namespace
}  // namespace cohort
