#include <string>
#include <vector>

#include <absl/strings/str_join.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/sha256.h"
#include "common/jobs/fidentis_spec.h"
#include "tests/server/planning/fake_job.h"

namespace cohort {
namespace {

using ::testing::ElementsAre;
using testing::FakeJob;
using testing::SpecOf;

/// Names all tasks of a job: their numbers, meshes and inputs.
std::string TasksOf(const JobSpec& spec, int meshes, int64_t vertices) {
  FakeJob job(meshes);
  job.vertices = vertices;
  const auto plan = job.Plan(spec);
  return Sha256::Of(absl::StrJoin(job.RunAll(*plan), "\n")).Hex().substr(0, 16);
}

// If this fails, jobs have other tasks than before, or other numbers for them. If that is meant to
// be so, add one to kPlanVersion (server/planning/job_plan.h), so that a job that an earlier build
// began is started over instead of going on with results of other tasks, and write the new names
// here.
TEST(PlanVersion, GrowsWheneverTasksOrTheirNumbersChange) {
  EXPECT_EQ(kPlanVersion, 3);
  JobSpec average = SpecOf(Method::kAverage);
  average.preview = true;
  JobSpec symmetric = SpecOf(Method::kOne);
  symmetric.symmetric_copies = true;
  JobSpec chosen = SpecOf(Method::kOne);
  chosen.base_rule = BaseRule::kAuto;
  const std::vector<std::string> tasks = {
      TasksOf(average, 3, 700000),
      TasksOf(average, 90, 700000),
      TasksOf(average, 200, 5000),
      TasksOf(symmetric, 40, 20000),
      TasksOf(chosen, 40, 20000),
      TasksOf(SpecOf(Method::kEach), 20, 20000),
      TasksOf(SpecOf(Method::kNone), 60, 20000),
      TasksOf(FidentisSpec(Method::kAverage), 20, 20000),
  };
  EXPECT_THAT(tasks, ElementsAre("3b20fb4acd5711e1", "ddee0f004383b115", "0d4e259239fdbf1d",
                                 "78d20bdcad58417f", "dde5cd74e04a9314", "9b4371b651c38bb8",
                                 "8a759485b86c56e8", "d3debe74b625f30d"));
}

}  // namespace
}  // namespace cohort
