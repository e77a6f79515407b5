#include "common/geometry/io/read_mesh.h"

#include <cstdint>
#include <string>

#include <gtest/gtest.h>

#include "common/base/random.h"
#include "common/geometry/io/write_mesh.h"
#include "tests/common/geometry/mesh/shapes.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::IsOk;
using testing::IsOkAndHolds;
using testing::StatusIs;
using testing::Tetrahedron;

constexpr auto kRefused = absl::StatusCode::kInvalidArgument;

TEST(DetectMeshFormat, LooksAtTheContentFirst) {
  EXPECT_THAT(DetectMeshFormat("ply\nformat", "a.obj"), IsOkAndHolds(MeshFormat::kPly));
  EXPECT_THAT(DetectMeshFormat("ply\r\nformat", "a"), IsOkAndHolds(MeshFormat::kPly));
  EXPECT_THAT(DetectMeshFormat("solid x\n", "a.obj"), IsOkAndHolds(MeshFormat::kStl));
  EXPECT_THAT(DetectMeshFormat("SOLID\n", "a"), IsOkAndHolds(MeshFormat::kStl));
  EXPECT_THAT(DetectMeshFormat(WriteStl(Tetrahedron()), "a"), IsOkAndHolds(MeshFormat::kStl));
  EXPECT_THAT(DetectMeshFormat("# hi\n\nmtllib a\n", "a.txt"), IsOkAndHolds(MeshFormat::kObj));
  EXPECT_THAT(DetectMeshFormat("\xEF\xBB\xBFv 1 2 3\n", "a"), IsOkAndHolds(MeshFormat::kObj));
}

TEST(DetectMeshFormat, ThenAtTheName) {
  EXPECT_THAT(DetectMeshFormat("# nothing", "dir.ply/A.OBJ"), IsOkAndHolds(MeshFormat::kObj));
  EXPECT_THAT(DetectMeshFormat("x", "C:\\a.Ply"), IsOkAndHolds(MeshFormat::kPly));
  EXPECT_THAT(DetectMeshFormat("x", "a.b.stl"), IsOkAndHolds(MeshFormat::kStl));
}

TEST(DetectMeshFormat, RefusesWhatNeitherTells) {
  EXPECT_THAT(DetectMeshFormat("x", "a.txt"), StatusIs(kRefused, "a.txt: neither content nor"));
  EXPECT_THAT(DetectMeshFormat("x", "obj"), StatusIs(kRefused, "obj: neither content nor name"));
  EXPECT_THAT(DetectMeshFormat("x", "a.obj/x"), StatusIs(kRefused, "neither content nor name"));
}

TEST(DetectMeshFormat, NamesWhatElseItIs) {
  EXPECT_THAT(DetectMeshFormat("", "a.obj"), StatusIs(kRefused, "a.obj: the file is empty"));
  EXPECT_THAT(DetectMeshFormat("<!DOCTYPE html><html>", "a.obj"),
              StatusIs(kRefused, "a.obj: this is an HTML or XML page"));
  EXPECT_THAT(DetectMeshFormat("PK\x03\x04...", "a.obj"), StatusIs(kRefused, "a zip archive"));
  EXPECT_THAT(DetectMeshFormat("\x1F\x8B...", "a.ply"), StatusIs(kRefused, "a gzip archive"));
}

TEST(ReadLimits, MustBePositiveAndFitIndices) {
  EXPECT_THAT(ReadLimits().Validate(), IsOk());
  EXPECT_THAT(ReadLimits{.max_bytes = 0}.Validate(), StatusIs(kRefused, "positive"));
  EXPECT_THAT(ReadLimits{.max_vertices = -1}.Validate(), StatusIs(kRefused, "positive"));
  EXPECT_THAT(ReadLimits{.max_faces = int64_t{1} << 31}.Validate(), StatusIs(kRefused, "32 bits"));
}

TEST(ReadMesh, ReadsAllThreeFormats) {
  const TriangleMesh mesh = Tetrahedron();
  for (const std::string& bytes : {WriteObj(mesh), WritePly(mesh), WriteStl(mesh)}) {
    const auto read = ReadMesh(bytes, "unnamed");
    ASSERT_THAT(read, IsOk());
    EXPECT_EQ(read->VertexCount(), 4);
    EXPECT_EQ(read->FaceCount(), 4);
  }
}

TEST(ReadMesh, SkipsAByteOrderMark) {
  EXPECT_THAT(ReadMesh("\xEF\xBB\xBF" + WriteObj(Tetrahedron()), "a.obj"), IsOk());
  EXPECT_THAT(ReadMesh("\xEF\xBB\xBF" + WritePly(Tetrahedron()), "a.ply"), IsOk());
}

TEST(ReadMesh, RefusesAFileBeyondTheLimit) {
  EXPECT_THAT(ReadMesh("v 1 2 3\n", "a.obj", {.max_bytes = 7}),
              StatusIs(absl::StatusCode::kResourceExhausted, "a.obj: 8 bytes; the limit is 7"));
}

TEST(ReadMesh, RefusesGarbageUnderEachName) {
  std::string garbage;
  for (int i = 0; i < 5000; ++i) {
    garbage += static_cast<char>((i * i * 31 + i * 7) % 256);
  }
  for (const char* name : {"a.obj", "a.ply", "a.stl"}) {
    EXPECT_THAT(ReadMesh(garbage, name), StatusIs(kRefused, std::string(name) + ": ")) << name;
  }
}

size_t Index(Random& random, size_t size) {
  return static_cast<size_t>(random.Below(static_cast<int64_t>(size)));
}

/// Small damages of good files, the same at every run: any answer is right but a crash, or an index
/// or number that no later step could use.
void DamageAndRead(const std::string& good, const std::string& name) {
  Random random(17);
  for (int round = 0; round < 3000; ++round) {
    std::string bytes = good;
    for (int i = 0; i < 1 + round % 4; ++i) {
      bytes[Index(random, bytes.size())] = static_cast<char>(random.Below(256));
    }
    bytes.resize(round % 5 == 0 ? Index(random, bytes.size()) : bytes.size());
    const auto mesh = ReadMesh(bytes, name);
    if (mesh.ok()) {
      ASSERT_TRUE(mesh->vertices.allFinite()) << round;
      ASSERT_TRUE(mesh->IsPointCloud() ||
                  (mesh->faces.minCoeff() >= 0 && mesh->faces.maxCoeff() < mesh->VertexCount()))
          << round;
    } else {
      ASSERT_EQ(std::string(mesh.status().message()).rfind(name + ": ", 0), 0U) << mesh.status();
    }
  }
}

TEST(ReadMesh, SurvivesDamagedObj) {
  DamageAndRead(WriteObj(Tetrahedron()), "a.obj");
}

TEST(ReadMesh, SurvivesDamagedPly) {
  DamageAndRead(WritePly(Tetrahedron()), "a.ply");
}

TEST(ReadMesh, SurvivesDamagedStl) {
  DamageAndRead(WriteStl(Tetrahedron()), "a.stl");
}

// ---- As in the file ----

constexpr char kOddObj[] =
    "v 0 0 0\nv 1 0 0\nv 0 1.25 0\nv 9 9 9\nv 0 0 0\n"
    "vn 0 0 2\nvn 0 0 1\nvn 0 1 0\nvn 1 0 0\nvn 0.5 \\\n 0 0\nvn 7 7 7\n"
    "f 1//6 2//6 3//6\nf 2 2 3\nf 1 2 3\n";

TEST(ReadFileMesh, KeepsOrderUnusedVerticesAndOddFaces) {
  const absl::StatusOr<FileMesh> file = ReadFileMesh(kOddObj, "odd.obj");
  ASSERT_THAT(file, IsOk());
  Eigen::Matrix3Xf vertices(3, 5);
  vertices << 0, 1, 0, 9, 0,  //
      0, 0, 1.25F, 9, 0,      //
      0, 0, 0, 9, 0;
  Matrix3Xi faces(3, 3);
  faces << 0, 1, 0,  //
      1, 1, 1,       //
      2, 2, 2;
  EXPECT_EQ(file->vertices, vertices);
  EXPECT_EQ(file->faces, faces);
}

TEST(ReadFileMesh, GivesNormalIToVertexIWhateverTheFacesSay) {
  const absl::StatusOr<FileMesh> file = ReadFileMesh(kOddObj, "odd.obj");
  ASSERT_THAT(file, IsOk());
  Eigen::Matrix3Xf normals(3, 5);
  normals << 0, 0, 0, 1, 0.5F,  //
      0, 0, 1, 0, 0,            //
      2, 1, 0, 0, 0;
  EXPECT_EQ(file->normals, normals);
}

TEST(ReadFileMesh, HasNoNormalsWhereTheFileHasTooFew) {
  const absl::StatusOr<FileMesh> file =
      ReadFileMesh("v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 0 0 1\nf 1 2 3\n", "a.obj");
  ASSERT_THAT(file, IsOk());
  EXPECT_FALSE(file->HasNormals());
}

TEST(ReadFileMesh, ReadsTheOtherFormatsToo) {
  for (const std::string& bytes : {WritePly(Tetrahedron()), WriteObj(Tetrahedron())}) {
    const absl::StatusOr<FileMesh> file = ReadFileMesh(bytes, "tetrahedron");
    ASSERT_THAT(file, IsOk());
    EXPECT_EQ(file->vertices, Tetrahedron().vertices.cast<float>());
    EXPECT_EQ(file->faces, Tetrahedron().faces);
    EXPECT_FALSE(file->HasNormals());
  }
}

TEST(ReadFileMesh, RefusesNormalsThatAreNoNumbersWhichReadMeshPassesOver) {
  const std::string bytes = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 nan 1\nf 1 2 3\n";
  EXPECT_THAT(ReadMesh(bytes, "a.obj"), IsOk());
  EXPECT_THAT(ReadFileMesh(bytes, "a.obj"),
              StatusIs(kRefused, "a.obj: line 4: normal 1: 'nan' is not a finite number"));
  EXPECT_THAT(ReadFileMesh("v 0 0 0\nvn 0 1\n", "a.obj"), StatusIs(kRefused, "line 2: normal 1"));
}

TEST(ReadFileMesh, KeepsTheLimits) {
  ReadLimits limits;
  limits.max_bytes = 10;
  EXPECT_THAT(ReadFileMesh(kOddObj, "odd.obj", limits),
              StatusIs(absl::StatusCode::kResourceExhausted, "the limit is 10"));
}

}  // namespace
}  // namespace cohort
