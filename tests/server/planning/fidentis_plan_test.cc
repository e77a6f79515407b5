// Jobs with the predecessor's arithmetic, written down task by task.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/jobs/fidentis_spec.h"
#include "server/planning/job_plan.h"
#include "tests/server/planning/fake_job.h"

namespace cohort {
namespace {

using ::cohort::testing::FakeJob;
using ::cohort::testing::IsOk;
using ::cohort::testing::StatusIs;
using ::testing::ElementsAre;

TEST(FidentisPlan, AverageGoesOnFromWhereTheMeshesWereMoved) {
  FakeJob job(2);
  job.vertices = 10000000;  // So that tiles are of one mesh.
  JobSpec spec = FidentisSpec(Method::kAverage);
  spec.rounds = 1;
  spec.base = "b.ply";
  const auto plan = job.Plan(spec);
  EXPECT_THAT(
      job.RunAll(*plan),
      ElementsAre("0 ingest: a raw", "1 ingest: b raw", "--",
                  "2 align 1: a | to b | fidentis, placed, counts index",
                  "3 align 1: b | to b | fidentis, placed", "--",
                  "4 average 1: | to b | of align 1#2@ align 1#3@ | fidentis", "--",
                  "5 align 2: a | to average 1#4 | from align 1#2 | of align 1#2@ | fidentis, "
                  "placed, counts index",
                  "6 align 2: b | to average 1#4 | from align 1#3 | of align 1#3@ | fidentis, "
                  "placed",
                  "--",
                  "7 compare: a x b | from align 2#5 align 2#6 | of align 2#5@ align 2#6@ | "
                  "fidentis",
                  "8 compare: a x a | from align 2#5 | of align 2#5@ | fidentis",
                  "9 compare: b x b | from align 2#6 | of align 2#6@ | fidentis",
                  "10 summarize: x b | of align 2#5@ align 2#6@ | fidentis"));
  const JobOutputs& outputs = plan->Outputs();
  EXPECT_EQ(job.NameOf(outputs.mean_shape), "average 1#4");
  EXPECT_EQ(job.NameOf(outputs.variation_shape), "summarize#10+");
  EXPECT_EQ(job.NameOf(outputs.summary), "summarize#10");
  EXPECT_EQ(job.NamesOf(outputs.alignments), "align 2#5 align 2#6");
  EXPECT_EQ(job.NamesOf(outputs.tiles), "compare#7 compare#8 compare#9");
}

TEST(FidentisPlan, OneHasNoMeanShapeButTheSurfaceOfItsMap) {
  FakeJob job(2);
  const auto plan = job.Plan(FidentisSpec(Method::kOne), job.AllIndices());
  EXPECT_THAT(job.RunReady(*plan), ElementsAre("2 align: a | to a | fidentis, placed, counts index",
                                               "3 align: b | to a | fidentis, placed"));
  (void)job.RunAll(*plan);
  EXPECT_EQ(plan->Outputs().mean_shape, plan->Outputs().variation_shape);
  EXPECT_FALSE(plan->Outputs().mean_shape.empty());
}

TEST(FidentisPlan, EachTakesItsMapFromTheColumnOfTheBase) {
  FakeJob job(3);
  JobSpec spec = FidentisSpec(Method::kEach);
  spec.base = "b.ply";
  const auto plan = job.Plan(spec, job.AllIndices());
  EXPECT_THAT(job.RunAll(*plan),
              ElementsAre("3 compare: a b c x a | fidentis, counts index",
                          "4 compare: a b c x b | fidentis, placed, counts index",
                          "5 compare: a b c x c | fidentis, counts index", "--",
                          "6 summarize: x b | of compare#4@ | fidentis"));
  EXPECT_EQ(job.NamesOf(plan->Outputs().alignments), "compare#4+");
}

TEST(FidentisPlan, CarriesTheOptions) {
  FakeJob job(2);
  JobSpec spec = FidentisSpec(Method::kOne);
  spec.icp.max_iterations = 7;
  spec.compare.sign = DistanceSign::kSigned;
  const auto plan = job.Plan(spec);
  while (!plan->Done()) {
    for (const Task& task : plan->TakeReadyTasks()) {
      if (task.kind == TaskKind::kIngest) {
        EXPECT_EQ(task.position_bits, 0);
      } else if (task.kind == TaskKind::kAlign) {
        EXPECT_EQ(task.icp.max_iterations, 7);
        EXPECT_EQ(task.icp.scale_mode, ScaleMode::kFromX);
      } else {
        EXPECT_EQ(task.compare.sign, DistanceSign::kSigned);
      }
      EXPECT_GT(task.cost, 0);
      ASSERT_THAT(plan->TaskFinished(task.number, job.ResultOf(task)), IsOk());
    }
  }
}

TEST(FidentisPlan, KeepsTheDistancesWholeOrNotAtAll) {
  for (const auto& [budget, kept] : {std::pair{int64_t{1} << 40, Retention::kVectors},
                                     std::pair{int64_t{1} << 20, Retention::kMetrics}}) {
    FakeJob job(2);
    JobSpec spec = FidentisSpec(Method::kEach);
    spec.retention_budget = budget;
    const auto plan = job.Plan(spec, job.AllIndices());
    EXPECT_EQ(plan->TakeReadyTasks().at(0).compare.retention, kept);
  }
}

TEST(FidentisPlan, GoesOnWithoutARejectedMeshButNotWithoutTheBase) {
  FakeJob job(4);
  job.RejectIn("align 2", 1);
  const auto plan = job.Plan(FidentisSpec(Method::kAverage), job.AllIndices());
  (void)job.RunAll(*plan);
  EXPECT_TRUE(plan->Done());
  FakeJob without_base(4);
  without_base.RejectIn("align 2", 0, "a.ply: it collapsed");
  const auto broken = without_base.Plan(FidentisSpec(Method::kAverage), job.AllIndices());
  without_base.RunUntil(*broken, "align 2");
  absl::Status status;
  (void)without_base.RunReady(*broken, &status);
  EXPECT_THAT(status, StatusIs(absl::StatusCode::kFailedPrecondition,
                               "the base mesh a.ply cannot be used: a.ply: it collapsed"));
}

TEST(FidentisPlan, RefusesAnAlignmentWithoutThePlacedMeshes) {
  FakeJob job(2);
  const auto plan = job.Plan(FidentisSpec(Method::kOne), job.AllIndices());
  const Task task = plan->TakeReadyTasks().at(0);
  TaskResult result = job.ResultOf(task);
  result.placed = Digest();
  EXPECT_THAT(plan->TaskFinished(task.number, result),
              StatusIs(absl::StatusCode::kInvalidArgument, "no placed meshes"));
}

}  // namespace
}  // namespace cohort
