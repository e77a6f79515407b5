#include "common/jobs/task.h"

#include <cmath>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::cohort::testing::IsOk;
using ::cohort::testing::StatusIs;
using nlohmann::json;

Counters SomeCounters() {
  Counters counters;
  counters.pose = {1, 2};
  counters.align = {3, int64_t{1} << 60};
  counters.average = {5, 6};
  counters.compare = {7, 8};
  counters.variation = {9, 10};
  counters.pairs = 11;
  return counters;
}

TaskResult SomeResult() {
  TaskResult result;
  result.output = Sha256::Of("one");
  result.alignments = std::string("\0alignments\xff\n", 13);
  result.second_output = Sha256::Of("two");
  result.poses = Sha256::Of("poses");
  result.variation = Sha256::Of("variation");
  result.placed = Sha256::Of("three");
  IngestedMesh& mesh = result.ingested.emplace_back();
  mesh.index = 4;
  mesh.blob = Sha256::Of("mesh");
  mesh.vertices = 50000;
  mesh.faces = 100000;
  mesh.centroid = {0.1 + 0.2, -0.0, 1e-310};
  mesh.health = {.vertices = 50001,
                 .faces = 100002,
                 .duplicate_vertices = 1,
                 .unreferenced_vertices = 2,
                 .degenerate_faces = 3,
                 .duplicate_faces = 4,
                 .non_manifold_edges = 5,
                 .components = 6,
                 .largest_component_share = 1.0 / 3,
                 .boundary_share = 2.0 / 3,
                 .diagonal = 1.0 / 7,
                 .rms_radius = 80.1,
                 .surface_area = 1e5 / 9,
                 .point_cloud = true,
                 .warnings = {"a", "b \n c"}};
  result.copies = {{6, Sha256::Of("copy"), 0.1 + 0.2}};
  result.rejections = {{5, "x.ply: line 3: not a number"}};
  result.counters = SomeCounters();
  result.seconds = std::nextafter(1.5, 2.0);
  return result;
}

TEST(TaskResultJson, RoundTripsThroughTextWithoutLosingABit) {
  const TaskResult expected = SomeResult();
  const auto result = TaskResultFromJson(json::parse(ToJson(expected).dump()));
  ASSERT_THAT(result, IsOk());
  EXPECT_EQ(result->output, expected.output);
  EXPECT_EQ(result->alignments, expected.alignments);
  EXPECT_EQ(result->second_output, expected.second_output);
  EXPECT_EQ(result->poses, expected.poses);
  EXPECT_EQ(result->variation, expected.variation);
  EXPECT_EQ(result->placed, expected.placed);
  EXPECT_EQ(result->copies, expected.copies);
  EXPECT_EQ(result->rejections, expected.rejections);
  EXPECT_EQ(result->counters, expected.counters);
  EXPECT_EQ(result->seconds, std::nextafter(1.5, 2.0));
  ASSERT_EQ(result->ingested.size(), 1u);
  EXPECT_EQ(result->ingested[0].index, 4);
  EXPECT_EQ(result->ingested[0].blob, Sha256::Of("mesh"));
  EXPECT_EQ(result->ingested[0].vertices, 50000);
  EXPECT_EQ(result->ingested[0].faces, 100000);
  EXPECT_EQ(result->ingested[0].centroid, expected.ingested[0].centroid);
  EXPECT_TRUE(std::signbit(result->ingested[0].centroid[1]));
  EXPECT_EQ(ToJson(result->ingested[0].health), ToJson(expected.ingested[0].health));
  EXPECT_EQ(result->ingested[0].health.largest_component_share, 1.0 / 3);
  EXPECT_EQ(result->ingested[0].health.warnings, (std::vector<std::string>{"a", "b \n c"}));
  EXPECT_TRUE(result->ingested[0].health.point_cloud);
}

TEST(TaskResultJson, OfAnOlderCatalogHasNoPlacedMeshesNorAlignments) {
  json older = ToJson(SomeResult());
  older.erase("placed");
  older.erase("alignments");
  const auto result = TaskResultFromJson(older);
  ASSERT_THAT(result, IsOk());
  EXPECT_TRUE(result->placed.empty());
  EXPECT_TRUE(result->alignments.empty());
}

TEST(TaskResultJson, KeepsAnEmptyResult) {
  const auto result = TaskResultFromJson(ToJson(TaskResult()));
  ASSERT_THAT(result, IsOk());
  EXPECT_TRUE(result->output.empty());
  EXPECT_EQ(ToJson(*result), ToJson(TaskResult()));
}

struct Damage {
  std::string path;
  std::string value;
  std::string message;
};
class DamagedResult : public ::testing::TestWithParam<Damage> {};

TEST_P(DamagedResult, IsRefusedByField) {
  json damaged = ToJson(SomeResult());
  const json::json_pointer path(GetParam().path);
  damaged[path] = json::parse(GetParam().value);
  EXPECT_THAT(TaskResultFromJson(damaged),
              StatusIs(absl::StatusCode::kDataLoss, GetParam().message));
}

INSTANTIATE_TEST_SUITE_P(
    Table,
    DamagedResult,
    ::testing::Values(
        Damage{"/output", "\"abc\"", "task result.output: expected a digest, not \"abc\""},
        Damage{"/output", "7", "task result.output: expected a digest, not 7"},
        Damage{"/alignments", "7", "task result.alignments: expected base64, not 7"},
        Damage{"/alignments", "\"a?\"", "task result.alignments: expected base64, not \"a?\""},
        Damage{"/placed", "7", "task result.placed: expected a digest, not 7"},
        Damage{"/seconds", "\"1\"", "task result.seconds: expected a number"},
        Damage{"/seconds", "null", "task result.seconds: expected a number, not null"},
        Damage{"/counters", "[]", "task result.counters: expected an object"},
        Damage{"/counters/align/lookups", "1.5", "task result.counters.align.lookups: expected an"},
        Damage{"/ingested", "{}", "task result.ingested: expected an array"},
        Damage{"/ingested/0", "1", "task result.ingested[0]: expected an object"},
        Damage{"/ingested/0/index", "4294967296", "task result.ingested[0].index: expected an"},
        Damage{"/ingested/0/centroid", "[1,2]", "task result.ingested[0].centroid: expected three"},
        Damage{"/ingested/0/centroid/1", "\"\"", "task result.ingested[0].centroid: expected"},
        Damage{"/ingested/0/health/warnings", "[1]", "health.warnings: expected an array of str"},
        Damage{"/ingested/0/health/point_cloud", "1", "health.point_cloud: expected true or false"},
        Damage{"/rejections/0/extra", "1", "task result.rejections[0].extra: unknown field"}));

TEST(TaskResultJson, OfAnOlderBuildTakesTheDefaultOfAFieldItDidNotHave) {
  json older = ToJson(SomeResult());
  for (const char* path : {"/output", "/counters/pairs", "/rejections/0/reason", "/copies"}) {
    const json::json_pointer pointer(path);
    older[pointer.parent_pointer()].erase(pointer.back());
  }
  const auto result = TaskResultFromJson(older);
  ASSERT_THAT(result, IsOk());
  TaskResult expected = SomeResult();
  expected.output = Digest();
  expected.counters.pairs = 0;
  expected.rejections[0].reason.clear();
  expected.copies.clear();
  EXPECT_EQ(ToJson(*result), ToJson(expected));
  EXPECT_EQ(ToJson(TaskResultFromJson(json::object()).value()), ToJson(TaskResult()));
}

TEST(TaskResultJson, IsRefusedWhenItIsNoObject) {
  EXPECT_THAT(TaskResultFromJson(json()), StatusIs(absl::StatusCode::kDataLoss, "not null"));
}

TEST(Counters, AddFieldByField) {
  Counters sum = SomeCounters();
  sum += SomeCounters();
  Counters expected;
  expected.pose = {2, 4};
  expected.align = {6, int64_t{1} << 61};
  expected.average = {10, 12};
  expected.compare = {14, 16};
  expected.variation = {18, 20};
  expected.pairs = 22;
  EXPECT_EQ(sum, expected);
}

TEST(TaskKindName, NamesEveryKind) {
  EXPECT_EQ(TaskKindName(TaskKind::kIngest), "ingest");
  EXPECT_EQ(TaskKindName(TaskKind::kPose), "pose");
  EXPECT_EQ(TaskKindName(TaskKind::kAlign), "align");
  EXPECT_EQ(TaskKindName(TaskKind::kAverage), "average");
  EXPECT_EQ(TaskKindName(TaskKind::kCompare), "compare");
  EXPECT_EQ(TaskKindName(TaskKind::kAlignAndCompare), "align-and-compare");
  EXPECT_EQ(TaskKindName(TaskKind::kVariation), "variation");
  EXPECT_EQ(TaskKindName(TaskKind::kSummarize), "summarize");
}

}  // namespace
}  // namespace cohort
