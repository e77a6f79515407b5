#include "common/report/variation_ply.h"

#include <cstring>

#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>

#include "common/geometry/io/write_mesh.h"
#include "common/report/color_map.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::testing::HasSubstr;
using testing::IsOk;
using testing::StatusIs;

constexpr int kVertices = 101;

TriangleMesh Strip() {
  TriangleMesh mesh;
  mesh.vertices.resize(3, kVertices);
  for (int i = 0; i < kVertices; ++i) mesh.vertices.col(i) << i, i % 2, 0.5;
  mesh.faces.resize(3, 1);
  mesh.faces << 0, 1, 2;
  return mesh;
}

// Vertex i has the RMS distance i.
VariationSummary Ramp() {
  VariationSummary summary;
  summary.mesh_count = 5;
  for (int i = 0; i < kVertices; ++i) {
    MetricValues values = {};
    for (size_t metric = 0; metric < values.size(); ++metric) {
      values[metric] = i + 1000.0 * static_cast<double>(metric);
    }
    summary.values.push_back(values);
  }
  return summary;
}

// Bytes of vertex `index` of a PLY of x y z, seven metrics, three colours.
std::string_view VertexBytes(const std::string& ply, size_t index) {
  const size_t begin = ply.find("end_header\n") + 11;
  return std::string_view(ply).substr(begin + index * 43, 43);
}
float FloatAt(std::string_view bytes, size_t index) {
  float value = 0;
  std::memcpy(&value, bytes.data() + 4 * index, sizeof value);
  return value;
}
Rgb ColorOf(std::string_view bytes) {
  return {static_cast<uint8_t>(bytes[40]), static_cast<uint8_t>(bytes[41]),
          static_cast<uint8_t>(bytes[42])};
}

TEST(VariationPly, HasOnePropertyPerMetricThenTheColour) {
  const absl::StatusOr<std::string> ply = VariationPly(Strip(), Ramp());
  ASSERT_THAT(ply, IsOk());
  EXPECT_THAT(*ply,
              HasSubstr("property float rms\nproperty float mean\nproperty float geometric_mean\n"
                        "property float min\nproperty float max\nproperty float variance\n"
                        "property float p75\nproperty uchar red\n"));
}

TEST(VariationPly, HoldsEachVertexItsMetricsAndItsColour) {
  const absl::StatusOr<std::string> ply = VariationPly(Strip(), Ramp());
  ASSERT_THAT(ply, IsOk());
  const std::string_view vertex = VertexBytes(*ply, 50);
  EXPECT_EQ(FloatAt(vertex, 0), 50);    // x
  EXPECT_EQ(FloatAt(vertex, 3), 50);    // rms
  EXPECT_EQ(FloatAt(vertex, 9), 6050);  // p75
  EXPECT_EQ(ColorOf(vertex), MapColor(0.5));
}

TEST(VariationPly, EndsItsColoursAtTheSecondAndNinetyEighthPercentile) {
  const ValueRange range = VariationColorRange(Ramp());
  EXPECT_EQ(range.low, 2);
  EXPECT_EQ(range.high, 98);
  const absl::StatusOr<std::string> ply = VariationPly(Strip(), Ramp());
  ASSERT_THAT(ply, IsOk());
  EXPECT_EQ(ColorOf(VertexBytes(*ply, 0)), MapColor(0));
  EXPECT_EQ(ColorOf(VertexBytes(*ply, 2)), MapColor(0));
  EXPECT_EQ(ColorOf(VertexBytes(*ply, 98)), MapColor(1));
  EXPECT_EQ(ColorOf(VertexBytes(*ply, 100)), MapColor(1));
}

TEST(VariationPly, RefusesASummaryOfAnotherMesh) {
  VariationSummary summary = Ramp();
  summary.values.pop_back();
  EXPECT_THAT(VariationPly(Strip(), summary),
              StatusIs(absl::StatusCode::kInvalidArgument, "100 vertices for a mean shape of 101"));
}

TEST(VariationVtk, HasTheSameScalars) {
  const absl::StatusOr<std::string> vtk = VariationVtk(Strip(), Ramp());
  ASSERT_THAT(vtk, IsOk());
  for (const char* name : {"rms", "mean", "geometric_mean", "min", "max", "variance", "p75"}) {
    EXPECT_THAT(*vtk, HasSubstr(absl::StrCat("\nSCALARS ", name, " float 1\n")));
  }
  VariationSummary summary = Ramp();
  summary.values.pop_back();
  EXPECT_THAT(VariationVtk(Strip(), summary),
              StatusIs(absl::StatusCode::kInvalidArgument, "100 vertices"));
}

TEST(MeanShapePly, IsTheMeshAlone) {
  EXPECT_EQ(MeanShapePly(Strip()), WritePly(Strip()));
}

}  // namespace
}  // namespace cohort
