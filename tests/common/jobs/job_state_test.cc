#include "common/jobs/job_state.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::cohort::testing::IsOk;
using ::cohort::testing::StatusIs;
using nlohmann::json;

JobOutputs SomeOutputs() {
  JobOutputs outputs;
  outputs.tiles = {Sha256::Of("t1"), Sha256::Of("t0")};
  outputs.alignments = {Sha256::Of("a")};
  outputs.mean_shape = Sha256::Of("m");
  outputs.variation_shape = Sha256::Of("v");
  return outputs;
}

TEST(JobOutputsJson, RoundTrips) {
  const auto outputs = JobOutputsFromJson(json::parse(ToJson(SomeOutputs()).dump()));
  ASSERT_THAT(outputs, IsOk());
  EXPECT_EQ(outputs->tiles, SomeOutputs().tiles);
  EXPECT_EQ(outputs->alignments, SomeOutputs().alignments);
  EXPECT_EQ(outputs->mean_shape, SomeOutputs().mean_shape);
  EXPECT_EQ(outputs->variation_shape, SomeOutputs().variation_shape);
  EXPECT_TRUE(outputs->summary.empty());
}

TEST(JobOutputsJson, OfAnOlderCatalogHasTheMeanShapeOnly) {
  json older = ToJson(SomeOutputs());
  older.erase("variation_shape");
  const auto outputs = JobOutputsFromJson(older);
  ASSERT_THAT(outputs, IsOk());
  EXPECT_TRUE(outputs->variation_shape.empty());
  EXPECT_THAT(JobOutputsFromJson(json::object()), IsOk());
}

TEST(JobOutputsJson, IsRefusedByField) {
  json damaged = ToJson(SomeOutputs());
  damaged["tiles"][1] = "xyz";
  EXPECT_THAT(JobOutputsFromJson(damaged),
              StatusIs(absl::StatusCode::kDataLoss, "job outputs.tiles: expected digests"));
  damaged = ToJson(SomeOutputs());
  damaged["new"] = 1;
  EXPECT_THAT(JobOutputsFromJson(damaged),
              StatusIs(absl::StatusCode::kDataLoss, "job outputs.new: unknown field"));
}

TEST(JobState, NamesAreTheInverseOfEachOther) {
  for (const JobState state : {JobState::kQueued, JobState::kRunning, JobState::kSucceeded,
                               JobState::kFailed, JobState::kCancelled}) {
    EXPECT_EQ(JobStateFromName(JobStateName(state)), state);
  }
  EXPECT_EQ(JobStateName(JobState::kCancelled), "cancelled");
  EXPECT_EQ(JobStateFromName("done"), std::nullopt);
}

TEST(JobState, OnlyThreeAreFinal) {
  EXPECT_FALSE(IsFinal(JobState::kQueued));
  EXPECT_FALSE(IsFinal(JobState::kRunning));
  EXPECT_TRUE(IsFinal(JobState::kSucceeded));
  EXPECT_TRUE(IsFinal(JobState::kFailed));
  EXPECT_TRUE(IsFinal(JobState::kCancelled));
}

}  // namespace
}  // namespace cohort
