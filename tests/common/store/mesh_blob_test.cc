#include "common/store/mesh_blob.h"

#include <cstring>
#include <limits>
#include <string>

#include <gtest/gtest.h>

#include "tests/testing/bits.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::StatusIs;

TriangleMesh Tetrahedron() {
  TriangleMesh mesh;
  mesh.vertices.resize(3, 4);
  mesh.vertices << 0, 1.0 / 3, 0, -0.0,  //
      0, 0, 1e-300, 0,                   //
      0, 0, 0, 123456.789;
  mesh.faces.resize(3, 4);
  mesh.faces << 0, 0, 0, 1,  //
      2, 1, 3, 2,            //
      1, 3, 2, 3;
  return mesh;
}

TEST(RawMeshBlob, KeepsEveryBit) {
  const TriangleMesh mesh = Tetrahedron();

  const absl::StatusOr<TriangleMesh> decoded = DecodeMeshBlob(EncodeRawMeshBlob(mesh));

  ASSERT_THAT(decoded, testing::IsOk());
  ASSERT_EQ(decoded->VertexCount(), 4);
  EXPECT_EQ(testing::BitsOf(decoded->vertices), testing::BitsOf(mesh.vertices));
  EXPECT_EQ(decoded->faces, mesh.faces);
}

TEST(RawMeshBlob, HasTheDocumentedLayout) {
  const std::string bytes = EncodeRawMeshBlob(Tetrahedron());

  EXPECT_EQ(bytes.size(), 8u + 1 + 16 + 4 * 24 + 4 * 12);
  EXPECT_EQ(bytes.substr(0, 10), std::string("COHMESH1\0\4", 10));
}

TEST(RawMeshBlob, HoldsAPointCloud) {
  TriangleMesh cloud = Tetrahedron();
  cloud.faces.resize(3, 0);

  const absl::StatusOr<TriangleMesh> decoded = DecodeMeshBlob(EncodeRawMeshBlob(cloud));

  ASSERT_THAT(decoded, testing::IsOk());
  EXPECT_TRUE(decoded->IsPointCloud());
  EXPECT_EQ(decoded->vertices, cloud.vertices);
}

TEST(RawMeshBlob, IsRefusedWhenCutAtAnyByte) {
  const std::string bytes = EncodeRawMeshBlob(Tetrahedron());

  for (size_t size = 0; size < bytes.size(); ++size) {
    ASSERT_THAT(DecodeMeshBlob(bytes.substr(0, size)),
                StatusIs(absl::StatusCode::kDataLoss, "mesh blob"))
        << "cut to " << size;
  }
}

TEST(RawMeshBlob, IsRefusedWhenItIsTooLong) {
  EXPECT_THAT(DecodeMeshBlob(EncodeRawMeshBlob(Tetrahedron()) + "x"),
              StatusIs(absl::StatusCode::kDataLoss, "4 vertices and 4 faces do not fit"));
}

TEST(RawMeshBlob, IsRefusedWhenItsCountsOverflow) {
  std::string bytes = EncodeRawMeshBlob(Tetrahedron());
  const uint64_t huge = std::numeric_limits<uint64_t>::max() / 24 + 5;
  std::memcpy(bytes.data() + 9, &huge, sizeof(huge));

  EXPECT_THAT(DecodeMeshBlob(bytes), StatusIs(absl::StatusCode::kDataLoss, "do not fit"));
}

TEST(RawMeshBlob, IsRefusedWhenAFaceUsesAVertexThatIsNotThere) {
  TriangleMesh beyond = Tetrahedron();
  beyond.faces(1, 2) = 4;
  TriangleMesh negative = Tetrahedron();
  negative.faces(0, 3) = -1;

  EXPECT_THAT(DecodeMeshBlob(EncodeRawMeshBlob(beyond)),
              StatusIs(absl::StatusCode::kDataLoss, "face 2 uses vertex 4 of 4"));
  EXPECT_THAT(DecodeMeshBlob(EncodeRawMeshBlob(negative)),
              StatusIs(absl::StatusCode::kDataLoss, "face 3 uses vertex -1 of 4"));
}

TEST(MeshBlob, IsRefusedWhenItsEncodingIsUnknown) {
  std::string bytes = EncodeRawMeshBlob(Tetrahedron());
  bytes[8] = 2;

  EXPECT_THAT(DecodeMeshBlob(bytes), StatusIs(absl::StatusCode::kDataLoss, "unknown encoding 2"));
}

// The tolerance is what DracoOptions promises: half a step of the longest side.
TEST(DracoMeshBlob, KeepsTheShape) {
  TriangleMesh mesh = Tetrahedron();
  mesh.vertices(2, 3) = 1;
  const DracoOptions options{.position_bits = 18};

  const absl::StatusOr<std::string> bytes = EncodeDracoMeshBlob(mesh, options);
  ASSERT_THAT(bytes, testing::IsOk());
  const absl::StatusOr<TriangleMesh> decoded = DecodeMeshBlob(*bytes);

  ASSERT_THAT(decoded, testing::IsOk());
  EXPECT_EQ(decoded->VertexCount(), 4);
  EXPECT_EQ(decoded->FaceCount(), 4);
  const double half_step = 1.0 / (1 << 18) / 2;
  for (Eigen::Index i = 0; i < 4; ++i) {
    const Eigen::Matrix3Xd offsets = decoded->vertices.colwise() - mesh.vertices.col(i);
    EXPECT_LE(offsets.cwiseAbs().colwise().maxCoeff().minCoeff(), half_step * 1.01)
        << "vertex " << i;
  }
}

TEST(DracoMeshBlob, IsRefusedWhenCutShort) {
  TriangleMesh mesh = Tetrahedron();
  const absl::StatusOr<std::string> bytes = EncodeDracoMeshBlob(mesh, {});
  ASSERT_THAT(bytes, testing::IsOk());

  EXPECT_THAT(DecodeMeshBlob(bytes->substr(0, bytes->size() / 2)),
              StatusIs(absl::StatusCode::kDataLoss, ""));
}

}  // namespace
}  // namespace cohort
