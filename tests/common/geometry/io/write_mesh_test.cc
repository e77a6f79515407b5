#include "common/geometry/io/write_mesh.h"

#include <cstring>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/geometry/io/read_mesh.h"
#include "tests/common/geometry/mesh/shapes.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::IsOk;
using testing::MakeMesh;
using testing::Tetrahedron;
using testing::WavySheet;

TEST(WritePly, ReadsBackAsTheSameFloats) {
  const TriangleMesh mesh = WavySheet(20);
  const auto read = ReadMesh(WritePly(mesh), "a.ply");
  ASSERT_THAT(read, IsOk());
  EXPECT_EQ(read->vertices, mesh.vertices.cast<float>().cast<double>());
  EXPECT_EQ(read->faces, mesh.faces);
}

TEST(WritePly, WritesTheDocumentedLayout) {
  const TriangleMesh mesh = MakeMesh({{1, 2, 3}, {4, 5, 6}, {7, 8, 10}}, {{2, 1, 0}});
  const std::vector<VertexScalar> scalars = {{"deviation", {0.5F, 1.5F, 2.5F}},
                                             {"signed_deviation", {-1.F, 0.F, 1.F}}};
  const std::vector<Rgb> colors = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}};
  const std::string bytes = WritePly(mesh, scalars, colors);
  const std::string header =
      "ply\nformat binary_little_endian 1.0\ncomment written by Cohort\nelement vertex 3\n"
      "property float x\nproperty float y\nproperty float z\n"
      "property float deviation\nproperty float signed_deviation\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  ASSERT_EQ(bytes.substr(0, header.size()), header);
  const size_t row = 5 * sizeof(float) + 3;
  ASSERT_EQ(bytes.size(), header.size() + 3 * row + 1 + 3 * sizeof(int32_t));
  float floats[5];
  std::memcpy(floats, bytes.data() + header.size() + row, sizeof(floats));
  EXPECT_EQ(std::vector<float>(floats, floats + 5), (std::vector<float>{4, 5, 6, 1.5F, 0}));
  EXPECT_EQ(bytes.substr(header.size() + row + sizeof(floats), 3), "\x04\x05\x06");
  EXPECT_EQ(bytes.substr(header.size() + 3 * row), (std::string("\3\2\0\0\0\1\0\0\0\0\0\0\0", 13)));
}

TEST(WritePly, WithScalarsAndColorsIsReadByOurReader) {
  const TriangleMesh mesh = Tetrahedron();
  const std::vector<VertexScalar> scalars = {{"deviation", {0, 1, 2, 3}}};
  const std::vector<Rgb> colors(4);
  const auto read = ReadMesh(WritePly(mesh, scalars, colors), "a.ply");
  ASSERT_THAT(read, IsOk());
  EXPECT_EQ(read->vertices, mesh.vertices);
  EXPECT_EQ(read->faces, mesh.faces);
}

TEST(WritePly, WritesACloud) {
  TriangleMesh cloud = Tetrahedron();
  cloud.faces.resize(3, 0);
  const auto read = ReadMesh(WritePly(cloud), "a.ply");
  ASSERT_THAT(read, IsOk());
  EXPECT_TRUE(read->IsPointCloud());
  EXPECT_EQ(read->vertices, cloud.vertices);
}

TEST(WriteObj, ReadsBackAsTheSameFloats) {
  TriangleMesh mesh = WavySheet(20);
  mesh.vertices.col(0) << 1.0 / 3, -1e-20, 123456.789;
  const auto read = ReadMesh(WriteObj(mesh), "a.obj");
  ASSERT_THAT(read, IsOk());
  EXPECT_EQ(read->vertices.cast<float>(), mesh.vertices.cast<float>());
  EXPECT_EQ(read->faces, mesh.faces);
}

TEST(WriteStl, ReadsBackTheSameTriangles) {
  const TriangleMesh mesh = WavySheet(20);
  const auto read = ReadMesh(WriteStl(mesh), "a.stl");
  ASSERT_THAT(read, IsOk());
  ASSERT_EQ(read->FaceCount(), mesh.FaceCount());
  EXPECT_EQ(read->VertexCount(), mesh.VertexCount());
  for (Eigen::Index f = 0; f < mesh.FaceCount(); ++f) {
    for (Eigen::Index corner = 0; corner < 3; ++corner) {
      ASSERT_EQ(read->vertices.col(read->faces(corner, f)).cast<float>(),
                mesh.vertices.col(mesh.faces(corner, f)).cast<float>())
          << f;
    }
  }
}

TEST(WriteStl, WritesUnitNormals) {
  const std::string bytes = WriteStl(MakeMesh({{0, 0, 0}, {3, 0, 0}, {0, 3, 0}}, {{0, 1, 2}}));
  ASSERT_EQ(bytes.size(), 84U + 50U);
  float normal[3];
  std::memcpy(normal, bytes.data() + 84, sizeof(normal));
  EXPECT_EQ(normal[0], 0);
  EXPECT_EQ(normal[1], 0);
  EXPECT_EQ(normal[2], 1);
}

TEST(WriteStl, WritesAZeroNormalWhereThereIsNoArea) {
  const std::string bytes = WriteStl(MakeMesh({{1, 1, 1}, {2, 2, 2}, {3, 3, 3}}, {{0, 1, 2}}));
  EXPECT_EQ(bytes.substr(84, 12), std::string(12, '\0'));
}

TEST(WriteVtk, IsBigEndianPolyData) {
  const TriangleMesh mesh = MakeMesh({{0, 0, 0}, {1, 0, 0}, {0, -2, 0}}, {{0, 1, 2}});
  const std::vector<VertexScalar> scalars = {{"rms", {0.5F, 1, 2}}};
  const auto big = [](std::initializer_list<uint32_t> values) {
    std::string bytes;
    for (const uint32_t value : values) {
      for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift);
    }
    return bytes;
  };
  // IEEE 754: 1 is 3f800000, -2 is c0000000, 0.5 is 3f000000, 2 is 40000000.
  EXPECT_EQ(WriteVtk(mesh, scalars),
            "# vtk DataFile Version 3.0\nwritten by Cohort\nBINARY\nDATASET POLYDATA\n"
            "POINTS 3 float\n" +
                big({0, 0, 0, 0x3f800000, 0, 0, 0, 0xc0000000, 0}) + "\nPOLYGONS 1 4\n" +
                big({3, 0, 1, 2}) + "\nPOINT_DATA 3\nSCALARS rms float 1\nLOOKUP_TABLE default\n" +
                big({0x3f000000, 0x3f800000, 0x40000000}) + "\n");
}

TEST(WriteVtk, ACloudIsOfVertices) {
  TriangleMesh cloud = Tetrahedron();
  cloud.faces.resize(3, 0);
  EXPECT_THAT(WriteVtk(cloud), ::testing::HasSubstr("\nVERTICES 4 8\n"));
}

TEST(Writers, GiveTheSameBytesTwice) {
  const TriangleMesh mesh = WavySheet(10);
  EXPECT_EQ(WritePly(mesh), WritePly(mesh));
  EXPECT_EQ(WriteObj(mesh), WriteObj(mesh));
  EXPECT_EQ(WriteStl(mesh), WriteStl(mesh));
  EXPECT_EQ(WriteVtk(mesh), WriteVtk(mesh));
}

}  // namespace
}  // namespace cohort
