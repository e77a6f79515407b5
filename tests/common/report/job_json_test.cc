#include "common/report/job_json.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace cohort {
namespace {

using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;
using Json = nlohmann::ordered_json;

JobJsonInput Example() {
  JobJsonInput input;
  input.software_version = "cohort 0.1.0";
  input.host = "lab-1";
  input.job.id = {"j-000012"};
  input.job.set = "brno-2016";
  input.job.state = JobState::kSucceeded;
  input.job.created_unix_ms = 1772368496000;  // 2026-03-01T12:34:56Z
  input.job.started_unix_ms = 1772368496789;
  input.job.finished_unix_ms = 1772368500039;
  input.job.counters.pose = {1, 10};
  input.job.counters.align = {2, 20};
  input.job.counters.average = {4, 40};
  input.job.counters.compare = {8, 80};
  input.job.counters.variation = {16, 160};
  input.job.counters.pairs = 12;
  input.files = {{"matrix.csv", "RMS distance of all pairs", "mm"}};
  JobMesh accepted;
  accepted.mesh.name = "a.ply";
  accepted.mesh.raw = Sha256::Of("a");
  accepted.mesh.size_bytes = 5;
  accepted.mesh.labels = {{"person", "1"}};
  JobMesh rejected;
  rejected.mesh.name = "b.ply";
  rejected.rejection = "no faces";
  input.meshes = {accepted, rejected};
  return input;
}

std::vector<std::string> Keys(const Json& json) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : json.items()) keys.push_back(key);
  return keys;
}

TEST(JobJson, HasItsKeysInAFixedOrder) {
  const std::string text = JobJson(Example());
  EXPECT_THAT(text, StartsWith("{\n  \"software\": \"cohort 0.1.0\",\n  \"job\": \"j-000012\",\n"));
  EXPECT_THAT(text, EndsWith("\n}\n"));
  EXPECT_THAT(Keys(Json::parse(text)), ElementsAre("software", "job", "set", "state", "parameters",
                                                   "files", "counters", "totals", "meshes", "run"));
}

TEST(JobJson, KeepsEverythingThatDiffersBetweenRunsInRun) {
  JobJsonInput other = Example();
  other.host = "elsewhere";
  other.job.created_unix_ms += 1000;
  other.job.started_unix_ms += 5000;
  other.job.finished_unix_ms += 9000;
  other.job.version = 99;
  Json a = Json::parse(JobJson(Example()));
  Json b = Json::parse(JobJson(other));
  EXPECT_NE(a["run"], b["run"]);
  a.erase("run");
  b.erase("run");
  EXPECT_EQ(a, b);
}

TEST(JobJson, StatesTimesInUtcAndSeconds) {
  JobJsonInput input = Example();
  input.job.progress.stages = {{"ingest", 1000, 1250}, {"compare", 1300, 3800}};
  const Json run = Json::parse(JobJson(input))["run"];
  EXPECT_EQ(run,
            Json({{"host", "lab-1"},
                  {"created", "2026-03-01T12:34:56.000Z"},
                  {"started", "2026-03-01T12:34:56.789Z"},
                  {"finished", "2026-03-01T12:35:00.039Z"},
                  {"seconds", 3.25},
                  {"stages", {{"ingest", {{"seconds", 0.25}}}, {"compare", {{"seconds", 2.5}}}}}}));
}

TEST(JobJson, HasNullForWhatDidNotHappen) {
  JobJsonInput input = Example();
  input.job.finished_unix_ms = 0;
  const Json run = Json::parse(JobJson(input))["run"];
  EXPECT_TRUE(run["finished"].is_null());
  EXPECT_TRUE(run["seconds"].is_null());
}

TEST(JobJson, SumsTheCountersAsTheThesisDoes) {
  const Json json = Json::parse(JobJson(Example()));
  EXPECT_EQ(json["totals"]["align_and_average"], Json({{"index_builds", 6}, {"lookups", 60}}));
  EXPECT_EQ(json["totals"]["all_stages"], Json({{"index_builds", 31}, {"lookups", 310}}));
  EXPECT_EQ(json["totals"]["directed_pairs"], 12);
}

TEST(JobJson, TellsWhatBecameOfEachMesh) {
  const Json meshes = Json::parse(JobJson(Example()))["meshes"];
  EXPECT_EQ(meshes[0], Json({{"name", "a.ply"},
                             {"sha256", Sha256::Of("a").Hex()},
                             {"size_bytes", 5},
                             {"labels", {{"person", "1"}}},
                             {"status", "ok"}}));
  EXPECT_EQ(meshes[1]["status"], "rejected");
  EXPECT_EQ(meshes[1]["reason"], "no faces");
  EXPECT_EQ(meshes[1]["labels"], Json::object());
}

TEST(JobJson, KeepsTheParametersReadable) {
  JobJsonInput input = Example();
  input.job.spec.rounds = 7;
  input.job.spec.base = "a.ply";
  const absl::StatusOr<JobSpec> spec =
      JobSpecFromJson(nlohmann::json::parse(JobJson(input))["parameters"]);
  ASSERT_TRUE(spec.ok()) << spec.status();
  EXPECT_EQ(spec->rounds, 7);
  EXPECT_EQ(spec->base, "a.ply");
}

TEST(JobJson, SurvivesFileNamesThatAreNotUtf8) {
  JobJsonInput input = Example();
  input.meshes[0].mesh.name = "sm\xf8rre \"x\".ply";
  const Json json = Json::parse(JobJson(input));
  EXPECT_EQ(json["meshes"][0]["name"], "sm\uFFFDrre \"x\".ply");
}

TEST(JobJson, HasAnErrorOnlyIfThereIsOne) {
  JobJsonInput input = Example();
  EXPECT_THAT(JobJson(input), Not(HasSubstr("\"error\"")));
  input.job.error = "all meshes were rejected";
  EXPECT_EQ(Json::parse(JobJson(input))["error"], "all meshes were rejected");
}

TEST(JobJson, HasNotesOnlyIfThereAreSome) {
  JobJsonInput input = Example();
  EXPECT_THAT(JobJson(input), Not(HasSubstr("\"notes\"")));
  input.notes = {"one", "two"};
  EXPECT_EQ(Json::parse(JobJson(input))["notes"], Json({"one", "two"}));
}

TEST(Iso8601Utc, KnowsLeapDaysAndTheEpoch) {
  EXPECT_EQ(Iso8601Utc(0), "1970-01-01T00:00:00.000Z");
  EXPECT_EQ(Iso8601Utc(1709208000001), "2024-02-29T12:00:00.001Z");
}

}  // namespace
}  // namespace cohort
