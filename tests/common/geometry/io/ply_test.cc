#include "common/geometry/io/ply.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <string>

#include <absl/strings/str_cat.h>
#include <gtest/gtest.h>

#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::IsOk;
using testing::StatusIs;

constexpr auto kRefused = absl::StatusCode::kInvalidArgument;
constexpr const char* kXyz = "property float x\nproperty float y\nproperty float z\n";
constexpr const char* kCorners = "property list uchar int vertex_indices\n";

absl::StatusOr<TriangleMesh> Read(std::string_view bytes) {
  return ReadPly(bytes, "a.ply", {});
}

std::string Header(std::string_view format, std::string_view elements) {
  return absl::StrCat("ply\nformat ", std::string(format), " 1.0\n", std::string(elements),
                      "end_header\n");
}

std::string TextMesh(std::string_view rows) {
  return Header("ascii", absl::StrCat("element vertex 4\n", kXyz, "element face 1\n", kCorners)) +
         std::string(rows);
}

/// The bytes of the values one after the other, most significant first if `big_endian`.
enum class Order { kLittle, kBig };
template <typename... T>
std::string Bytes(Order order, T... values) {
  std::string all;
  const auto append = [&](auto value) {
    std::string bytes(sizeof(value), '\0');
    std::memcpy(bytes.data(), &value, sizeof(value));
    if (order == Order::kBig) {
      std::reverse(bytes.begin(), bytes.end());
    }
    all += bytes;
  };
  (append(values), ...);
  return all;
}

TEST(ReadPly, ReadsText) {
  const auto mesh = Read(TextMesh("0 0 0\n1 0 0\n1 1 .5\n-1e-1 +1 0\n4 0 1 2 3\n"));
  ASSERT_THAT(mesh, IsOk());
  ASSERT_EQ(mesh->VertexCount(), 4);
  EXPECT_EQ(mesh->vertices.col(2), Eigen::Vector3d(1, 1, 0.5));
  EXPECT_EQ(mesh->vertices.col(3), Eigen::Vector3d(-0.1, 1, 0));
  ASSERT_EQ(mesh->FaceCount(), 2);
  EXPECT_EQ(mesh->faces.col(0), Eigen::Vector3i(0, 1, 2));
  EXPECT_EQ(mesh->faces.col(1), Eigen::Vector3i(0, 2, 3));
}

TEST(ReadPly, ReadsBothByteOrders) {
  for (const Order order : {Order::kLittle, Order::kBig}) {
    const std::string bytes =
        Header(order == Order::kLittle ? "binary_little_endian" : "binary_big_endian",
               absl::StrCat("element vertex 3\n", kXyz, "element face 1\n", kCorners)) +
        Bytes(order, 0.F, 1.F, 2.F, 3.F, 4.F, 5.F, 6.F, 7.F, 8.5F) +
        Bytes(order, uint8_t{3}, int32_t{2}, int32_t{1}, int32_t{0});
    const auto mesh = Read(bytes);
    ASSERT_THAT(mesh, IsOk());
    EXPECT_EQ(mesh->vertices.col(2), Eigen::Vector3d(6, 7, 8.5));
    EXPECT_EQ(mesh->faces.col(0), Eigen::Vector3i(2, 1, 0));
  }
}

TEST(ReadPly, ReadsEveryNumberTypeUnderBothNames) {
  const auto read_x = [](const char* type, const std::string& value) {
    const auto mesh = Read(
        Header("binary_little_endian", absl::StrCat("element vertex 1\nproperty ", type,
                                                    " x\nproperty char y\nproperty int8 z\n")) +
        value + Bytes(Order::kLittle, int8_t{-2}, int8_t{-3}));
    EXPECT_THAT(mesh, IsOk()) << type;
    return mesh.ok() ? mesh->vertices(0, 0) : -999;
  };
  for (const char* type : {"char", "int8"}) {
    EXPECT_EQ(read_x(type, Bytes(Order::kLittle, int8_t{-128})), -128);
  }
  for (const char* type : {"uchar", "uint8"}) {
    EXPECT_EQ(read_x(type, Bytes(Order::kLittle, uint8_t{255})), 255);
  }
  for (const char* type : {"short", "int16"}) {
    EXPECT_EQ(read_x(type, Bytes(Order::kLittle, int16_t{-32768})), -32768);
  }
  for (const char* type : {"ushort", "uint16"}) {
    EXPECT_EQ(read_x(type, Bytes(Order::kLittle, uint16_t{65535})), 65535);
  }
  for (const char* type : {"int", "int32"}) {
    EXPECT_EQ(read_x(type, Bytes(Order::kLittle, INT32_MIN)), INT32_MIN);
  }
  for (const char* type : {"uint", "uint32"}) {
    EXPECT_EQ(read_x(type, Bytes(Order::kLittle, UINT32_MAX)), UINT32_MAX);
  }
  for (const char* type : {"float", "float32"}) {
    EXPECT_EQ(read_x(type, Bytes(Order::kLittle, 0.25F)), 0.25);
  }
  for (const char* type : {"double", "float64"}) {
    EXPECT_EQ(read_x(type, Bytes(Order::kLittle, 0.1)), 0.1);
  }
}

TEST(ReadPly, PassesOverOtherPropertiesAndElements) {
  const auto mesh = Read(Header("ascii",
                                "comment a\nobj_info b\n"
                                "element camera 1\nproperty float view\nproperty list int int ids\n"
                                "element vertex 3\nproperty uchar red\nproperty float z\n"
                                "property list uchar double weights\nproperty float x\n"
                                "property float y\nproperty float quality\n"
                                "element edge 1\nproperty int v1\nproperty int v2\n"
                                "element face 1\nproperty int flags\n"
                                "property list uint8 uint32 vertex_index\n"
                                "property list uchar float texcoord\n"
                                "element empty 3000000000\n") +
                         "1.5 2 7 8\n"
                         "255 3 0 1 2 nan\n9 3 2 .1 .2 10 0 0\n0 3 1 5 0 10 0\n"
                         "0 1\n"
                         "7 3 0 1 2 6 0 0 0 0 0 0\n");
  ASSERT_THAT(mesh, IsOk());
  EXPECT_EQ(mesh->vertices.col(0), Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(mesh->vertices.col(1), Eigen::Vector3d(10, 0, 3));
  EXPECT_EQ(mesh->vertices.col(2), Eigen::Vector3d(0, 10, 3));
  EXPECT_EQ(mesh->faces.col(0), Eigen::Vector3i(0, 1, 2));
}

TEST(ReadPly, ReadsFacesBeforeVertices) {
  const auto mesh =
      Read(Header("binary_big_endian",
                  absl::StrCat("element face 1\nproperty list ushort short vertex_index\n"
                               "element vertex 3\n",
                               kXyz)) +
           Bytes(Order::kBig, uint16_t{3}, int16_t{0}, int16_t{1}, int16_t{2}) +
           Bytes(Order::kBig, 0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F));
  ASSERT_THAT(mesh, IsOk());
  EXPECT_EQ(mesh->faces.col(0), Eigen::Vector3i(0, 1, 2));
}

TEST(ReadPly, WithoutFacesIsACloud) {
  for (const char* faces : {"", "element face 0\nproperty list uchar int vertex_indices\n"}) {
    const auto mesh =
        Read(Header("ascii", absl::StrCat("element vertex 2\n", kXyz, faces)) + "1 2 3\n4 5 6\n");
    ASSERT_THAT(mesh, IsOk());
    EXPECT_TRUE(mesh->IsPointCloud());
    EXPECT_EQ(mesh->VertexCount(), 2);
  }
}

TEST(ReadPly, ReadsHeadersThatEndInCrlfOrCr) {
  for (const char* end : {"\n", "\r\n", "\r"}) {
    std::string header = Header("binary_little_endian", absl::StrCat("element vertex 1\n", kXyz));
    for (size_t at = header.find('\n'); at != std::string::npos;
         at = header.find('\n', at + std::strlen(end))) {
      header.replace(at, 1, end);
    }
    // The first byte of the values looks like the end of a line.
    const auto mesh = Read(header + Bytes(Order::kLittle, '\n', '\0', '\0', '\0', 1.F, 2.F));
    ASSERT_THAT(mesh, IsOk());
    EXPECT_EQ(mesh->vertices(1, 0), 1);
  }
}

TEST(ReadPly, ReadsTextWithBlankLinesAndWithoutALastLineEnd) {
  EXPECT_THAT(Read(TextMesh("0 0 0\r\n\r\n1 0 0\n1 1 0 \n 0 1 0\n\n3 0 1 2")), IsOk());
}

TEST(ReadPly, RefusesFourThousandMillionVerticesAtOnce) {
  const ReadLimits no_limits = {.max_vertices = std::numeric_limits<int32_t>::max(),
                                .max_faces = INT32_MAX};
  for (const char* format : {"ascii", "binary_little_endian"}) {
    const std::string bytes =
        Header(format, absl::StrCat("element vertex 2000000000\n", kXyz)) + "1 2 3\n";
    EXPECT_THAT(ReadPly(bytes, "a.ply", no_limits),
                StatusIs(kRefused, "the header announces 2000000000 rows of 'vertex'"))
        << format;
  }
  const std::string beyond = Header("ascii", absl::StrCat("element vertex 4000000000\n", kXyz));
  EXPECT_THAT(Read(beyond), StatusIs(absl::StatusCode::kResourceExhausted, "4000000000 vertices"));
}

TEST(ReadPly, RefusesAListOfFourThousandMillionEntries) {
  const std::string bytes =
      Header("binary_little_endian",
             absl::StrCat("element vertex 3\n", kXyz,
                          "element face 1\nproperty list uint int vertex_indices\n")) +
      Bytes(Order::kLittle, 0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F) +
      Bytes(Order::kLittle, uint32_t{4'000'000'000}, 0, 1, 2);
  EXPECT_THAT(Read(bytes), StatusIs(kRefused, "list 'vertex_indices' of 4000000000 entries"));
  EXPECT_THAT(Read(TextMesh("0 0 0\n1 0 0\n1 1 0\n0 1 0\n4000000000 0 1 2\n")),
              StatusIs(kRefused, "a.ply: line 14: list 'vertex_indices' of 4000000000 entries"));
}

TEST(ReadPly, RefusesANegativeListLength) {
  EXPECT_THAT(Read(TextMesh("0 0 0\n1 0 0\n1 1 0\n0 1 0\n-3 0 1 2\n")),
              StatusIs(kRefused, "list 'vertex_indices' of -3 entries"));
}

TEST(ReadPly, SkipsHugeElementsWithoutPropertiesAtOnce) {
  EXPECT_THAT(Read(Header("ascii", absl::StrCat("element nothing 9223372036854775807\n",
                                                "element vertex 1\n", kXyz)) +
                   "1 2 3\n"),
              IsOk());
}

TEST(ReadPly, NamesLineAndRowOfAFaceOutOfRange) {
  EXPECT_THAT(Read(TextMesh("0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 4\n")),
              StatusIs(kRefused, "a.ply: line 14: face 0 uses vertex 4; the file has vertices 0"));
  EXPECT_THAT(Read(TextMesh("0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 -1\n")),
              StatusIs(kRefused, "a.ply: line 14: face 0 uses vertex -1"));
}

TEST(ReadPly, RefusesNumbersThatAreNotFinite) {
  EXPECT_THAT(Read(TextMesh("0 0 0\n1 0 nan\n")), StatusIs(kRefused, "a.ply: line"));
  const std::string bytes =
      Header("binary_little_endian", absl::StrCat("element vertex 2\n", kXyz)) +
      Bytes(Order::kLittle, 0.F, 0.F, 0.F, 1.F, std::numeric_limits<float>::infinity(), 0.F);
  EXPECT_THAT(Read(bytes), StatusIs(kRefused, "vertex 1: y is not a finite number"));
}

TEST(ReadPly, RefusesRowsOfTheWrongLength) {
  EXPECT_THAT(Read(TextMesh("0 0 0\n1 0\n1 1 0\n0 1 0\n3 0 1 2\n")),
              StatusIs(kRefused, "a.ply: line 11: fewer values than properties"));
  EXPECT_THAT(Read(TextMesh("0 0 0\n1 0 0 9\n1 1 0\n0 1 0\n3 0 1 2\n")),
              StatusIs(kRefused, "a.ply: line 11: more values than properties, from '9' on"));
}

TEST(ReadPly, RefusesWordsThatAreNoNumbers) {
  EXPECT_THAT(Read(TextMesh("0 0 x\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n")),
              StatusIs(kRefused, "a.ply: line 10: 'x' is not a finite number"));
  EXPECT_THAT(Read(TextMesh("0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2.5\n")),
              StatusIs(kRefused, "a.ply: line 14: '2.5' is not an integer"));
}

TEST(ReadPly, RefusesFacesOfTwoCorners) {
  EXPECT_THAT(Read(TextMesh("0 0 0\n1 0 0\n1 1 0\n0 1 0\n2 0 1\n")),
              StatusIs(kRefused, "a.ply: line 14: face 0 has 2 corners"));
}

TEST(ReadPly, RefusesWhatIsLeftOver) {
  EXPECT_THAT(Read(TextMesh("0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n3 0 1 2\n")),
              StatusIs(kRefused, "a.ply: line 15: more rows than the header announces"));
  const std::string bytes =
      Header("binary_little_endian", absl::StrCat("element vertex 1\n", kXyz)) +
      Bytes(Order::kLittle, 0.F, 0.F, 0.F);
  EXPECT_THAT(Read(bytes + "\r\n"), IsOk());
  EXPECT_THAT(Read(bytes + "abcd"), StatusIs(kRefused, "4 bytes after the last value"));
}

TEST(ReadPly, RefusesEveryTruncation) {
  const std::string text = TextMesh("0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n");
  for (size_t size = 0; size + 2 < text.size(); ++size) {
    EXPECT_THAT(Read(text.substr(0, size)), StatusIs(kRefused, "a.ply: ")) << size;
  }
  const std::string binary =
      Header("binary_little_endian",
             absl::StrCat("element vertex 3\n", kXyz, "element face 1\n", kCorners)) +
      Bytes(Order::kLittle, 0.F, 0.F, 0.F, 1.F, 0.F, 0.F, 0.F, 1.F, 0.F, uint8_t{3}, 0, 1, 2);
  for (size_t size = 0; size < binary.size(); ++size) {
    EXPECT_THAT(Read(binary.substr(0, size)), StatusIs(kRefused, "a.ply: ")) << size;
  }
}

TEST(ReadPly, RefusesTriangleStrips) {
  EXPECT_THAT(Read(Header("ascii", absl::StrCat("element vertex 3\n", kXyz, "element tristrips 1\n",
                                                "property list int int vertex_indices\n")) +
                   "0 0 0\n1 0 0\n0 1 0\n4 0 1 2 -1\n"),
              StatusIs(kRefused, "a.ply: triangle strips"));
}

struct BadHeader {
  const char* name;
  const char* header;
  const char* reason;
};

class ReadPlyHeaderRefuses : public ::testing::TestWithParam<BadHeader> {};

TEST_P(ReadPlyHeaderRefuses, WithAReason) {
  EXPECT_THAT(Read(GetParam().header), StatusIs(kRefused, GetParam().reason));
}

INSTANTIATE_TEST_SUITE_P(
    Headers,
    ReadPlyHeaderRefuses,
    ::testing::Values(
        BadHeader{"Empty", "", "a.ply: line 1: a PLY file begins with the line 'ply'"},
        BadHeader{"OtherMagic", "plyx\n", "a.ply: line 1: a PLY file begins with"},
        BadHeader{"NoEnd", "ply\nformat ascii 1.0\n", "the file ends before 'end_header'"},
        BadHeader{"NoFormat", "ply\nend_header\n", "the header has no 'format'"},
        BadHeader{"OddFormat", "ply\nformat utf8 1.0\n", "line 2: 'utf8' is no PLY format"},
        BadHeader{"Version", "ply\nformat ascii 2.0\n", "PLY version '2.0'"},
        BadHeader{"Keyword", "ply\nhello\n", "line 2: 'hello' is no PLY header keyword"},
        BadHeader{"Count", "ply\nformat ascii 1.0\nelement vertex -1\n", "'-1' is no count"},
        BadHeader{"Count2", "ply\nformat ascii 1.0\nelement vertex 1e3\n", "'1e3' is no count"},
        BadHeader{"Twice", "ply\nelement a 1\nelement a 1\n", "line 3: element 'a' is there twice"},
        BadHeader{"PropertyTwice", "ply\nelement a 1\nproperty int b\nproperty int b\n",
                  "line 4: property 'b' is there twice"},
        BadHeader{"NoElement", "ply\nproperty int b\n", "a property before the first element"},
        BadHeader{"Type", "ply\nelement a 1\nproperty real b\n", "'real' is no PLY type"},
        BadHeader{"ListLength", "ply\nelement a 1\nproperty list float int b\n",
                  "'float' is no type for the length of a list"},
        BadHeader{"NoName", "ply\nelement a 1\nproperty int\n", "a property without a name"},
        BadHeader{"NoVertices", "ply\nformat ascii 1.0\nend_header\n", "announces no vertices"},
        BadHeader{"NoZ",
                  "ply\nformat ascii 1.0\nelement vertex 1\nproperty int x\nproperty int y\n"
                  "end_header\n1 2\n",
                  "the PLY vertices have no number z"},
        BadHeader{"FacesWithoutCorners",
                  "ply\nformat ascii 1.0\nelement vertex 1\nproperty int x\nproperty int y\n"
                  "property int z\nelement face 1\nproperty int flags\nend_header\n1 2 3\n7\n",
                  "the PLY faces have no list of integers"}),
    [](const auto& param_info) { return std::string(param_info.param.name); });

}  // namespace
}  // namespace cohort
