// The plans of the four methods, task by task.

#include "server/planning/plan_steps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/planning/fake_job.h"

namespace cohort {
namespace {

using ::cohort::testing::FakeJob;
using ::cohort::testing::SpecOf;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(PlanToAverage, IsThisForThreeMeshesAndTwoRounds) {
  FakeJob job(3);
  const auto plan = job.Plan(SpecOf(Method::kAverage, PoseMode::kPrincipalAxes, 2));
  EXPECT_THAT(
      job.RunAll(*plan),
      ElementsAre("0 ingest: a raw",                                                              //
                  "1 ingest: b raw",                                                              //
                  "2 ingest: c raw",                                                              //
                  "--",                                                                           //
                  "3 align 1: a | to a | pose, displacement, counts index",                       //
                  "4 align 1: b | to a | pose, displacement",                                     //
                  "5 align 1: c | to a | pose, displacement",                                     //
                  "--",                                                                           //
                  "6 average 1: | to a | of align 1#3+ align 1#4+ align 1#5+",                    //
                  "--",                                                                           //
                  "7 align 2: a | to average 1#6 | from align 1#3 | displacement, counts index",  //
                  "8 align 2: b | to average 1#6 | from align 1#4 | displacement",                //
                  "9 align 2: c | to average 1#6 | from align 1#5 | displacement",                //
                  "--",                                                                           //
                  "10 average 2: | to average 1#6 | of align 2#7+ align 2#8+ align 2#9+",         //
                  "--",                                                                           //
                  "11 align 3: a | to average 2#10 | from align 2#7 | variation, counts index",   //
                  "12 align 3: b | to average 2#10 | from align 2#8 | variation",                 //
                  "13 align 3: c | to average 2#10 | from align 2#9 | variation",                 //
                  "--",                                                                           //
                  "14 summarize: | to average 2#10 | of align 3#11~ align 3#12~ align 3#13~",     //
                  "15 compare: a x b | from align 3#11 align 3#12",                               //
                  "16 compare: a x c | from align 3#11 align 3#13",                               //
                  "17 compare: b x c | from align 3#12 align 3#13",                               //
                  "18 compare: a x a | from align 3#11",                                          //
                  "19 compare: b x b | from align 3#12",                                          //
                  "20 compare: c x c | from align 3#13"));
  EXPECT_EQ(job.NamesOf(plan->Outputs().tiles),
            "compare#15 compare#16 compare#17 compare#18 compare#19 compare#20");
  EXPECT_EQ(job.NamesOf(plan->Outputs().alignments), "align 3#11 align 3#12 align 3#13");
  EXPECT_EQ(job.NameOf(plan->Outputs().summary), "summarize#14");
  EXPECT_EQ(job.NameOf(plan->Outputs().mean_shape), "summarize#14+");
}

TEST(PlanToAverage, StartsFromIdentityWithoutAPose) {
  FakeJob job(2);
  const auto plan = job.Plan(SpecOf(Method::kAverage, PoseMode::kNone));
  EXPECT_THAT(
      job.RunAll(*plan),
      ElementsAre("0 ingest: a raw",                                                           //
                  "1 ingest: b raw",                                                           //
                  "--",                                                                        //
                  "2 align 1: a | to a | displacement, counts index",                          //
                  "3 align 1: b | to a | displacement",                                        //
                  "--",                                                                        //
                  "4 average 1: | to a | of align 1#2+ align 1#3+",                            //
                  "--",                                                                        //
                  "5 align 2: a | to average 1#4 | from align 1#2 | variation, counts index",  //
                  "6 align 2: b | to average 1#4 | from align 1#3 | variation",                //
                  "--",                                                                        //
                  "7 summarize: | to average 1#4 | of align 2#5~ align 2#6~",                  //
                  "8 compare: a x b | from align 2#5 align 2#6",                               //
                  "9 compare: a x a | from align 2#5",                                         //
                  "10 compare: b x b | from align 2#6"));
}

TEST(PlanToOne, IsThisForThreeMeshesAndTheSecondAsBase) {
  FakeJob job(3);
  JobSpec spec = SpecOf(Method::kOne);
  spec.base = "b.ply";
  const auto plan = job.Plan(spec);
  EXPECT_THAT(
      job.RunAll(*plan),
      ElementsAre("0 ingest: a raw",                                                        //
                  "1 ingest: b raw",                                                        //
                  "2 ingest: c raw",                                                        //
                  "--",                                                                     //
                  "3 align: a | to b | pose, variation, counts index, moves reference",     //
                  "4 align: b | to b | pose, variation, moves reference",                   //
                  "5 align: c | to b | pose, variation, moves reference",                   //
                  "--",                                                                     //
                  "6 summarize: | to b | of align#3~ align#4~ align#5~ | moves reference",  //
                  "7 compare: a x b | from align#3 align#4",                                //
                  "8 compare: a x c | from align#3 align#5",                                //
                  "9 compare: b x c | from align#4 align#5",                                //
                  "10 compare: a x a | from align#3",                                       //
                  "11 compare: b x b | from align#4",                                       //
                  "12 compare: c x c | from align#5"));
  EXPECT_EQ(job.NamesOf(plan->Outputs().alignments), "align#3 align#4 align#5");
}

TEST(PlanToEach, IsThisForThreeMeshesAndTheSecondAsBase) {
  FakeJob job(3);
  JobSpec spec = SpecOf(Method::kEach);
  spec.base = "b.ply";
  const auto plan = job.Plan(spec);
  EXPECT_THAT(
      job.RunAll(*plan),
      ElementsAre(
          "0 ingest: a raw",                                                  //
          "1 ingest: b raw",                                                  //
          "2 ingest: c raw",                                                  //
          "--",                                                               //
          "3 pose: a | to b | counts index",                                  //
          "4 pose: b | to b",                                                 //
          "5 pose: c | to b",                                                 //
          "--",                                                               //
          "6 compare: a b c x a | from pose#3 pose#4 pose#5 | counts index",  //
          "7 compare: a b c x b | from pose#3 pose#4 pose#5 | counts index",  //
          "8 compare: a b c x c | from pose#3 pose#4 pose#5 | counts index",  //
          "--",                                                               //
          "9 variation: a | to b | from compare#7+ | moves reference",        //
          "10 variation: b | to b | from compare#7+ | moves reference",       //
          "11 variation: c | to b | from compare#7+ | moves reference",       //
          "--",                                                               //
          "12 summarize: | to b | of variation#9 variation#10 variation#11 | moves reference"));
  EXPECT_EQ(job.NamesOf(plan->Outputs().tiles), "compare#6 compare#7 compare#8");
  EXPECT_EQ(job.NamesOf(plan->Outputs().alignments), "compare#7+");
}

TEST(PlanToEach, StartsFromIdentityWithoutAPose) {
  FakeJob job(2);
  const auto plan = job.Plan(SpecOf(Method::kEach, PoseMode::kNone));
  EXPECT_THAT(job.RunAll(*plan),
              ElementsAre("0 ingest: a raw",                                            //
                          "1 ingest: b raw",                                            //
                          "--",                                                         //
                          "2 compare: a b x a | counts index",                          //
                          "3 compare: a b x b | counts index",                          //
                          "--",                                                         //
                          "4 variation: a | to a | from compare#2+ | moves reference",  //
                          "5 variation: b | to a | from compare#2+ | moves reference",  //
                          "--",                                                         //
                          "6 summarize: | to a | of variation#4 variation#5 | moves reference"));
}

TEST(PlanToNone, IsThisForThreeMeshes) {
  FakeJob job(3);
  const auto plan = job.Plan(SpecOf(Method::kNone));
  EXPECT_THAT(
      job.RunAll(*plan),
      ElementsAre(
          "0 ingest: a raw",                                                                 //
          "1 ingest: b raw",                                                                 //
          "2 ingest: c raw",                                                                 //
          "--",                                                                              //
          "3 variation: a | to a | moves reference",                                         //
          "4 variation: b | to a | moves reference",                                         //
          "5 variation: c | to a | moves reference",                                         //
          "--",                                                                              //
          "6 summarize: | to a | of variation#3 variation#4 variation#5 | moves reference",  //
          "7 compare: a x b",                                                                //
          "8 compare: a x c",                                                                //
          "9 compare: b x c",                                                                //
          "10 compare: a x a",                                                               //
          "11 compare: b x b",                                                               //
          "12 compare: c x c"));
  EXPECT_THAT(plan->Outputs().alignments, IsEmpty());
}

TEST(PlanWithLandmarks, PosesByThemToTheBaseMesh) {
  FakeJob job(2);
  JobSpec spec = SpecOf(Method::kEach, PoseMode::kLandmarks);
  spec.base = "b.ply";
  spec.landmarks = job.Name("landmarks");
  const auto plan = job.Plan(spec);
  EXPECT_THAT(job.RunAll(*plan),
              ElementsAre("0 ingest: a raw",                                            //
                          "1 ingest: b raw",                                            //
                          "--",                                                         //
                          "2 pose: a x b | to b | by landmarks | counts index",         //
                          "3 pose: b x b | to b | by landmarks",                        //
                          "--",                                                         //
                          "4 compare: a b x a | from pose#2 pose#3 | counts index",     //
                          "5 compare: a b x b | from pose#2 pose#3 | counts index",     //
                          "--",                                                         //
                          "6 variation: a | to b | from compare#5+ | moves reference",  //
                          "7 variation: b | to b | from compare#5+ | moves reference",  //
                          "--",                                                         //
                          "8 summarize: | to b | of variation#6 variation#7 | moves reference"));
  EXPECT_EQ(job.NamesOf(plan->Outputs().poses), "pose#2 pose#3");
}

TEST(PlanWithLandmarks, ChoosesTheBaseByThemToo) {
  FakeJob job(3);
  JobSpec spec = SpecOf(Method::kOne, PoseMode::kLandmarks);
  spec.base_rule = BaseRule::kAuto;
  spec.landmarks = job.Name("landmarks");
  const auto plan = job.Plan(spec);
  job.RunUntil(*plan, "base");
  const std::vector<Task> ready = plan->TakeReadyTasks();
  ASSERT_EQ(ready.size(), 1u);
  EXPECT_EQ(job.Line(ready[0]), "3 base: a b c | by landmarks");
}

TEST(PlanWithSymmetricCopies, PutsThemInThePlaceOfTheMeshes) {
  FakeJob job(2);
  JobSpec spec = SpecOf(Method::kOne);
  spec.symmetric_copies = true;
  const auto plan = job.Plan(spec);
  EXPECT_THAT(
      job.RunAll(*plan),
      ElementsAre("0 ingest: a raw",                                                       //
                  "1 ingest: b raw",                                                       //
                  "--",                                                                    //
                  "2 symmetrize: a",                                                       //
                  "3 symmetrize: b",                                                       //
                  "--",                                                                    //
                  "4 align: a* | to a* | pose, variation, counts index, moves reference",  //
                  "5 align: b* | to a* | pose, variation, moves reference",                //
                  "--",                                                                    //
                  "6 summarize: | to a* | of align#4~ align#5~ | moves reference",         //
                  "7 compare: a* x b* | from align#4 align#5",                             //
                  "8 compare: a* x a* | from align#4",                                     //
                  "9 compare: b* x b* | from align#5"));
  EXPECT_EQ(plan->Meshes()[1].copy->asymmetry, 0.5);
  EXPECT_EQ(job.NameOf(plan->Meshes()[1].ingested->blob), "b") << "the mesh stays what it is";
}

TEST(PlanWithSymmetricCopies, LooksForTheNextBaseIfTheFirstHasNone) {
  FakeJob job(3);
  JobSpec spec = SpecOf(Method::kOne);
  spec.symmetric_copies = true;
  job.RejectIn("symmetrize", 0);
  const auto plan = job.Plan(spec, job.AllIndices());
  (void)job.RunReady(*plan);
  EXPECT_THAT(
      job.RunReady(*plan),
      ElementsAre("6 align: b* | to b* | pose, variation, counts index, moves reference",  //
                  "7 align: c* | to b* | pose, variation, moves reference"));
  EXPECT_EQ(plan->Meshes()[0].rejection, "it is broken");
}

struct Size {
  Method method;
  int meshes;
  int64_t tasks;
};
class PlanSize : public ::testing::TestWithParam<Size> {};

// ingest n; average with M rounds (M + 1) n + M, one n, each: pose n, compare n; tiles n (n + 1) /
// 2 but for each; variation n where no alignment finds it; summarize 1.
TEST_P(PlanSize, IsAsTheMethodSays) {
  FakeJob job(GetParam().meshes);
  const auto plan = job.Plan(SpecOf(GetParam().method, PoseMode::kPrincipalAxes, 3));
  EXPECT_EQ(plan->CurrentProgress().tasks_total, GetParam().tasks) << "announced";
  (void)job.RunAll(*plan);
  EXPECT_EQ(plan->CurrentProgress().tasks_total, GetParam().tasks);
  EXPECT_EQ(plan->CurrentProgress().tasks_done, GetParam().tasks);
}

INSTANTIATE_TEST_SUITE_P(Table,
                         PlanSize,
                         ::testing::Values(Size{Method::kAverage, 3, 3 + 15 + 6 + 1},
                                           Size{Method::kAverage, 4, 4 + 19 + 10 + 1},
                                           Size{Method::kAverage, 5, 5 + 23 + 15 + 1},
                                           Size{Method::kOne, 3, 3 + 3 + 6 + 1},
                                           Size{Method::kOne, 4, 4 + 4 + 10 + 1},
                                           Size{Method::kOne, 5, 5 + 5 + 15 + 1},
                                           Size{Method::kEach, 3, 3 + 3 + 3 + 3 + 1},
                                           Size{Method::kEach, 4, 4 + 4 + 4 + 4 + 1},
                                           Size{Method::kEach, 5, 5 + 5 + 5 + 5 + 1},
                                           Size{Method::kNone, 3, 3 + 6 + 3 + 1},
                                           Size{Method::kNone, 4, 4 + 10 + 4 + 1},
                                           Size{Method::kNone, 5, 5 + 15 + 5 + 1}));

}  // namespace
}  // namespace cohort
