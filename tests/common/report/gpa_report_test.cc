#include "common/report/gpa_report.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::testing::ElementsAre;

GpaReport TwoTriangles(ProcrustesSize size) {
  GpaReport report;
  report.options.size = size;
  LandmarkSet small = {{"a", "b", "c"}, Eigen::Matrix3Xd::Zero(3, 3)};
  small.points.row(0) << 0, 3, 0;
  small.points.row(1) << 0, 0, 3;
  LandmarkSet large = small;
  large.points *= 2;
  const std::vector<LandmarkSet> sets = {small, large};
  report.sets = {{.name = "a,1.ply", .file = "x.csv", .landmarks = 3},
                 {.name = "b.ply", .file = "x.csv", .landmarks = 5}};
  report.analysis = *AnalyzeProcrustes(sets, report.options);
  report.left_out = {"d"};
  return report;
}

TEST(GpaSetsCsv, HasSizesAndDistances) {
  // Centroid size of the small triangle: sqrt(2 + 5 + 5) = 3.4641...; the mean has 1.5 its size.
  const std::string csv = GpaSetsCsv(TwoTriangles(ProcrustesSize::kKept));
  EXPECT_THAT(csv, ::testing::StartsWith("file,landmarks,centroid_size,distance_to_mean\r\n"
                                         "\"a,1.ply\",3,3.46410161513775"));
  EXPECT_THAT(csv, ::testing::HasSubstr("\r\nb.ply,5,6.9282032302755"));
}

TEST(GpaMatrix, HoldsTheDistancesOfTheNamedSets) {
  const MetricMatrix kept = GpaMatrix(TwoTriangles(ProcrustesSize::kKept));
  EXPECT_THAT(kept.labels, ElementsAre("a,1.ply", "b.ply"));
  EXPECT_NEAR(kept.values(0, 1), std::sqrt(12), 1e-12);
  EXPECT_NEAR(GpaMatrix(TwoTriangles(ProcrustesSize::kNormalized)).values(0, 1), 0, 1e-12);
}

TEST(DescribeGpa, SaysWhatSizesAre) {
  EXPECT_EQ(DescribeGpa(TwoTriangles(ProcrustesSize::kKept)).unit, "mm");
  EXPECT_EQ(DescribeGpa(TwoTriangles(ProcrustesSize::kKept)).subtitle,
            "3 landmarks, sizes kept (form)");
  EXPECT_EQ(DescribeGpa(TwoTriangles(ProcrustesSize::kNormalized)).unit, "");
}

TEST(GpaJson, SaysWhatWasComputedFromWhat) {
  const std::vector<GpaInput> inputs = {{.name = "x.csv", .sha256 = Sha256::Of("x")}};
  const std::vector<ResultFile> files = {{"matrix.csv", "all", "mm"}};
  const GpaReport report = TwoTriangles(ProcrustesSize::kKept);
  const std::string text = GpaJson(report, inputs, files, "cohort 1");
  const auto json = nlohmann::json::parse(text);
  EXPECT_EQ(json["method"], "gpa");
  EXPECT_EQ(json["parameters"]["size"], "kept");
  EXPECT_EQ(json["parameters"]["variant"], "exact");
  EXPECT_EQ(json["landmarks_left_out"], nlohmann::json({"d"}));
  EXPECT_EQ(json["inputs"][0]["sha256"], Sha256::Of("x").Hex());
  EXPECT_TRUE(json["converged"]);
  EXPECT_EQ(text, GpaJson(report, inputs, files, "cohort 1"));
}

}  // namespace
}  // namespace cohort
