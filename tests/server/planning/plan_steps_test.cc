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
      ElementsAre(
          "0 ingest: a raw",                                                               //
          "1 ingest: b raw",                                                               //
          "2 ingest: c raw",                                                               //
          "--",                                                                            //
          "3 pose: a | to a | counts index",                                               //
          "4 pose: b | to a",                                                              //
          "5 pose: c | to a",                                                              //
          "--",                                                                            //
          "6 align 1: a | to a | from pose#3 | displacement, counts index",                //
          "7 align 1: b | to a | from pose#4 | displacement",                              //
          "8 align 1: c | to a | from pose#5 | displacement",                              //
          "--",                                                                            //
          "9 average 1: | to a | of align 1#6+ align 1#7+ align 1#8+",                     //
          "--",                                                                            //
          "10 align 2: a | to average 1#9 | from align 1#6 | displacement, counts index",  //
          "11 align 2: b | to average 1#9 | from align 1#7 | displacement",                //
          "12 align 2: c | to average 1#9 | from align 1#8 | displacement",                //
          "--",                                                                            //
          "13 average 2: | to average 1#9 | of align 2#10+ align 2#11+ align 2#12+",       //
          "--",                                                                            //
          "14 align 3: a | to average 2#13 | from align 2#10 | counts index",              //
          "15 align 3: b | to average 2#13 | from align 2#11",                             //
          "16 align 3: c | to average 2#13 | from align 2#12",                             //
          "--",                                                                            //
          "17 variation: a | to average 2#13 | from align 3#14",                           //
          "18 variation: b | to average 2#13 | from align 3#15",                           //
          "19 variation: c | to average 2#13 | from align 3#16",                           //
          "--",                                                                            //
          "20 summarize: | to average 2#13 | of variation#17 variation#18 variation#19",   //
          "21 compare: a x b | from align 3#14 align 3#15",                                //
          "22 compare: a x c | from align 3#14 align 3#16",                                //
          "23 compare: b x c | from align 3#15 align 3#16",                                //
          "24 compare: a x a | from align 3#14",                                           //
          "25 compare: b x b | from align 3#15",                                           //
          "26 compare: c x c | from align 3#16"));
  EXPECT_EQ(job.NamesOf(plan->Outputs().tiles),
            "compare#21 compare#22 compare#23 compare#24 compare#25 compare#26");
  EXPECT_EQ(job.NamesOf(plan->Outputs().alignments), "align 3#14 align 3#15 align 3#16");
  EXPECT_EQ(job.NameOf(plan->Outputs().summary), "summarize#20");
  EXPECT_EQ(job.NameOf(plan->Outputs().mean_shape), "summarize#20+");
}

TEST(PlanToAverage, StartsFromIdentityWithoutAPose) {
  FakeJob job(2);
  const auto plan = job.Plan(SpecOf(Method::kAverage, PoseMode::kNone));
  EXPECT_THAT(job.RunAll(*plan),
              ElementsAre("0 ingest: a raw",                                                //
                          "1 ingest: b raw",                                                //
                          "--",                                                             //
                          "2 align 1: a | to a | displacement, counts index",               //
                          "3 align 1: b | to a | displacement",                             //
                          "--",                                                             //
                          "4 average 1: | to a | of align 1#2+ align 1#3+",                 //
                          "--",                                                             //
                          "5 align 2: a | to average 1#4 | from align 1#2 | counts index",  //
                          "6 align 2: b | to average 1#4 | from align 1#3",                 //
                          "--",                                                             //
                          "7 variation: a | to average 1#4 | from align 2#5",               //
                          "8 variation: b | to average 1#4 | from align 2#6",               //
                          "--",                                                             //
                          "9 summarize: | to average 1#4 | of variation#7 variation#8",     //
                          "10 compare: a x b | from align 2#5 align 2#6",                   //
                          "11 compare: a x a | from align 2#5",                             //
                          "12 compare: b x b | from align 2#6"));
}

TEST(PlanToOne, IsThisForThreeMeshesAndTheSecondAsBase) {
  FakeJob job(3);
  JobSpec spec = SpecOf(Method::kOne);
  spec.base = "b.ply";
  const auto plan = job.Plan(spec);
  EXPECT_THAT(
      job.RunAll(*plan),
      ElementsAre(
          "0 ingest: a raw",                                                                    //
          "1 ingest: b raw",                                                                    //
          "2 ingest: c raw",                                                                    //
          "--",                                                                                 //
          "3 pose: a | to b | counts index",                                                    //
          "4 pose: b | to b",                                                                   //
          "5 pose: c | to b",                                                                   //
          "--",                                                                                 //
          "6 align: a | to b | from pose#3 | counts index",                                     //
          "7 align: b | to b | from pose#4",                                                    //
          "8 align: c | to b | from pose#5",                                                    //
          "--",                                                                                 //
          "9 variation: a | to b | from align#6 | moves reference",                             //
          "10 variation: b | to b | from align#7 | moves reference",                            //
          "11 variation: c | to b | from align#8 | moves reference",                            //
          "--",                                                                                 //
          "12 summarize: | to b | of variation#9 variation#10 variation#11 | moves reference",  //
          "13 compare: a x b | from align#6 align#7",                                           //
          "14 compare: a x c | from align#6 align#8",                                           //
          "15 compare: b x c | from align#7 align#8",                                           //
          "16 compare: a x a | from align#6",                                                   //
          "17 compare: b x b | from align#7",                                                   //
          "18 compare: c x c | from align#8"));
  EXPECT_EQ(job.NamesOf(plan->Outputs().alignments), "align#6 align#7 align#8");
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
                  "4 pose: a* | to a* | counts index",                                     //
                  "5 pose: b* | to a*",                                                    //
                  "--",                                                                    //
                  "6 align: a* | to a* | from pose#4 | counts index",                      //
                  "7 align: b* | to a* | from pose#5",                                     //
                  "--",                                                                    //
                  "8 variation: a* | to a* | from align#6 | moves reference",              //
                  "9 variation: b* | to a* | from align#7 | moves reference",              //
                  "--",                                                                    //
                  "10 summarize: | to a* | of variation#8 variation#9 | moves reference",  //
                  "11 compare: a* x b* | from align#6 align#7",                            //
                  "12 compare: a* x a* | from align#6",                                    //
                  "13 compare: b* x b* | from align#7"));
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
  EXPECT_THAT(job.RunReady(*plan), ElementsAre("6 pose: b* | to b* | counts index",  //
                                               "7 pose: c* | to b*"));
  EXPECT_EQ(plan->Meshes()[0].rejection, "it is broken");
}

struct Size {
  Method method;
  int meshes;
  int64_t tasks;
};
class PlanSize : public ::testing::TestWithParam<Size> {};

// ingest n, pose n, then: average with M rounds (M + 1) n + M, one n, each n; tiles n (n + 1) / 2
// but for each; variation n; summarize 1.
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
                         ::testing::Values(Size{Method::kAverage, 3, 3 + 3 + 15 + 6 + 3 + 1},
                                           Size{Method::kAverage, 4, 4 + 4 + 19 + 10 + 4 + 1},
                                           Size{Method::kAverage, 5, 5 + 5 + 23 + 15 + 5 + 1},
                                           Size{Method::kOne, 3, 3 + 3 + 3 + 6 + 3 + 1},
                                           Size{Method::kOne, 4, 4 + 4 + 4 + 10 + 4 + 1},
                                           Size{Method::kOne, 5, 5 + 5 + 5 + 15 + 5 + 1},
                                           Size{Method::kEach, 3, 3 + 3 + 3 + 3 + 1},
                                           Size{Method::kEach, 4, 4 + 4 + 4 + 4 + 1},
                                           Size{Method::kEach, 5, 5 + 5 + 5 + 5 + 1},
                                           Size{Method::kNone, 3, 3 + 6 + 3 + 1},
                                           Size{Method::kNone, 4, 4 + 10 + 4 + 1},
                                           Size{Method::kNone, 5, 5 + 15 + 5 + 1}));

}  // namespace
}  // namespace cohort
