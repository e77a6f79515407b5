#include "common/geometry/io/obj.h"

#include <string>

#include <absl/strings/str_cat.h>
#include <gtest/gtest.h>

#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::IsOk;
using testing::StatusIs;

constexpr auto kRefused = absl::StatusCode::kInvalidArgument;
constexpr const char* kThreeVertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

absl::StatusOr<TriangleMesh> Read(std::string_view text) {
  return ReadObj(text, "scan7.obj", {});
}

absl::StatusOr<TriangleMesh> ReadAfterThreeVertices(const std::string& text) {
  return Read(kThreeVertices + text);
}

TEST(ReadObj, ReadsVerticesAndFaces) {
  const auto mesh = ReadAfterThreeVertices("f 1 2 3\n");
  ASSERT_THAT(mesh, IsOk());
  ASSERT_EQ(mesh->VertexCount(), 3);
  EXPECT_EQ(mesh->vertices.col(1), Eigen::Vector3d(1, 0, 0));
  ASSERT_EQ(mesh->FaceCount(), 1);
  EXPECT_EQ(mesh->faces.col(0), Eigen::Vector3i(0, 1, 2));
}

TEST(ReadObj, ReadsEverySpellingOfANumber) {
  const auto mesh = Read("v .5 5. +1e-2\nv -.5E1 -5. +0\nv\t1  2 \t 3 ");
  ASSERT_THAT(mesh, IsOk());
  EXPECT_EQ(mesh->vertices.col(0), Eigen::Vector3d(0.5, 5, 0.01));
  EXPECT_EQ(mesh->vertices.col(1), Eigen::Vector3d(-5, -5, 0));
  EXPECT_EQ(mesh->vertices.col(2), Eigen::Vector3d(1, 2, 3));
}

TEST(ReadObj, ReadsVerticesWithWeightAndColor) {
  const auto mesh = Read("v 1 2 3 1\nv 1 2 3 .1 .2 .3\nv 1 2 3 1 .1 .2 .3\n");
  ASSERT_THAT(mesh, IsOk());
  for (Eigen::Index v = 0; v < 3; ++v) {
    EXPECT_EQ(mesh->vertices.col(v), Eigen::Vector3d(1, 2, 3)) << v;
  }
}

TEST(ReadObj, RefusesAVertexAtInfinity) {
  EXPECT_THAT(Read("v 1 2 3 0\n"), StatusIs(kRefused, "scan7.obj: line 1: vertex has weight 0"));
}

TEST(ReadObj, RefusesOtherCountsOfNumbers) {
  EXPECT_THAT(Read("v 1 2\n"), StatusIs(kRefused, "line 1: vertex has fewer than 3 numbers"));
  EXPECT_THAT(Read("v 1 2 3 4 5\n"), StatusIs(kRefused, "line 1: vertex has 5 numbers"));
  EXPECT_THAT(Read("v 1 2 3 4 5 6 7 8\n"), StatusIs(kRefused, "line 1: vertex has 8 numbers"));
}

TEST(ReadObj, NamesTheWordThatIsNoNumber) {
  EXPECT_THAT(Read("v 1 2 3\n# c\nv 1 nan 3\n"),
              StatusIs(kRefused, "scan7.obj: line 3: vertex 2: 'nan' is not a finite number"));
  EXPECT_THAT(Read("v 1,5 2,5 3,5\n"), StatusIs(kRefused, "'1,5' is not a finite number"));
  EXPECT_THAT(Read("v 1e999 0 0\n"), StatusIs(kRefused, "'1e999' is not a finite number"));
}

TEST(ReadObj, SplitsPolygonsIntoFans) {
  const auto mesh = ReadAfterThreeVertices("v 0 0 1\nv 1 1 1\nf 1 2 3 4 5\n");
  ASSERT_THAT(mesh, IsOk());
  ASSERT_EQ(mesh->FaceCount(), 3);
  EXPECT_EQ(mesh->faces.col(0), Eigen::Vector3i(0, 1, 2));
  EXPECT_EQ(mesh->faces.col(1), Eigen::Vector3i(0, 2, 3));
  EXPECT_EQ(mesh->faces.col(2), Eigen::Vector3i(0, 3, 4));
}

TEST(ReadObj, ReadsEveryKindOfCorner) {
  const auto mesh = ReadAfterThreeVertices(
      "vt 0 0\nvn 0 0 1\nf 1 2 3\nf 1/1 2/1 3/1\nf 1//1 2//1 3//1\nf 1/1/1 2/1/1 3/1/1\n"
      "f 1// 2/ 3\n");
  ASSERT_THAT(mesh, IsOk());
  ASSERT_EQ(mesh->FaceCount(), 5);
  for (Eigen::Index f = 0; f < 5; ++f) {
    EXPECT_EQ(mesh->faces.col(f), Eigen::Vector3i(0, 1, 2)) << f;
  }
}

TEST(ReadObj, CountsNegativeIndicesFromTheLatestVertex) {
  const auto mesh = ReadAfterThreeVertices("f -3 -2 -1\nv 0 0 1\nf -3//-1 -2//-1 -1//-1\n");
  ASSERT_THAT(mesh, IsOk());
  EXPECT_EQ(mesh->faces.col(0), Eigen::Vector3i(0, 1, 2));
  EXPECT_EQ(mesh->faces.col(1), Eigen::Vector3i(1, 2, 3));
}

TEST(ReadObj, AllowsFacesBeforeTheirVertices) {
  EXPECT_THAT(Read(absl::StrCat("f 1 2 3\n", kThreeVertices)), IsOk());
}

TEST(ReadObj, NamesTheLineOfAnIndexOutOfRange) {
  EXPECT_THAT(ReadAfterThreeVertices("f 1 2 3\nf 1 2 4\nf 1 2 3\n"),
              StatusIs(kRefused, "scan7.obj: line 5: face uses vertex 4 of 3"));
  EXPECT_THAT(ReadAfterThreeVertices("f 0 1 2\n"),
              StatusIs(kRefused, "scan7.obj: line 4: face uses vertex 0 of 3"));
  EXPECT_THAT(ReadAfterThreeVertices("f -4 1 2\nv 1 1 1\n"),
              StatusIs(kRefused, "scan7.obj: line 4: face uses vertex -4 of 3"));
  EXPECT_THAT(ReadAfterThreeVertices("f 1 2 4294967297\n"),
              StatusIs(kRefused, "face uses vertex 4294967297 of 3"));
  EXPECT_THAT(ReadAfterThreeVertices("f 1 2 -9223372036854775808\n"),
              StatusIs(kRefused, "face uses vertex -9223372036854775808 of 3"));
}

TEST(ReadObj, RefusesBrokenCorners) {
  for (const char* corner : {"a", "1.5", "/1", "1/a", "1/1/1/1", "1\\1", "99999999999999999999"}) {
    EXPECT_THAT(ReadAfterThreeVertices(absl::StrCat("f 1 2 ", corner, "\n")),
                StatusIs(kRefused, "scan7.obj: line 4: face corner"))
        << corner;
  }
}

TEST(ReadObj, RefusesFacesOfTwoCorners) {
  EXPECT_THAT(ReadAfterThreeVertices("f 1 2\n"),
              StatusIs(kRefused, "line 4: face has 2 corners; it needs at least 3"));
  EXPECT_THAT(ReadAfterThreeVertices("f\n"), StatusIs(kRefused, "line 4: face has 0 corners"));
}

TEST(ReadObj, ReadsCrlfAndLoneCr) {
  for (const char* end : {"\n", "\r\n", "\r"}) {
    const auto mesh = Read(absl::StrCat("v 0 0 0", end, "v 1 0 0", end, "v 0 1 0", end, "f 1 2 3"));
    ASSERT_THAT(mesh, IsOk());
    EXPECT_EQ(mesh->VertexCount(), 3);
    EXPECT_EQ(mesh->FaceCount(), 1);
  }
}

TEST(ReadObj, DropsComments) {
  const auto mesh = ReadAfterThreeVertices("# f 9 9 9\nf 1 2 3 # 4 5\nf 3 2 1#x\n#\n");
  ASSERT_THAT(mesh, IsOk());
  EXPECT_EQ(mesh->FaceCount(), 2);
}

TEST(ReadObj, JoinsLinesAfterABackslash) {
  const auto mesh = Read("v 0 \\\n0 \\\r\n 0\nv 1 0 0\nv 0 1 0\nf 1\\\n2 3\nf 3 2 1 \\");
  ASSERT_THAT(mesh, IsOk());
  EXPECT_EQ(mesh->VertexCount(), 3);
  EXPECT_EQ(mesh->FaceCount(), 1 + 1);
}

TEST(ReadObj, NamesTheFirstLineOfAJoinedStatement) {
  EXPECT_THAT(Read("v 0 0 0\nv 1 \\\n2 \\\nx\n"), StatusIs(kRefused, "scan7.obj: line 2:"));
}

TEST(ReadObj, DoesNotJoinNamesThatEndInABackslash) {
  const auto mesh = Read("mtllib C:\\scans\\\nv 0 0 0\n# C:\\\nv 1 0 0\nv 0 1 0\n");
  ASSERT_THAT(mesh, IsOk());
  EXPECT_EQ(mesh->VertexCount(), 3);
}

TEST(ReadObj, PassesOverOtherStatements) {
  const auto mesh = ReadAfterThreeVertices(
      "mtllib a.mtl\no name\ng a b\ns off\nusemtl m\nl 1 2\np 1\nvp 1 2\ncurv 0 1\nwhatever\n"
      "vt 0 0\nvn nan nan nan\nf 1 2 3\n");
  ASSERT_THAT(mesh, IsOk());
  EXPECT_EQ(mesh->VertexCount(), 3);
  EXPECT_EQ(mesh->FaceCount(), 1);
}

TEST(ReadObj, WithoutFacesIsACloud) {
  const auto mesh = Read(kThreeVertices);
  ASSERT_THAT(mesh, IsOk());
  EXPECT_TRUE(mesh->IsPointCloud());
}

TEST(ReadObj, RefusesWhatHasNoVertices) {
  EXPECT_THAT(Read("hello\n"), StatusIs(kRefused, "scan7.obj: no vertices"));
  EXPECT_THAT(Read(""), StatusIs(kRefused, "scan7.obj: no vertices"));
}

TEST(ReadObj, StopsAtTheLimits) {
  const std::string text = absl::StrCat(kThreeVertices, "f 1 2 3 1 2\n");
  EXPECT_THAT(ReadObj(text, "a.obj", {.max_vertices = 2}),
              StatusIs(absl::StatusCode::kResourceExhausted, "a.obj: 3 vertices; the limit is 2"));
  EXPECT_THAT(ReadObj(text, "a.obj", {.max_faces = 2}),
              StatusIs(absl::StatusCode::kResourceExhausted, "a.obj: 3 faces; the limit is 2"));
}

TEST(ReadObj, ReadsOneHugePolygonInLinearTime) {
  std::string text = kThreeVertices;
  text += "f";
  for (int i = 0; i < 200'000; ++i) {
    text += i % 7 == 0 ? " \\\n1" : " 2";
  }
  const auto mesh = Read(text);
  ASSERT_THAT(mesh, IsOk());
  EXPECT_EQ(mesh->FaceCount(), 199'998);
}

}  // namespace
}  // namespace cohort
