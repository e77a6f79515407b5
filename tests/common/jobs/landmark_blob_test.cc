#include "common/jobs/landmark_blob.h"

#include <limits>

#include <gmock/gmock.h>

#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::testing::ElementsAre;
using testing::IsOk;
using testing::StatusIs;

LandmarkTable SomeTable() {
  LandmarkTable table;
  table["b.ply"].names = {"nasion", "chin", "\xC3\xA9"};
  table["b.ply"].points = Eigen::Matrix3Xd::Random(3, 3) * 100;
  table["a.ply"].names = {"chin"};
  table["a.ply"].points = Eigen::Vector3d(0.1, -0.0, 1e-310);
  table["c.ply"].points.resize(3, 0);
  return table;
}

TEST(LandmarkBlob, ReadsBackWhatWasWritten) {
  const LandmarkTable table = SomeTable();
  const auto back = DecodeLandmarkBlob(EncodeLandmarkBlob(table));
  ASSERT_THAT(back, IsOk());
  ASSERT_EQ(back->size(), 3u);
  EXPECT_THAT(back->at("b.ply").names, ElementsAre("nasion", "chin", "\xC3\xA9"));
  EXPECT_EQ(back->at("b.ply").points, table.at("b.ply").points);
  EXPECT_EQ(back->at("a.ply").points, table.at("a.ply").points);
  EXPECT_EQ(back->at("c.ply").Count(), 0);
}

TEST(LandmarkBlob, TakesTwentyEightBytesALandmark) {
  LandmarkTable table;
  for (int mesh = 0; mesh < 100; ++mesh) {
    LandmarkSet& landmarks = table["mesh" + std::to_string(mesh)];
    for (int k = 0; k < 20; ++k) {
      landmarks.names.push_back("landmark with a long name " + std::to_string(k));
    }
    landmarks.points = Eigen::Matrix3Xd::Random(3, 20);
  }
  EXPECT_LT(EncodeLandmarkBlob(table).size(), 100u * (20 * 28 + 30) + 1000);
}

TEST(LandmarkBlob, IsRefusedWhereverItIsCutShortOrTooLong) {
  const std::string bytes = EncodeLandmarkBlob(SomeTable());
  for (size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_THAT(DecodeLandmarkBlob(bytes.substr(0, size)),
                StatusIs(absl::StatusCode::kDataLoss, ""))
        << size;
  }
  EXPECT_THAT(DecodeLandmarkBlob(bytes + "x"),
              StatusIs(absl::StatusCode::kDataLoss, "1 bytes too many"));
}

TEST(LandmarkBlob, SurvivesAnyDamagedByte) {
  const std::string bytes = EncodeLandmarkBlob(SomeTable());
  for (size_t at = 0; at < bytes.size(); ++at) {
    for (const int flip : {1, 0x80, 0xFF}) {
      std::string damaged = bytes;
      damaged[at] = static_cast<char>(damaged[at] ^ flip);
      const auto decoded = DecodeLandmarkBlob(damaged);
      if (decoded.ok()) {
        for (const auto& [mesh, landmarks] : *decoded) {
          EXPECT_EQ(static_cast<int64_t>(landmarks.names.size()), landmarks.Count());
          EXPECT_TRUE(landmarks.points.allFinite());
        }
      } else {
        EXPECT_EQ(decoded.status().code(), absl::StatusCode::kDataLoss);
      }
    }
  }
}

TEST(LandmarkBlob, RefusesPointsThatAreNotFinite) {
  LandmarkTable table = SomeTable();
  table["a.ply"].points(1, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(DecodeLandmarkBlob(EncodeLandmarkBlob(table)),
              StatusIs(absl::StatusCode::kDataLoss, "not finite"));
}

}  // namespace
}  // namespace cohort
