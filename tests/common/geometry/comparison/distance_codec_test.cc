#include "common/geometry/comparison/distance_codec.h"

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/random.h"
#include "common/geometry/comparison/measure_distances.h"
#include "common/geometry/comparison/zstd_frame.h"
#include "tests/common/geometry/comparison/fields.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::Absolute;
using testing::FaceLikeField;
using testing::IsOk;
using testing::SignedFields;
using testing::StatusIs;

std::vector<uint32_t> Bits(const std::vector<float>& values) {
  std::vector<uint32_t> bits;
  bits.reserve(values.size());
  for (const float value : values) {
    bits.push_back(std::bit_cast<uint32_t>(value));
  }
  return bits;
}

DistanceSketch SketchOf(const std::vector<float>& field, DistanceSign sign) {
  DistanceScratch scratch;
  return MeasureDistances(field, sign, scratch).sketch;
}

/// What a decoder may do with damaged bytes: refuse them with kDataLoss, or (where a bit of the
/// container means nothing) give what was encoded.
template <typename Decode, typename Same>
void ExpectDamageIsSeen(const std::string& bytes, Decode decode, Same same) {
  for (size_t size = 0; size < bytes.size(); ++size) {
    const auto cut = decode(bytes.substr(0, size));
    ASSERT_FALSE(cut.ok()) << size << " of " << bytes.size() << " bytes";
    ASSERT_EQ(cut.status().code(), absl::StatusCode::kDataLoss);
  }
  for (const char more : {'\0', 'x'}) {
    ASSERT_THAT(decode(bytes + more), StatusIs(absl::StatusCode::kDataLoss, ""));
  }
  for (size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    std::string flipped = bytes;
    flipped[bit / 8] = static_cast<char>(static_cast<uint8_t>(flipped[bit / 8]) ^ (1u << bit % 8));
    const auto result = decode(flipped);
    if (result.ok()) {
      ASSERT_TRUE(same(*result)) << "bit " << bit;
    } else {
      ASSERT_EQ(result.status().code(), absl::StatusCode::kDataLoss) << result.status();
    }
  }
}

TEST(EncodeVectors, IsLossless) {
  for (const int n : {1, 2, 17, 3000}) {
    for (const auto& [name, field] : SignedFields(n)) {
      const auto decoded = DecodeVectors(EncodeVectors(field), n);
      ASSERT_THAT(decoded, IsOk()) << name;
      EXPECT_EQ(Bits(*decoded), Bits(field)) << name;
    }
  }
}

TEST(EncodeVectors, KeepsEveryBitPattern) {
  const std::vector<float> odd = {-0.0F, std::numeric_limits<float>::quiet_NaN(),
                                  std::numeric_limits<float>::infinity(), 1e-45F};
  const auto decoded = DecodeVectors(EncodeVectors(odd), 4);
  ASSERT_THAT(decoded, IsOk());
  EXPECT_EQ(Bits(*decoded), Bits(odd));
}

TEST(EncodeVectors, TakesAboutThreeBytesAValueForFaces) {
  EXPECT_LT(EncodeVectors(Absolute(FaceLikeField(20000, 1))).size(), 20000 * 3.3);
}

TEST(DecodeVectors, SeesDamage) {
  const std::vector<float> field = FaceLikeField(60, 2);
  ExpectDamageIsSeen(
      EncodeVectors(field), [](const std::string& bytes) { return DecodeVectors(bytes, 60); },
      [&field](const std::vector<float>& decoded) { return decoded == field; });
}

TEST(DecodeVectors, RefusesAnotherNumberOfValues) {
  const std::string bytes = EncodeVectors(FaceLikeField(60, 2));
  EXPECT_THAT(DecodeVectors(bytes, 59), StatusIs(absl::StatusCode::kDataLoss, "field of 59"));
  EXPECT_THAT(DecodeVectors(bytes, 0), StatusIs(absl::StatusCode::kDataLoss, "field of 0"));
  EXPECT_THAT(DecodeVectors(bytes, int64_t{1} << 62),
              StatusIs(absl::StatusCode::kDataLoss, "240 bytes unpacked"));
}

TEST(DecodeVectors, RefusesAFrameThatClaimsTerabytesBeforeItAllocates) {
  // A frame header of zstd: magic, descriptor with an 8-byte content size and one segment.
  std::string bytes("CDV1\x28\xB5\x2F\xFD\xE0", 9);
  bytes += std::string("\x00\x00\x00\x00\x00\x01\x00\x00", 8);  // 2^40
  bytes += std::string("\x01\x00\x00", 3);                      // An empty last block.
  EXPECT_THAT(DecodeVectors(bytes, 60), StatusIs(absl::StatusCode::kDataLoss, "1099511627776"));
  EXPECT_THAT(DecodeVectors(bytes, 60).status(), StatusIs(absl::StatusCode::kDataLoss, "unpacked"));
}

double BoundOf(float value, double step) {
  return step / 2 + std::abs(double{value}) * 0x1p-24;
}

TEST(EncodeCompact, StaysWithinItsBound) {
  for (const int n : {1, 2, 17, 3000}) {
    for (const auto& [name, field] : SignedFields(n)) {
      const auto bytes = EncodeCompact(field, {});
      ASSERT_THAT(bytes, IsOk()) << name;
      const auto decoded = DecodeCompact(*bytes, n);
      ASSERT_THAT(decoded, IsOk()) << name;
      for (size_t i = 0; i < field.size(); ++i) {
        ASSERT_NEAR(decoded->distances.at(i), field.at(i), BoundOf(field.at(i), decoded->step))
            << name << " " << i;
        ASSERT_GE(decoded->distances.at(i) * field.at(i), 0) << name << " changes sign";
      }
    }
  }
}

TEST(EncodeCompact, IsHalfAMicrometreOffForFaces) {
  const std::vector<float> field = FaceLikeField(5000, 3);
  const auto decoded = DecodeCompact(EncodeCompact(field, {}).value(), 5000);
  ASSERT_THAT(decoded, IsOk());
  EXPECT_EQ(decoded->step, 0.001);
  for (size_t i = 0; i < field.size(); ++i) {
    EXPECT_NEAR(decoded->distances.at(i), field.at(i), 0.000501);
  }
}

TEST(EncodeCompact, TakesAtMostOnePointSixBytesAValueForFaces) {
  EXPECT_LE(EncodeCompact(Absolute(FaceLikeField(20000, 1)), {})->size(), 20000 * 1.6);
}

TEST(EncodeCompact, KeepsTheStepForWholeMetresOfMillimetres) {
  const std::vector<float> far = {65.535F, 65.536F, -300, 4000, 0.001F};
  const auto decoded = DecodeCompact(EncodeCompact(far, {}).value(), 5);
  ASSERT_THAT(decoded, IsOk());
  EXPECT_EQ(decoded->step, 0.001);
  EXPECT_NEAR(decoded->distances.at(1), 65.536, BoundOf(65.536F, 0.001));
  EXPECT_NEAR(decoded->distances.at(3), 4000, BoundOf(4000, 0.001));
}

TEST(EncodeCompact, WidensTheStepAndSaysSoInsteadOfSaturating) {
  const std::vector<float> far = {1, -10000, 123456.0F};
  const auto decoded = DecodeCompact(EncodeCompact(far, {}).value(), 3);
  ASSERT_THAT(decoded, IsOk());
  EXPECT_EQ(decoded->step, 0.032);
  EXPECT_NEAR(decoded->distances.at(1), -10000, BoundOf(10000, 0.032));
  EXPECT_NEAR(decoded->distances.at(2), 123456, BoundOf(123456, 0.032));
}

TEST(EncodeCompact, IsAsFineInMetresWithTheStepOfMetres) {
  std::vector<float> metres;
  for (const float value : FaceLikeField(1000, 4)) {
    metres.push_back(value / 1000);
  }
  const CompactOptions options{.step = CompactStep(0.3)};
  const auto decoded = DecodeCompact(EncodeCompact(metres, options).value(), 1000);
  ASSERT_THAT(decoded, IsOk());
  for (size_t i = 0; i < metres.size(); ++i) {
    EXPECT_NEAR(decoded->distances.at(i), metres.at(i), 0.501e-6);
  }
}

TEST(CompactStep, IsTheMicrometreOfTheUnit) {
  EXPECT_EQ(CompactStep(100), 0.001);
  EXPECT_EQ(CompactStep(450), 0.001);
  EXPECT_EQ(CompactStep(0.3), 1e-6);
  EXPECT_EQ(CompactStep(12), 1e-4);
  EXPECT_EQ(CompactStep(1e-30), 1e-9);
}

TEST(RoundCompact, IsWhatDecodeCompactGives) {
  for (const auto& [name, field] : SignedFields(500)) {
    const auto rounded = RoundCompact(field, {});
    const auto decoded = DecodeCompact(EncodeCompact(field, {}).value(), 500);
    ASSERT_THAT(rounded, IsOk()) << name;
    ASSERT_THAT(decoded, IsOk()) << name;
    EXPECT_EQ(Bits(rounded->distances), Bits(decoded->distances)) << name;
    EXPECT_EQ(rounded->step, decoded->step) << name;
  }
}

TEST(RoundCompact, ChangesNothingTheSecondTime) {
  for (const auto& [name, field] : SignedFields(500)) {
    const auto once = RoundCompact(field, {});
    ASSERT_THAT(once, IsOk()) << name;
    const auto twice = RoundCompact(once->distances, {});
    ASSERT_THAT(twice, IsOk()) << name;
    EXPECT_EQ(Bits(twice->distances), Bits(once->distances)) << name;
  }
}

TEST(EncodeCompact, RefusesWhatItCannotKeep) {
  EXPECT_THAT(EncodeCompact(std::vector<float>{1, std::nanf("")}, {}),
              StatusIs(absl::StatusCode::kInvalidArgument, "value 1"));
  EXPECT_THAT(EncodeCompact(std::vector<float>{3e38F}, {}),
              StatusIs(absl::StatusCode::kInvalidArgument, "value 0"));
  EXPECT_THAT(EncodeCompact({}, {}), StatusIs(absl::StatusCode::kInvalidArgument, "no value"));
  EXPECT_THAT(EncodeCompact(std::vector<float>{1}, {.step = 0}),
              StatusIs(absl::StatusCode::kInvalidArgument, "step 0"));
  EXPECT_THAT(EncodeCompact(std::vector<float>{1}, {.step = std::nan("")}),
              StatusIs(absl::StatusCode::kInvalidArgument, "step nan"));
}

TEST(DecodeCompact, SeesDamage) {
  for (const std::vector<float>& field : {FaceLikeField(60, 5), std::vector<float>(60, 0.5F)}) {
    const CompactField kept = RoundCompact(field, {}).value();
    ExpectDamageIsSeen(
        EncodeCompact(field, {}).value(),
        [](const std::string& bytes) { return DecodeCompact(bytes, 60); },
        [&kept](const CompactField& decoded) {
          return decoded.distances == kept.distances && decoded.step == kept.step;
        });
  }
}

/// A compact field with any head and planes, in a sound frame.
std::string CompactBytes(double step, char coded, const std::string& planes) {
  std::string content(sizeof(step), '\0');
  std::memcpy(content.data(), &step, sizeof(step));
  content += coded + planes;
  const std::string_view part = content;
  return "CDC1" + CompressFrame({&part, 1});
}

TEST(DecodeCompact, RefusesContentThatNoFieldHas) {
  EXPECT_THAT(DecodeCompact(CompactBytes(0.001, 0, "\x02\x04"), 2), IsOk());
  EXPECT_THAT(DecodeCompact(CompactBytes(-1, 0, "\x02\x04"), 2),
              StatusIs(absl::StatusCode::kDataLoss, "step -1"));
  EXPECT_THAT(DecodeCompact(CompactBytes(std::nan(""), 0, "\x02\x04"), 2),
              StatusIs(absl::StatusCode::kDataLoss, "step nan"));
  EXPECT_THAT(DecodeCompact(CompactBytes(0.001, 2, "\x02\x04"), 2),
              StatusIs(absl::StatusCode::kDataLoss, "coding 2"));
  EXPECT_THAT(DecodeCompact(CompactBytes(0.001, 0, "\x02\x04\x06"), 2),
              StatusIs(absl::StatusCode::kDataLoss, "12 bytes unpacked"));
  EXPECT_THAT(DecodeCompact(CompactBytes(0.001, 1, std::string(9, '\xFE')), 3),
              StatusIs(absl::StatusCode::kDataLoss, "value 0 of 3"));
  EXPECT_THAT(DecodeCompact(CompactBytes(0.001, 0, ""), 2),
              StatusIs(absl::StatusCode::kDataLoss, "9 bytes unpacked"));
}

TEST(Decoders, RefuseRandomBytes) {
  Random random(6);
  for (int i = 0; i < 3000; ++i) {
    std::string bytes;
    for (int64_t k = random.Below(200); k > 0; --k) {
      bytes += static_cast<char>(random.Below(256));
    }
    EXPECT_FALSE(DecodeVectors("CDV1" + bytes, 60).ok());
    EXPECT_FALSE(DecodeCompact("CDC1" + bytes, 60).ok());
    EXPECT_FALSE(DecodeSketch("CDS1" + bytes).ok());
    EXPECT_FALSE(DecodeSketch(bytes).ok());
  }
}

TEST(EncodeSketch, IsLossless) {
  for (const int n : {1, 17, 3000}) {
    for (const auto& [name, field] : SignedFields(n)) {
      const DistanceSketch with_sign = SketchOf(field, DistanceSign::kSigned);
      const DistanceSketch absolute = SketchOf(Absolute(field), DistanceSign::kAbsolute);
      for (const DistanceSketch& sketch : {with_sign, absolute}) {
        const auto decoded = DecodeSketch(EncodeSketch(sketch));
        ASSERT_THAT(decoded, IsOk()) << name;
        EXPECT_TRUE(*decoded == sketch) << name;
        EXPECT_EQ(EncodeSketch(*decoded), EncodeSketch(sketch)) << name;
      }
    }
  }
}

TEST(EncodeSketch, TakesLessThanAKilobyteForFaces) {
  EXPECT_LT(
      EncodeSketch(SketchOf(Absolute(FaceLikeField(60000, 7)), DistanceSign::kAbsolute)).size(),
      1000u);
}

/// A sketch has no checksum (blobs are named by their hash): damage that leaves a possible sketch
/// is not seen, but what comes out is always one that its questions can be asked of.
TEST(DecodeSketch, GivesOnlySketchesThatHoldTogether) {
  const std::string bytes = EncodeSketch(SketchOf(FaceLikeField(300, 8), DistanceSign::kSigned));
  for (size_t size = 0; size < bytes.size(); ++size) {
    ASSERT_THAT(DecodeSketch(bytes.substr(0, size)), StatusIs(absl::StatusCode::kDataLoss, ""));
  }
  EXPECT_THAT(DecodeSketch(bytes + '\0'),
              StatusIs(absl::StatusCode::kDataLoss, "1 bytes too many"));
  int seen = 0;
  for (size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    std::string flipped = bytes;
    flipped[bit / 8] = static_cast<char>(static_cast<uint8_t>(flipped[bit / 8]) ^ (1u << bit % 8));
    const auto decoded = DecodeSketch(flipped);
    seen += decoded.ok() ? 0 : 1;
    if (decoded.ok()) {
      int64_t count = 0;
      for (const uint32_t bin : decoded->bins) {
        count += bin;
      }
      ASSERT_EQ(count, decoded->totals.count);
      ASSERT_LE(decoded->totals.min, decoded->totals.max);
    }
  }
  // All but the low bits of the nine totals.
  EXPECT_GT(seen, static_cast<int>(8 * bytes.size()) - 9 * 52);
}

TEST(DecodeSketch, NamesTheContradiction) {
  const auto refuse = [](auto change) {
    DistanceSketch sketch = SketchOf(Absolute(FaceLikeField(300, 9)), DistanceSign::kAbsolute);
    change(sketch);
    return DecodeSketch(EncodeSketch(sketch)).status();
  };
  constexpr absl::StatusCode kDataLoss = absl::StatusCode::kDataLoss;
  EXPECT_THAT(refuse([](DistanceSketch& s) { ++s.totals.count; }),
              StatusIs(kDataLoss, "bins hold"));
  EXPECT_THAT(refuse([](DistanceSketch& s) { s.totals.count = 0; }),
              StatusIs(kDataLoss, "0 values"));
  EXPECT_THAT(refuse([](DistanceSketch& s) { s.totals.min = 1e9; }),
              StatusIs(kDataLoss, "extremes"));
  EXPECT_THAT(refuse([](DistanceSketch& s) { s.totals.sum *= 100; }), StatusIs(kDataLoss, "sums"));
  EXPECT_THAT(refuse([](DistanceSketch& s) { s.totals.sum_squares = std::nan(""); }),
              StatusIs(kDataLoss, "sums"));
  EXPECT_THAT(refuse([](DistanceSketch& s) { s.totals.log_mean = -1000; }),
              StatusIs(kDataLoss, "logarithm"));
  EXPECT_THAT(refuse([](DistanceSketch& s) { s.totals.sum_absolute += 1e-6; }),
              StatusIs(kDataLoss, "with signs"));
  EXPECT_THAT(refuse([](DistanceSketch& s) { s.bin_width *= 2; }),
              StatusIs(kDataLoss, "bin width"));
  EXPECT_THAT(refuse([](DistanceSketch& s) { s.bins.at(511) = 1; }),
              StatusIs(kDataLoss, "bin 511"));
}

}  // namespace
}  // namespace cohort
