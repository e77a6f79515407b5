// What a plan refuses, and what it does when meshes drop out.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/planning/job_plan.h"
#include "tests/server/planning/fake_job.h"

namespace cohort {
namespace {

using ::cohort::testing::FakeJob;
using ::cohort::testing::IsOk;
using ::cohort::testing::SpecOf;
using ::cohort::testing::StatusIs;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr auto kInvalid = absl::StatusCode::kInvalidArgument;
constexpr auto kFailed = absl::StatusCode::kFailedPrecondition;

// ---- Create ----

TEST(CreatePlan, RefusesABadSpec) {
  JobSpec spec;
  spec.rounds = 0;
  EXPECT_THAT(JobPlan::Create(spec, FakeJob(3).Meshes(), {}), StatusIs(kInvalid, "rounds is 0"));
}

TEST(CreatePlan, RefusesFewerThanTwoMeshes) {
  EXPECT_THAT(JobPlan::Create({}, {}, {}), StatusIs(kInvalid, "the set has 0"));
  EXPECT_THAT(JobPlan::Create({}, FakeJob(1).Meshes(), {}), StatusIs(kInvalid, "the set has 1"));
}

TEST(CreatePlan, RefusesABaseThatIsNotThere) {
  JobSpec spec;
  spec.base = "z.ply";
  EXPECT_THAT(JobPlan::Create(spec, FakeJob(3).Meshes(), {}),
              StatusIs(kInvalid, "z.ply is not among the 3 meshes (a.ply to c.ply)"));
}

TEST(CreatePlan, RefusesMeshesOutOfOrderOrTwice) {
  std::vector<SetMesh> meshes = FakeJob(3).Meshes();
  std::swap(meshes[0], meshes[1]);
  EXPECT_THAT(JobPlan::Create({}, meshes, {}), StatusIs(kInvalid, "mesh a.ply"));
  meshes[0] = meshes[1];
  EXPECT_THAT(JobPlan::Create({}, meshes, {}), StatusIs(kInvalid, "mesh a.ply is twice there"));
}

TEST(CreatePlan, RefusesKnownMeshesThatDoNotFit) {
  FakeJob job(3);
  std::vector<IngestedMesh> known = job.Known({0});
  known[0].index = 3;
  EXPECT_THAT(JobPlan::Create({}, job.Meshes(), known), StatusIs(kInvalid, "index 3 of 3"));
  EXPECT_THAT(JobPlan::Create({}, job.Meshes(), job.Known({1, 1})),
              StatusIs(kInvalid, "b.ply is there twice"));
  known = job.Known({2});
  known[0].blob = Digest();
  EXPECT_THAT(JobPlan::Create({}, job.Meshes(), known), StatusIs(kInvalid, "c.ply has no blob"));
}

TEST(CreatePlan, FailsTheJobWhenAllMeshesAreKnownNotToFit) {
  FakeJob job(3);
  job.SetRadius(1, 0.08);
  EXPECT_THAT(JobPlan::Create({}, job.Meshes(), job.Known({0, 1, 2})),
              StatusIs(kFailed, "b.ply is 1000 times smaller"));
}

// ---- Results that do not fit ----

TEST(TaskFinished, DoesNotKnowTasksThatAreNotPlanned) {
  FakeJob job(3);
  const auto plan = job.Plan(SpecOf(Method::kAverage));
  EXPECT_THAT(plan->TaskFinished(-1, {}), StatusIs(absl::StatusCode::kNotFound, "task -1"));
  EXPECT_THAT(plan->TaskFinished(3, {}), StatusIs(absl::StatusCode::kNotFound, "task 3"));
}

TEST(TaskFinished, RefusesAnIngestThatLeavesAMeshOut) {
  FakeJob job(3);
  const auto plan = job.Plan(SpecOf(Method::kAverage));
  EXPECT_THAT(plan->TaskFinished(1, {}),
              StatusIs(kInvalid, "task 1 (ingest): b.ply is neither ingested nor rejected"));
  EXPECT_EQ(plan->CurrentProgress().tasks_done, 0);
}

TEST(TaskFinished, RefusesAnIngestOfOtherMeshes) {
  FakeJob job(3);
  const auto plan = job.Plan(SpecOf(Method::kAverage));
  TaskResult result;
  result.ingested = job.Known({2});
  EXPECT_THAT(plan->TaskFinished(1, result), StatusIs(kInvalid, "mesh 2 is not of it"));
  result.ingested = job.Known({1, 1});
  EXPECT_THAT(plan->TaskFinished(1, result), StatusIs(kInvalid, "mesh 1 twice"));
  result.ingested = job.Known({1});
  result.ingested[0].index = -7;
  EXPECT_THAT(plan->TaskFinished(1, result), StatusIs(kInvalid, "mesh -7 is not of it"));
  result.ingested = job.Known({1});
  result.ingested[0].blob = Digest();
  EXPECT_THAT(plan->TaskFinished(1, result), StatusIs(kInvalid, "mesh 1 without a blob"));
  result.ingested = job.Known({1});
  result.rejections = {{1, "both"}};
  EXPECT_THAT(plan->TaskFinished(1, result), StatusIs(kInvalid, "mesh 1 twice"));
}

TEST(TaskFinished, RefusesResultsWithoutTheirBlobs) {
  FakeJob job(2);
  const auto plan = job.Plan(SpecOf(Method::kAverage, PoseMode::kNone), job.AllIndices());
  TaskResult result = job.ResultOf(plan->TakeReadyTasks()[0]);
  result.second_output = Digest();
  EXPECT_THAT(plan->TaskFinished(2, result),
              StatusIs(kInvalid, "task 2 (align 1): no second output"));
  result.alignments.clear();
  EXPECT_THAT(plan->TaskFinished(2, result), StatusIs(kInvalid, "task 2 (align 1): no output"));
}

TEST(TaskFinished, RefusesAlignmentsThatCannotBeReadOrLeaveAMeshOut) {
  FakeJob job(2);
  const auto plan = job.Plan(SpecOf(Method::kAverage, PoseMode::kNone), job.AllIndices());
  const std::vector<Task> tasks = plan->TakeReadyTasks();
  TaskResult result = job.ResultOf(tasks[0]);
  const std::string whole = result.alignments;
  result.alignments = whole.substr(0, whole.size() - 1);
  EXPECT_THAT(plan->TaskFinished(2, result), StatusIs(kInvalid, "task 2 (align 1): "));
  result.alignments = EncodeAlignmentBlob({});
  EXPECT_THAT(plan->TaskFinished(2, result),
              StatusIs(kInvalid, "task 2 (align 1): a.ply is neither aligned nor rejected"));
  result.alignments = job.ResultOf(tasks[1]).alignments;
  EXPECT_THAT(plan->TaskFinished(2, result),
              StatusIs(kInvalid, "task 2 (align 1): a.ply is neither aligned nor rejected"));
  result.alignments = whole;
  EXPECT_THAT(plan->TaskFinished(2, result), IsOk());
}

// As a job goes on that a build has begun which wrote a blob in every round.
TEST(TaskFinished, TakesABlobOfAlignmentsInARoundOfTheMeanShape) {
  FakeJob job(2);
  const auto plan = job.Plan(SpecOf(Method::kAverage, PoseMode::kNone), job.AllIndices());
  for (const Task& task : plan->TakeReadyTasks()) {
    TaskResult result = job.ResultOf(task);
    result.alignments.clear();
    result.output = job.Name("blob of " + task.meshes[0].name);
    EXPECT_THAT(plan->TaskFinished(task.number, result), IsOk());
  }
  (void)job.RunReady(*plan);
  EXPECT_THAT(job.RunReady(*plan),
              ElementsAre(HasSubstr("from blob of a.ply"), HasSubstr("from blob of b.ply")));
}

TEST(TaskFinished, RefusesRejectionsThatAreNotTheTasks) {
  FakeJob job(2);
  const auto plan = job.Plan(SpecOf(Method::kOne, PoseMode::kNone), job.AllIndices());
  const std::vector<Task> aligns = plan->TakeReadyTasks();
  TaskResult result = job.ResultOf(aligns[0]);
  result.rejections = {{1, "not mine"}};
  EXPECT_THAT(plan->TaskFinished(2, result), StatusIs(kInvalid, "mesh 1 is not its to reject"));
  EXPECT_THAT(plan->TaskFinished(2, job.ResultOf(aligns[0])), IsOk());
  EXPECT_THAT(plan->TaskFinished(3, job.ResultOf(aligns[1])), IsOk());
  EXPECT_THAT(plan->TaskFinished(4, result),
              StatusIs(kInvalid, "task 4 (summarize): mesh 1 is not its to reject"));
}

// ---- Meshes that drop out ----

TEST(Rejections, TakeAMeshOutOfEverythingThatFollows) {
  FakeJob job(4);
  job.RejectIn("ingest", 1, "line 3: not a number");
  const auto plan = job.Plan(SpecOf(Method::kOne));
  (void)job.RunReady(*plan);
  EXPECT_EQ(plan->Meshes()[1].rejection, "line 3: not a number");
  EXPECT_FALSE(plan->Meshes()[1].ingested.has_value());
  EXPECT_TRUE(plan->Meshes()[0].ingested.has_value());
  EXPECT_THAT(job.RunReady(*plan),
              ElementsAre("4 align: a | to a | pose, variation, counts index, moves reference",
                          "5 align: c | to a | pose, variation, moves reference",
                          "6 align: d | to a | pose, variation, moves reference"));
  EXPECT_THAT(job.RunAll(*plan), Not(::testing::Contains(HasSubstr(" b "))));
  EXPECT_EQ(plan->Outputs().tiles.size(), 6u);
}

TEST(Rejections, DropAnEmptyBatchAndCountTheIndexInTheNextOne) {
  FakeJob job(4);
  job.RejectIn("align 1", 0, "no pose");
  job.RejectIn("align 2", 2, "collapsed");
  const auto plan = job.Plan(SpecOf(Method::kAverage, PoseMode::kPrincipalAxes, 2));
  job.RunUntil(*plan, "average 1");
  EXPECT_EQ(plan->Meshes()[0].rejection, "no pose");
  EXPECT_THAT(job.RunReady(*plan),
              ElementsAre("8 average 1: | to a | of align 1#5+ align 1#6+ align 1#7+"))
      << "a rejected base stays the first reference of a mean shape";
  EXPECT_THAT(
      job.RunReady(*plan),
      ElementsAre("9 align 2: b | to average 1#8 | from align 1#5 | displacement, counts index",
                  "10 align 2: c | to average 1#8 | from align 1#6 | displacement",
                  "11 align 2: d | to average 1#8 | from align 1#7 | displacement"));
  EXPECT_EQ(plan->Meshes()[2].rejection, "collapsed");
  EXPECT_THAT(job.RunReady(*plan),
              ElementsAre("12 average 2: | to average 1#8 | of align 2#9+ align 2#11+"));
  EXPECT_THAT(
      job.RunReady(*plan),
      ElementsAre("13 align 3: b | to average 2#12 | from align 2#9 | variation, counts index",
                  "14 align 3: d | to average 2#12 | from align 2#11 | variation"));
  EXPECT_THAT(
      job.RunReady(*plan),
      ElementsAre("15 summarize: | to average 2#12 | of align 3#13~ align 3#14~",
                  "16 compare: b x d | from align 3#13 align 3#14",
                  "17 compare: b x b | from align 3#13", "18 compare: d x d | from align 3#14"));
}

TEST(Rejections, InTheLastAlignmentLeaveNoVariationBehind) {
  FakeJob job(4);
  job.RejectIn("align 2", 1, "collapsed");
  const auto plan = job.Plan(SpecOf(Method::kAverage));
  job.RunUntil(*plan, "summarize");
  EXPECT_EQ(job.RunReady(*plan)[0],
            "13 summarize: | to average 1#8 | of align 2#9~ align 2#11~ align 2#12~");
}

TEST(Rejections, LeaveABatchItsIdentity) {
  FakeJob job(128);  // Batches of two, and of one at the end.
  job.RejectIn("align 1", 0);
  const auto plan = job.Plan(SpecOf(Method::kAverage, PoseMode::kNone), job.AllIndices());
  EXPECT_THAT(job.RunReady(*plan)[1], HasSubstr("67 align 1: m100002 m100003 | to m100000"));
  EXPECT_THAT(job.RunReady(*plan)[0], HasSubstr("of align 1#66+ align 1#67+"));
  const std::vector<std::string> next = job.RunReady(*plan);
  EXPECT_THAT(next[0], HasSubstr("align 2: m100001 | to average 1#132 | from align 1#66"));
  EXPECT_THAT(next[1], HasSubstr("align 2: m100002 m100003 | to"));
  EXPECT_EQ(next.size(), 66u);
}

TEST(Rejections, AreFineWithoutABlobWhenNothingIsLeftOfABatch) {
  FakeJob job(3);
  const auto plan = job.Plan(SpecOf(Method::kOne, PoseMode::kNone), job.AllIndices());
  const std::vector<Task> tasks = plan->TakeReadyTasks();
  TaskResult nothing;
  nothing.rejections = {{1, "collapsed"}};
  EXPECT_THAT(plan->TaskFinished(4, nothing), IsOk());
  EXPECT_THAT(plan->TaskFinished(3, job.ResultOf(tasks[0])), IsOk());
  EXPECT_THAT(plan->TaskFinished(5, job.ResultOf(tasks[2])), IsOk());
  EXPECT_EQ(plan->TakeReadyTasks().size(), 1u + 3u) << "summarize and compare";
}

TEST(Rejections, FailTheJobWhenFewerThanTwoMeshesAreLeft) {
  FakeJob job(6);
  for (int mesh = 0; mesh < 5; ++mesh) {
    job.RejectIn("ingest", mesh, absl::StrCat("reason ", mesh));
  }
  const auto plan = job.Plan(SpecOf(Method::kAverage));
  absl::Status status;
  (void)job.RunReady(*plan, &status);
  EXPECT_THAT(status, StatusIs(kFailed,
                               "of 6 only 1 can be used: a.ply: reason 0; b.ply: reason 1; "
                               "c.ply: reason 2; and 2 more"));
  EXPECT_FALSE(plan->Done());
  EXPECT_THAT(plan->TakeReadyTasks(), IsEmpty());
}

TEST(Rejections, OfAllMeshesLeaveAPlanThatForeseesNoPairs) {
  FakeJob job(3);
  for (int mesh = 0; mesh < 3; ++mesh) {
    job.RejectIn("ingest", mesh, "no faces");
  }
  const auto plan = job.Plan(SpecOf(Method::kAverage));
  absl::Status status;
  (void)job.RunReady(*plan, &status);
  EXPECT_THAT(status, StatusIs(kFailed, "of 3 only 0 can be used"));
  for (const StageForecast& stage : plan->Forecast().stages) {
    EXPECT_NE(stage.name, "compare");
  }
}

TEST(Rejections, FailTheJobWhenAlignmentLeavesFewerThanTwo) {
  FakeJob job(2);
  job.RejectIn("align 1", 1, "collapsed");
  const auto plan = job.Plan(SpecOf(Method::kAverage));
  job.RunUntil(*plan, "align 1");
  absl::Status status;
  (void)job.RunReady(*plan, &status);
  EXPECT_THAT(status, StatusIs(kFailed, "of 2 only 1 can be used: b.ply: collapsed"));
}

TEST(Rejections, OfTheNamedBaseAtIngestFailAnyJob) {
  for (const Method method : {Method::kAverage, Method::kOne, Method::kEach, Method::kNone}) {
    FakeJob job(4);
    job.RejectIn("ingest", 1, "no faces");
    JobSpec spec = SpecOf(method);
    spec.base = "b.ply";
    const auto plan = job.Plan(spec);
    absl::Status status;
    (void)job.RunReady(*plan, &status);
    EXPECT_THAT(status, StatusIs(kFailed, "the base mesh b.ply cannot be used: no faces"));
  }
}

TEST(Rejections, OfSymmetricCopiesFailTheJobOnlyIfTheBaseOrAllButOneGo) {
  JobSpec spec = SpecOf(Method::kAverage);
  spec.symmetric_copies = true;
  FakeJob few(2);
  few.RejectIn("symmetrize", 0, "no plane");
  const auto alone = few.Plan(spec, few.AllIndices());
  absl::Status status;
  (void)few.RunReady(*alone, &status);
  EXPECT_THAT(status, StatusIs(kFailed, "of 2 only 1 can be used: a.ply: no plane"));
  FakeJob many(4);
  many.RejectIn("symmetrize", 1, "no plane");
  spec.base = "b.ply";
  const auto baseless = many.Plan(spec, many.AllIndices());
  (void)many.RunReady(*baseless, &status);
  EXPECT_THAT(status, StatusIs(kFailed, "the base mesh b.ply cannot be used: no plane"));
}

TEST(TaskFinished, RefusesSymmetricCopiesThatAreNotTheTasks) {
  FakeJob job(2);
  JobSpec spec = SpecOf(Method::kOne);
  spec.symmetric_copies = true;
  const auto plan = job.Plan(spec, job.AllIndices());
  const Task task = plan->TakeReadyTasks().at(0);
  const TaskResult good = job.ResultOf(task);
  TaskResult bad = good;
  bad.copies.clear();
  EXPECT_THAT(plan->TaskFinished(task.number, bad),
              StatusIs(kInvalid, "1 meshes are neither copied nor rejected"));
  bad = good;
  bad.copies[0].index = 1;
  EXPECT_THAT(plan->TaskFinished(task.number, bad), StatusIs(kInvalid, "mesh 1 is not of it"));
  bad = good;
  bad.copies[0].blob = Digest();
  EXPECT_THAT(plan->TaskFinished(task.number, bad), StatusIs(kInvalid, "mesh 0 without a blob"));
  bad = good;
  bad.rejections = {{0, "both"}};
  EXPECT_THAT(plan->TaskFinished(task.number, bad), StatusIs(kInvalid, "there twice"));
  EXPECT_THAT(plan->TaskFinished(task.number, good), IsOk());
}

TEST(Rejections, OfTheFirstMeshMakeTheNextOneTheBaseWhenNoneIsNamed) {
  FakeJob job(4);
  job.RejectIn("ingest", 0, "no faces");
  const auto plan = job.Plan(SpecOf(Method::kOne));
  (void)job.RunReady(*plan);
  EXPECT_EQ(job.RunReady(*plan)[0],
            "4 align: b | to b | pose, variation, counts index, moves reference");
}

TEST(Rejections, OfTheBaseAfterIngestFailJobsThatCompareWithIt) {
  for (const Method method : {Method::kOne, Method::kEach}) {
    FakeJob job(4);
    const std::string stage = method == Method::kOne ? "align" : "pose";
    job.RejectIn(stage, 0, "flat");
    const auto plan = job.Plan(SpecOf(method));
    job.RunUntil(*plan, stage);
    absl::Status status;
    (void)job.RunReady(*plan, &status);
    EXPECT_THAT(status, StatusIs(kFailed, "the base mesh a.ply cannot be used: flat"));
  }
}

// ---- Units ----

struct Units {
  std::vector<double> radii;
  double limit;
  std::string error;  // Empty: the job goes on.
};
class UnitCheck : public ::testing::TestWithParam<Units> {};

TEST_P(UnitCheck, ComparesSizesWithTheMedian) {
  FakeJob job(static_cast<int>(GetParam().radii.size()));
  for (size_t i = 0; i < GetParam().radii.size(); ++i) {
    job.SetRadius(static_cast<int>(i), GetParam().radii[i]);
  }
  JobSpec spec;
  spec.size_ratio_limit = GetParam().limit;
  const auto plan = job.Plan(spec);
  absl::Status status;
  (void)job.RunReady(*plan, &status);
  if (GetParam().error.empty()) {
    EXPECT_THAT(status, IsOk());
  } else {
    EXPECT_THAT(status, StatusIs(kFailed, GetParam().error));
    EXPECT_THAT(status, StatusIs(kFailed, "--size-ratio-limit 0"));
  }
}

INSTANTIATE_TEST_SUITE_P(
    Table,
    UnitCheck,
    ::testing::Values(
        Units{{80, 81, 79, 90}, 5, ""},
        Units{{80, 80, 400, 16}, 5, ""},
        Units{{80, 0.08, 80},
              5,
              "b.ply is 1000 times smaller than the median mesh (0.08 against 80): another unit of "
              "length (metres?); convert the files"},
        Units{{80, 8, 80},
              5,
              "b.ply is 10 times smaller than the median mesh (8 against 80): "
              "another unit of length (centimetres?)"},
        Units{{80, 3.15, 80}, 5, "(3.15 against 80): another unit of length (inches?)"},
        Units{{80, 0.8, 80},
              5,
              "b.ply is 100 times smaller than the median mesh (0.8 against 80): "
              "another unit of length;"},
        Units{{0.08, 80, 0.08, 0.09},
              5,
              "b.ply is 1000 times larger than the median mesh (80 against 0.08): another unit of "
              "length (the others in metres?)"},
        Units{{80, 400.1, 80}, 5, "b.ply is 5 times larger than the median mesh (400 against 80)"},
        Units{{80, 80, 80, 80, 80, 80, 1, 2, 3, 4, 5},
              5,
              "g.ply is 80 times smaller than the median mesh (1 against 80): another unit of "
              "length; h.ply is 40 times smaller than the median mesh (2 against 80): another unit "
              "of length (inches?); i.ply is 26.7 times smaller than the median mesh (3 against "
              "80): another unit of length (inches?); and 2 more; convert"},
        Units{{80, 0.08},
              5,
              "b.ply is 1000 times smaller than a.ply (0.08 against 80): another "
              "unit of length (metres?)"},
        Units{{0.08, 80}, 5, "a.ply is 1000 times smaller than b.ply (0.08 against 80)"},
        Units{{80, 16}, 5, ""},
        Units{{80, 1, 1, 80}, 5, "a.ply is 80 times larger than the median mesh (80 against 1)"},
        Units{{80, 0.08, 80}, 0, ""},
        Units{{80, 40, 80}, 1.5, "b.ply is 2 times smaller"},
        Units{{0, 0, 0}, 5, ""}));

}  // namespace
}  // namespace cohort
