#include "common/geometry/io/stl.h"

#include <cstring>
#include <limits>
#include <string>

#include <absl/strings/str_cat.h>
#include <gtest/gtest.h>

#include "common/geometry/io/write_mesh.h"
#include "tests/common/geometry/mesh/shapes.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::IsOk;
using testing::StatusIs;
using testing::Tetrahedron;
using testing::WavySheet;

constexpr auto kRefused = absl::StatusCode::kInvalidArgument;
constexpr const char* kFacet =
    "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n";

absl::StatusOr<TriangleMesh> Read(std::string_view bytes) {
  return ReadStl(bytes, "a.stl", {});
}

std::string WithCount(std::string bytes, uint32_t triangles) {
  std::memcpy(bytes.data() + 80, &triangles, sizeof(triangles));
  return bytes;
}

TEST(ReadStl, ReadsText) {
  const auto mesh = Read(absl::StrCat("solid name of it\n", kFacet, "endsolid name of it\n"));
  ASSERT_THAT(mesh, IsOk());
  EXPECT_EQ(mesh->VertexCount(), 3);
  EXPECT_EQ(mesh->vertices.col(1), Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(mesh->faces.col(0), Eigen::Vector3i(0, 1, 2));
}

TEST(ReadStl, ReadsTextInCapitalsOnOneLineWithoutNormals) {
  const auto mesh = Read(
      "SOLID\r\nFACET NORMAL nan nan nan OUTER LOOP VERTEX .5 5. +1 VERTEX 1e1 0 0 VERTEX 0 1 0 "
      "ENDLOOP ENDFACET\r\nENDSOLID");
  ASSERT_THAT(mesh, IsOk());
  EXPECT_EQ(mesh->vertices.col(0), Eigen::Vector3d(0.5, 5, 1));
}

TEST(ReadStl, JoinsSeveralSolids) {
  const std::string solid = absl::StrCat("solid a\n", kFacet, "endsolid a\n");
  const auto mesh = Read(solid + "\n" + solid);
  ASSERT_THAT(mesh, IsOk());
  EXPECT_EQ(mesh->VertexCount(), 3);
  EXPECT_EQ(mesh->FaceCount(), 2);
}

TEST(ReadStl, WeldsCornersAtTheSamePosition) {
  const TriangleMesh original = Tetrahedron();
  const auto mesh = Read(WriteStl(original));
  ASSERT_THAT(mesh, IsOk());
  ASSERT_EQ(mesh->VertexCount(), 4);
  ASSERT_EQ(mesh->FaceCount(), 4);
  for (Eigen::Index f = 0; f < 4; ++f) {
    for (Eigen::Index corner = 0; corner < 3; ++corner) {
      EXPECT_EQ(mesh->vertices.col(mesh->faces(corner, f)),
                original.vertices.col(original.faces(corner, f)));
    }
  }
}

TEST(ReadStl, WeldsNegativeZero) {
  const auto mesh = Read(
      "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex -0 0 -0.0\nvertex 0 1 0\n"
      "endloop\nendfacet\nendsolid");
  ASSERT_THAT(mesh, IsOk());
  EXPECT_EQ(mesh->VertexCount(), 2);
}

TEST(ReadStl, WeldsALargeMeshInOrderOfAppearance) {
  const TriangleMesh original = WavySheet(200);
  const auto mesh = Read(WriteStl(original));
  ASSERT_THAT(mesh, IsOk());
  EXPECT_EQ(mesh->VertexCount(), original.VertexCount());
  EXPECT_EQ(mesh->FaceCount(), original.FaceCount());
  EXPECT_EQ(mesh->faces.col(0), Eigen::Vector3i(0, 1, 2));
}

TEST(ReadStl, KnowsABinaryFileThatBeginsWithSolid) {
  std::string bytes = WriteStl(Tetrahedron());
  bytes.replace(0, 6, "solid ");
  EXPECT_TRUE(HasBinaryStlSize(bytes));
  const auto mesh = Read(bytes);
  ASSERT_THAT(mesh, IsOk());
  EXPECT_EQ(mesh->FaceCount(), 4);
}

TEST(ReadStl, RefusesFourThousandMillionTrianglesAtOnce) {
  EXPECT_THAT(Read(WithCount(WriteStl(Tetrahedron()), 4'000'000'000)),
              StatusIs(kRefused, "a.stl: byte 80: announces 4000000000 triangles"));
}

TEST(ReadStl, RefusesATruncatedBinaryFile) {
  const std::string bytes = WriteStl(Tetrahedron());
  EXPECT_THAT(Read(bytes.substr(0, bytes.size() - 1)),
              StatusIs(kRefused, "announces 4 triangles, which take 284 bytes; the file has 283"));
  EXPECT_THAT(Read(bytes.substr(0, 50)), StatusIs(kRefused, "a.stl: no STL file"));
}

TEST(ReadStl, RefusesATruncatedBinaryFileThatBeginsWithSolid) {
  std::string bytes = WriteStl(Tetrahedron());
  bytes.replace(0, 6, "solid ");
  EXPECT_THAT(Read(bytes.substr(0, 200)), StatusIs(kRefused, "announces 4 triangles"));
}

TEST(ReadStl, RefusesBytesAfterTheLastTriangle) {
  EXPECT_THAT(Read(WriteStl(Tetrahedron()) + "abc"),
              StatusIs(kRefused, "a.stl: byte 284: 3 bytes after the last of 4 triangles"));
}

TEST(ReadStl, NamesTheByteOfANumberThatIsNotFinite) {
  std::string bytes = WriteStl(Tetrahedron());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(bytes.data() + 84 + 50 + 12 + 4, &nan, sizeof(nan));
  EXPECT_THAT(Read(bytes), StatusIs(kRefused, "a.stl: byte 150: triangle 1: coordinate"));
}

TEST(ReadStl, RefusesAFileWithoutTriangles) {
  EXPECT_THAT(Read("solid empty\nendsolid empty\n"), StatusIs(kRefused, "no triangles"));
  EXPECT_THAT(Read(std::string(84, '\0')), StatusIs(kRefused, "no triangles"));
}

TEST(ReadStl, NamesTheLineOfATextError) {
  EXPECT_THAT(Read("solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 x\n"),
              StatusIs(kRefused, "a.stl: line 4: expected a finite number, found 'x'"));
  EXPECT_THAT(Read("solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 nan\n"),
              StatusIs(kRefused, "a.stl: line 4: expected a finite number, found 'nan'"));
  EXPECT_THAT(Read("solid\nhello\n"),
              StatusIs(kRefused, "a.stl: line 2: expected 'facet' or 'endsolid', found 'hello'"));
}

TEST(ReadStl, RefusesTruncatedText) {
  EXPECT_THAT(Read(absl::StrCat("solid a\n", kFacet)), StatusIs(kRefused, "the end of the file"));
  const std::string text = absl::StrCat("solid a\n", kFacet, "endsolid a\n");
  for (size_t size = 6; size < text.find("endsolid"); ++size) {
    EXPECT_THAT(Read(text.substr(0, size)), StatusIs(kRefused, "a.stl: line")) << size;
  }
}

TEST(ReadStl, RefusesAQuadrilateral) {
  EXPECT_THAT(Read("solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
                   "vertex 0 1 0\nvertex 1 1 1\nendloop\nendfacet\nendsolid\n"),
              StatusIs(kRefused, "line 7: expected 'endloop', found 'vertex'"));
}

TEST(ReadStl, StopsAtTheLimits) {
  EXPECT_THAT(ReadStl(WriteStl(Tetrahedron()), "a.stl", {.max_faces = 3}),
              StatusIs(absl::StatusCode::kResourceExhausted, "a.stl: 4 faces; the limit is 3"));
  EXPECT_THAT(ReadStl(WriteStl(Tetrahedron()), "a.stl", {.max_vertices = 3}),
              StatusIs(absl::StatusCode::kResourceExhausted, "a.stl: 4 vertices; the limit is 3"));
}

}  // namespace
}  // namespace cohort
