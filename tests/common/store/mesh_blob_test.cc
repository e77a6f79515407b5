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
  bytes[8] = 3;

  EXPECT_THAT(DecodeMeshBlob(bytes), StatusIs(absl::StatusCode::kDataLoss, "unknown encoding 3"));
}

/// With a face that uses a vertex twice, and a vertex in no face.
FileMesh SomeFile() {
  FileMesh mesh;
  mesh.vertices.resize(3, 4);
  mesh.vertices << 0, 1.0F / 3, 0, -0.0F,  //
      0, 0, 1e-40F, 0,                     //
      0, 0, 0, 123456.789F;
  mesh.faces.resize(3, 3);
  mesh.faces << 0, 0, 2,  //
      2, 2, 2,            //
      1, 1, 1;
  mesh.normals = -2 * mesh.vertices;
  return mesh;
}

std::string WithFloatAt(std::string bytes, size_t place, float value) {
  std::memcpy(bytes.data() + place, &value, sizeof(value));
  return bytes;
}

TEST(FileMeshBlob, KeepsEveryBitAndTheOrder) {
  FileMesh mesh = SomeFile();
  for (const bool has_normals : {true, false}) {
    if (!has_normals) {
      mesh.normals.resize(3, 0);
    }
    const std::string bytes = EncodeFileMeshBlob(mesh);
    const absl::StatusOr<FileMesh> decoded = DecodeFileMeshBlob(bytes);
    ASSERT_THAT(decoded, testing::IsOk());
    EXPECT_EQ(testing::BitsOf(decoded->vertices), testing::BitsOf(mesh.vertices));
    EXPECT_EQ(decoded->faces, mesh.faces);
    EXPECT_EQ(decoded->HasNormals(), has_normals);
    EXPECT_EQ(testing::BitsOf(decoded->normals), testing::BitsOf(mesh.normals));
    EXPECT_TRUE(IsFileMeshBlob(bytes));
  }
}

TEST(FileMeshBlob, IsAMeshToThoseWhoNeedNoNormals) {
  const FileMesh file = SomeFile();
  const absl::StatusOr<TriangleMesh> mesh = DecodeMeshBlob(EncodeFileMeshBlob(file));
  ASSERT_THAT(mesh, testing::IsOk());
  EXPECT_EQ(mesh->vertices, file.vertices.cast<double>());
  EXPECT_EQ(mesh->faces, file.faces);
}

TEST(FileMeshBlob, IsRefusedWhenCutAtAnyByteOrTooLong) {
  const std::string bytes = EncodeFileMeshBlob(SomeFile());
  for (size_t size = 0; size < bytes.size(); ++size) {
    ASSERT_THAT(DecodeFileMeshBlob(bytes.substr(0, size)),
                StatusIs(absl::StatusCode::kDataLoss, "mesh blob"))
        << "cut to " << size;
  }
  EXPECT_THAT(DecodeFileMeshBlob(bytes + "x"), StatusIs(absl::StatusCode::kDataLoss, "do not fit"));
}

TEST(FileMeshBlob, IsRefusedWithCountsThatCannotBe) {
  const std::string bytes = EncodeFileMeshBlob(SomeFile());
  for (const size_t count_at : {9, 17, 25}) {
    for (const uint64_t count : {uint64_t{0}, uint64_t{1}, ~uint64_t{0} / 12 + 1, ~uint64_t{0}}) {
      std::string changed = bytes;
      std::memcpy(changed.data() + count_at, &count, sizeof(count));
      EXPECT_THAT(DecodeFileMeshBlob(changed), StatusIs(absl::StatusCode::kDataLoss, "do not fit"))
          << count_at << " " << count;
    }
  }
  EXPECT_THAT(DecodeFileMeshBlob(EncodeFileMeshBlob(FileMesh())),
              StatusIs(absl::StatusCode::kDataLoss, "0 vertices"));
}

TEST(FileMeshBlob, IsRefusedWithNumbersThatAreNotFinite) {
  const std::string bytes = EncodeFileMeshBlob(SomeFile());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (const size_t place : {size_t{33}, bytes.size() - sizeof(float)}) {
    EXPECT_THAT(DecodeFileMeshBlob(WithFloatAt(bytes, place, nan)),
                StatusIs(absl::StatusCode::kDataLoss, "not finite"));
  }
}

TEST(FileMeshBlob, IsRefusedWhenAFaceUsesAVertexThatIsNotThere) {
  FileMesh mesh = SomeFile();
  mesh.faces(1, 2) = 4;
  EXPECT_THAT(DecodeFileMeshBlob(EncodeFileMeshBlob(mesh)),
              StatusIs(absl::StatusCode::kDataLoss, "face 2 uses vertex 4 of 4"));
}

TEST(FileMeshBlob, IsNotAMeshOfAnotherEncoding) {
  const std::string raw = EncodeRawMeshBlob(Tetrahedron());
  EXPECT_FALSE(IsFileMeshBlob(raw));
  EXPECT_FALSE(IsFileMeshBlob("COHMESH1"));
  EXPECT_THAT(DecodeFileMeshBlob(raw), StatusIs(absl::StatusCode::kDataLoss, "has encoding 0"));
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
