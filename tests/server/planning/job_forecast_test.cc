#include "server/planning/job_forecast.h"

#include <gmock/gmock.h>

#include "tests/server/planning/fake_job.h"

namespace cohort {
namespace {

using ::cohort::testing::FakeJob;
using ::cohort::testing::SpecOf;

int64_t TasksOf(const JobForecast& forecast) {
  int64_t tasks = 0;
  for (const StageForecast& stage : forecast.stages) {
    tasks += stage.tasks;
  }
  return tasks;
}

double CostOf(const JobForecast& forecast) {
  double cost = 0;
  for (const StageForecast& stage : forecast.stages) {
    cost += stage.cost;
  }
  return cost;
}

TEST(JobForecast, IsWhatTheProgressAnnouncesAndShrinksWithEveryTask) {
  FakeJob job(5);
  const auto plan = job.Plan(SpecOf(Method::kAverage, PoseMode::kPrincipalAxes, 2));
  while (!plan->Done()) {
    const Progress progress = plan->CurrentProgress();
    const JobForecast forecast = plan->Forecast();
    ASSERT_EQ(TasksOf(forecast), progress.tasks_total - progress.tasks_done);
    ASSERT_NEAR(CostOf(forecast), progress.cost_total - progress.cost_done,
                1e-9 * progress.cost_total);
    for (const Task& task : plan->TakeReadyTasks()) {
      EXPECT_EQ(plan->CostOf(task.number), task.cost);
      ASSERT_THAT(plan->TaskFinished(task.number, job.ResultOf(task)), testing::IsOk());
    }
  }
  EXPECT_TRUE(plan->Forecast().stages.empty());
}

TEST(JobForecast, NamesTheMostExpensiveTaskOfAStage) {
  FakeJob job(3);
  const JobForecast forecast = job.Plan(SpecOf(Method::kNone, PoseMode::kNone, 1))->Forecast();
  ASSERT_EQ(forecast.stages.front().name, "ingest");
  EXPECT_EQ(forecast.stages.front().tasks, 3);
  EXPECT_DOUBLE_EQ(forecast.stages.front().longest, forecast.stages.front().cost / 3);
}

TEST(JobForecast, CountsDirectedPairsAndTheBytesOfEachRetention) {
  FakeJob job(4);
  JobSpec spec = SpecOf(Method::kNone, PoseMode::kNone, 1);
  spec.compare.retention = Retention::kCompact;
  const JobForecast forecast = job.Plan(spec)->Forecast();
  EXPECT_EQ(forecast.meshes, 4);
  EXPECT_EQ(forecast.pairs, 12);
  EXPECT_EQ(forecast.retention, Retention::kCompact);
  // Files of 42 MB, at 60 bytes a vertex: 0.7 million vertices, each to 4 meshes.
  EXPECT_DOUBLE_EQ(forecast.distance_bytes.at(Retention::kVectors), 4 * 4 * 7e5 * 3.3);
  EXPECT_DOUBLE_EQ(forecast.distance_bytes.at(Retention::kCompact), 4 * 4 * 7e5 * 1.7);
  EXPECT_EQ(forecast.distance_bytes.at(Retention::kMetrics), 0);
  EXPECT_GT(forecast.other_bytes, 4 * 7e5) << "at least the meshes themselves";
  // Automatic: the richest within the budget.
  spec.compare.retention = Retention::kAuto;
  spec.retention_budget = 20'000'000;
  EXPECT_EQ(job.Plan(spec)->Forecast().retention, Retention::kCompact);
}

}  // namespace
}  // namespace cohort
