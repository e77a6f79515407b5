#include "common/geometry/io/draco_codec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/base/random.h"
#include "common/geometry/mesh/bounds.h"
#include "common/geometry/mesh/mesh_health.h"
#include "tests/common/geometry/mesh/shapes.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::IsOk;
using testing::MakeMesh;
using testing::StatusIs;
using testing::Tetrahedron;
using testing::Together;
using testing::WavySheet;

TriangleMesh RoundTrip(const TriangleMesh& mesh, int position_bits) {
  const auto bytes = EncodeDraco(mesh, {.position_bits = position_bits});
  EXPECT_THAT(bytes, IsOk());
  auto decoded = DecodeDraco(*bytes);
  EXPECT_THAT(decoded, IsOk());
  return *std::move(decoded);
}

/// The documented bound; float32 itself rounds by half a unit in the last place, a few times.
double LargestError(const TriangleMesh& mesh, int position_bits) {
  const Bounds bounds = BoundsOf(mesh.vertices);
  const double step = (bounds.high - bounds.low).maxCoeff() / (std::exp2(position_bits) - 1);
  const double float_rounding = 4 * 0x1p-24 * mesh.vertices.cwiseAbs().maxCoeff();
  return step / 2 + float_rounding;
}

/// A triangle as three quantised corners, the smallest first, turned but not flipped.
using Corners = std::array<std::array<int64_t, 3>, 3>;

/// The triangles in an order of their own, corners on a grid so wide that the error vanishes.
std::vector<Corners> SortedTriangles(const TriangleMesh& mesh, double grid) {
  std::vector<Corners> triangles;
  for (Eigen::Index f = 0; f < mesh.FaceCount(); ++f) {
    Corners corners;
    for (size_t corner = 0; corner < 3; ++corner) {
      const Eigen::Vector3d p =
          mesh.vertices.col(mesh.faces(static_cast<Eigen::Index>(corner), f)) / grid;
      corners[corner] = {std::llround(p.x()), std::llround(p.y()), std::llround(p.z())};
    }
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
    triangles.push_back(corners);
  }
  std::sort(triangles.begin(), triangles.end());
  return triangles;
}

/// Every vertex has a decoded one within the bound, and the other way round. Brute force.
void ExpectSamePoints(const TriangleMesh& a, const TriangleMesh& b, double bound) {
  for (Eigen::Index v = 0; v < a.VertexCount(); ++v) {
    const double nearest =
        (b.vertices.colwise() - a.vertices.col(v)).cwiseAbs().colwise().maxCoeff().minCoeff();
    ASSERT_LE(nearest, bound) << v;
  }
}

/// Vertices on whole numbers, so that faces can be compared exactly whatever the rounding.
TriangleMesh OnWholeNumbers(TriangleMesh mesh) {
  mesh.vertices = mesh.vertices.array().round().matrix();
  return mesh;
}

TEST(DracoOptions, TakeEightToThirtyBits) {
  EXPECT_THAT(DracoOptions().Validate(), IsOk());
  EXPECT_THAT(DracoOptions{.position_bits = 7}.Validate(),
              StatusIs(absl::StatusCode::kInvalidArgument, "position_bits is 7"));
  EXPECT_THAT(DracoOptions{.position_bits = 31}.Validate(),
              StatusIs(absl::StatusCode::kInvalidArgument, "position_bits is 31"));
}

class DracoBits : public ::testing::TestWithParam<int> {};

TEST_P(DracoBits, SurfaceStaysWithinTheBound) {
  const TriangleMesh mesh = WavySheet(30);
  const TriangleMesh decoded = RoundTrip(mesh, GetParam());
  ASSERT_EQ(decoded.VertexCount(), mesh.VertexCount());
  ASSERT_EQ(decoded.FaceCount(), mesh.FaceCount());
  ExpectSamePoints(mesh, decoded, LargestError(mesh, GetParam()));
  ExpectSamePoints(decoded, mesh, LargestError(mesh, GetParam()));
}

TEST_P(DracoBits, CloudStaysWithinTheBound) {
  TriangleMesh cloud = WavySheet(30);
  cloud.faces.resize(3, 0);
  const TriangleMesh decoded = RoundTrip(cloud, GetParam());
  EXPECT_TRUE(decoded.IsPointCloud());
  ASSERT_EQ(decoded.VertexCount(), cloud.VertexCount());
  ExpectSamePoints(cloud, decoded, LargestError(cloud, GetParam()));
  ExpectSamePoints(decoded, cloud, LargestError(cloud, GetParam()));
}

INSTANTIATE_TEST_SUITE_P(Bits, DracoBits, ::testing::Values(8, 11, 14, 18, 22, 24, 28, 30));

TEST(Draco, KeepsTheFacesUpToTheirOrder) {
  const TriangleMesh mesh = OnWholeNumbers(WavySheet(40));
  EXPECT_EQ(SortedTriangles(RoundTrip(mesh, 18), 1), SortedTriangles(mesh, 1));
}

TEST(Draco, KeepsAClosedSurface) {
  const TriangleMesh mesh = Tetrahedron();
  EXPECT_EQ(SortedTriangles(RoundTrip(mesh, 18), 1), SortedTriangles(mesh, 1));
}

TEST(Draco, KeepsSeveralComponents) {
  const TriangleMesh mesh = OnWholeNumbers(
      Together(WavySheet(12), Together(Tetrahedron(), WavySheet(5), {0, 300, 0}), {500, 0, 0}));
  const TriangleMesh decoded = RoundTrip(mesh, 18);
  EXPECT_EQ(decoded.VertexCount(), mesh.VertexCount());
  EXPECT_EQ(SortedTriangles(decoded, 1), SortedTriangles(mesh, 1));
}

TEST(Draco, KeepsAnEdgeOfThreeFaces) {
  const TriangleMesh mesh = MakeMesh({{0, 0, 0}, {50, 0, 0}, {0, 50, 0}, {0, -50, 0}, {0, 0, 50}},
                                     {{0, 1, 2}, {1, 0, 3}, {0, 1, 4}});
  EXPECT_EQ(SortedTriangles(RoundTrip(mesh, 18), 1), SortedTriangles(mesh, 1));
}

TEST(Draco, KeepsFacesThatMeetInOneVertex) {
  const TriangleMesh mesh = MakeMesh({{0, 0, 0}, {50, 0, 0}, {0, 50, 0}, {-50, 0, 0}, {0, -50, 0}},
                                     {{0, 1, 2}, {0, 3, 4}});
  EXPECT_EQ(SortedTriangles(RoundTrip(mesh, 18), 1), SortedTriangles(mesh, 1));
}

TEST(Draco, KeepsRandomFacesHoweverTheyTouch) {
  Random random(3);
  for (int round = 0; round < 200; ++round) {
    TriangleMesh mesh;
    const int64_t vertices = 3 + random.Below(30);
    mesh.vertices.resize(3, vertices);
    for (double& coordinate : mesh.vertices.reshaped()) {
      coordinate = static_cast<double>(random.Below(300));
    }
    mesh.faces.resize(3, 1 + random.Below(60));
    for (int32_t& vertex : mesh.faces.reshaped()) {
      vertex = static_cast<int32_t>(random.Below(vertices));
    }
    MeshHealth health;
    if (!CheckAndClean(mesh, health).ok()) {
      continue;
    }
    ASSERT_EQ(SortedTriangles(RoundTrip(mesh, 18), 1), SortedTriangles(mesh, 1)) << round;
  }
}

TEST(Draco, KeepsVerticesAtTheSamePosition) {
  const TriangleMesh mesh = Together(WavySheet(6), WavySheet(6), {0, 0, 0});
  EXPECT_EQ(RoundTrip(mesh, 18).VertexCount(), mesh.VertexCount());
}

TEST(Draco, KeepsRepeatedPointsOfACloud) {
  TriangleMesh cloud = Together(WavySheet(6), WavySheet(6), {0, 0, 0});
  cloud.faces.resize(3, 0);
  EXPECT_EQ(RoundTrip(cloud, 18).VertexCount(), 72);
}

TEST(Draco, KeepsCountsAndFacesTheSecondTime) {
  const TriangleMesh once = RoundTrip(OnWholeNumbers(WavySheet(25)), 18);
  const TriangleMesh twice = RoundTrip(once, 18);
  EXPECT_EQ(twice.VertexCount(), once.VertexCount());
  EXPECT_EQ(twice.FaceCount(), once.FaceCount());
  EXPECT_EQ(SortedTriangles(twice, 1), SortedTriangles(once, 1));
}

TEST(Draco, GivesTheSameBytesTwice) {
  TriangleMesh mesh = WavySheet(40);
  EXPECT_EQ(*EncodeDraco(mesh), *EncodeDraco(mesh));
  mesh.faces.resize(3, 0);
  EXPECT_EQ(*EncodeDraco(mesh), *EncodeDraco(mesh));
}

TEST(Draco, IsMuchSmallerThanFloats) {
  const TriangleMesh mesh = WavySheet(100);
  const size_t raw = static_cast<size_t>(mesh.VertexCount() + mesh.FaceCount()) * 12;
  EXPECT_LT(EncodeDraco(mesh)->size(), raw / 6);
}

TEST(Draco, RefusesToEncodeNothing) {
  EXPECT_THAT(EncodeDraco({}), StatusIs(absl::StatusCode::kInvalidArgument, "without vertices"));
  EXPECT_THAT(EncodeDraco(Tetrahedron(), {.position_bits = 99}),
              StatusIs(absl::StatusCode::kInvalidArgument, "position_bits is 99"));
}

TEST(DecodeDraco, RefusesWhatIsNotDraco) {
  for (const std::string bytes : {"", "DRACO", "DRAC", "ply\nformat ascii 1.0\n"}) {
    EXPECT_THAT(DecodeDraco(bytes), StatusIs(absl::StatusCode::kDataLoss, "Draco: ")) << bytes;
  }
}

TEST(DecodeDraco, RefusesEveryTruncation) {
  const std::string bytes = *EncodeDraco(WavySheet(8));
  for (size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_THAT(DecodeDraco(bytes.substr(0, size)), StatusIs(absl::StatusCode::kDataLoss, "Draco"))
        << size;
  }
}

TEST(DecodeDraco, RefusesMoreVerticesThanAllowed) {
  TriangleMesh mesh = WavySheet(10);
  EXPECT_THAT(DecodeDraco(*EncodeDraco(mesh), 100), IsOk());
  EXPECT_THAT(DecodeDraco(*EncodeDraco(mesh), 99),
              StatusIs(absl::StatusCode::kDataLoss, "100 vertices and 162 faces announced"));
  mesh.faces.resize(3, 0);
  EXPECT_THAT(DecodeDraco(*EncodeDraco(mesh), 99),
              StatusIs(absl::StatusCode::kDataLoss, "100 vertices"));
}

TEST(DecodeDraco, RefusesCountsThatNobodyCanHold) {
  std::string bytes = *EncodeDraco(WavySheet(10));
  bytes.replace(12, 1, "\xFF\xFF\xFF\xFF\x0F");
  EXPECT_THAT(DecodeDraco(bytes), StatusIs(absl::StatusCode::kDataLoss, "4294967295 vertices"));
}

// Found by draco_fuzz: Draco walked on for 3,000 million points of 36.
TEST(DecodeDraco, RefusesACloudWhoseTreeAnnouncesMorePoints) {
  TriangleMesh cloud = WavySheet(6);
  cloud.faces.resize(3, 0);
  std::string bytes = *EncodeDraco(cloud);
  constexpr size_t kTreeCount = 27;
  ASSERT_EQ(bytes.substr(kTreeCount, 4), std::string("\x24\0\0\0", 4));
  bytes.replace(kTreeCount, 4, "\xFF\xFF\xFF\xB4");
  EXPECT_THAT(DecodeDraco(bytes), StatusIs(absl::StatusCode::kDataLoss, "contradict each other"));
}

/// Damage of good bytes may decode or not, but what decodes keeps the promises of a mesh.
void DamageAndDecode(const TriangleMesh& mesh) {
  const std::string good = *EncodeDraco(mesh);
  Random random(5);
  for (int round = 0; round < 2000; ++round) {
    std::string bytes = good;
    const auto at = static_cast<size_t>(random.Below(static_cast<int64_t>(bytes.size())));
    bytes[at] = static_cast<char>(random.Below(256));
    const auto decoded = DecodeDraco(bytes, 10'000);
    if (decoded.ok()) {
      ASSERT_TRUE(decoded->vertices.allFinite()) << round;
      ASSERT_TRUE(decoded->IsPointCloud() || (decoded->faces.minCoeff() >= 0 &&
                                              decoded->faces.maxCoeff() < decoded->VertexCount()))
          << round;
    } else {
      ASSERT_EQ(decoded.status().code(), absl::StatusCode::kDataLoss) << decoded.status();
    }
  }
}

TEST(DecodeDraco, SurvivesADamagedSurface) {
  DamageAndDecode(WavySheet(8));
}

TEST(DecodeDraco, SurvivesADamagedCloud) {
  TriangleMesh cloud = WavySheet(8);
  cloud.faces.resize(3, 0);
  DamageAndDecode(cloud);
}

}  // namespace
}  // namespace cohort
