#include "server/planning/job_plan.h"

#include <set>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/planning/fake_job.h"

namespace cohort {
namespace {

using ::cohort::testing::FakeJob;
using ::cohort::testing::IsOk;
using ::cohort::testing::SpecOf;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

// ---- What tasks carry ----

TEST(PlanTasks, CarryTheOptionsOfTheJob) {
  FakeJob job(2);
  JobSpec spec = SpecOf(Method::kAverage);
  spec.base = "b.ply";
  spec.position_bits = 21;
  spec.icp.max_iterations = 33;
  const auto plan = job.Plan(spec);
  int aligned = 0;
  int compared = 0;
  while (!plan->Done()) {
    for (const Task& task : plan->TakeReadyTasks()) {
      EXPECT_GT(task.cost, 0) << task.stage;
      if (task.kind == TaskKind::kIngest) {
        EXPECT_EQ(task.position_bits, 21);
      } else if (task.kind == TaskKind::kAlign) {
        EXPECT_EQ(task.icp.max_iterations, 33);
        ++aligned;
      } else if (task.kind == TaskKind::kCompare) {
        EXPECT_EQ(task.frame_center, (std::array<double, 3>{1, 2, 3})) << "centroid of b";
        ++compared;
      }
      ASSERT_THAT(plan->TaskFinished(task.number, job.ResultOf(task)), IsOk());
    }
  }
  EXPECT_EQ(aligned, 4);
  EXPECT_EQ(compared, 3);
}

TEST(PlanTasks, AreAMillionTilesAtMostWhereDistancesAreNotKept) {
  FakeJob job(20000);
  JobSpec spec = SpecOf(Method::kNone);
  spec.compare.retention = Retention::kMetrics;
  int64_t tiles = 0;
  for (const StageForecast& stage : job.Plan(spec)->Forecast().stages) {
    tiles += stage.name == "compare" ? stage.tasks : 0;
  }
  EXPECT_GT(tiles, 800'000);
  EXPECT_LE(tiles, 1'001'000);
}

struct Batching {
  int meshes;
  size_t ingest_size;
  size_t align_size;
  size_t tile_size;
};
class PlanBatching : public ::testing::TestWithParam<Batching> {};

TEST_P(PlanBatching, FollowsFromTheNumberOfMeshes) {
  FakeJob job(GetParam().meshes);
  const auto plan = job.Plan(SpecOf(Method::kOne, PoseMode::kNone));
  std::map<std::string, size_t> largest;
  std::map<std::string, std::set<int32_t>> seen;
  while (!plan->Done()) {
    for (const Task& task : plan->TakeReadyTasks()) {
      largest[task.stage] = std::max(largest[task.stage], task.meshes.size());
      for (const TaskMesh& mesh : task.meshes) {
        seen[task.stage].insert(mesh.index);
      }
      ASSERT_THAT(plan->TaskFinished(task.number, job.ResultOf(task)), IsOk());
    }
  }
  EXPECT_EQ(largest["ingest"], GetParam().ingest_size);
  EXPECT_EQ(largest["align"], GetParam().align_size);
  EXPECT_EQ(largest["compare"], GetParam().tile_size);
  const auto all = static_cast<size_t>(GetParam().meshes);
  EXPECT_EQ(seen["ingest"].size(), all);
  EXPECT_EQ(seen["align"].size(), all);
}

INSTANTIATE_TEST_SUITE_P(Table,
                         PlanBatching,
                         ::testing::Values(Batching{24, 1, 1, 1},
                                           Batching{25, 1, 1, 2},
                                           Batching{127, 1, 1, 7},
                                           Batching{128, 2, 2, 7},
                                           Batching{384, 6, 6, 7},
                                           Batching{700, 10, 10, 7},
                                           Batching{1100, 16, 16, 7}));

/// Meshes of the largest block of the tiles.
size_t LargestBlock(int meshes, int64_t vertices) {
  FakeJob job(meshes);
  job.vertices = vertices;
  const auto plan = job.Plan(SpecOf(Method::kNone, PoseMode::kNone));
  size_t largest = 0;
  while (!plan->Done()) {
    for (const Task& task : plan->TakeReadyTasks()) {
      if (task.kind == TaskKind::kCompare) {
        largest = std::max(largest, task.meshes.size());
      }
      EXPECT_THAT(plan->TaskFinished(task.number, job.ResultOf(task)), IsOk());
    }
  }
  return largest;
}

TEST(TileSize, IsNotOverSoonerThanHandedOut) {
  EXPECT_EQ(LargestBlock(8, 100), 8U);      // a tile of everything is over at once
  EXPECT_EQ(LargestBlock(60, 20000), 14U);  // 10 on average: 200 pairs of 20,000 look-ups, 72 ms
  EXPECT_EQ(LargestBlock(60, 200000), 4U);
  EXPECT_EQ(LargestBlock(200, 100), 31U);
}

class PlanTiles : public ::testing::TestWithParam<int> {};

/// What the tasks of a job align and measure.
class PairTally {
 public:
  explicit PairTally(int meshes)
      : meshes_(static_cast<size_t>(meshes)), times_(meshes_ * meshes_) {}

  void AddAlignments(const Task& task, const Digest& output) {
    for (const TaskMesh& mesh : task.meshes) {
      meshes_of_blob_[output.Hex()].insert(mesh.index);
    }
  }

  void AddTile(const Task& task) {
    std::set<int32_t> covered;
    for (const Digest& blob : task.alignments) {
      covered.merge(std::set<int32_t>(meshes_of_blob_[blob.Hex()]));
    }
    const bool diagonal = task.meshes == task.targets;
    for (const TaskMesh& a : task.meshes) {
      ASSERT_TRUE(covered.contains(a.index));
      for (const TaskMesh& b : task.targets) {
        ASSERT_TRUE(covered.contains(b.index));
        ++TimesOf(a, b);
        if (!diagonal) {
          ++TimesOf(b, a);
        }
      }
    }
  }

  /// How often each directed pair was measured, each number once.
  [[nodiscard]] std::set<int> Times() const { return {times_.begin(), times_.end()}; }

 private:
  int& TimesOf(const TaskMesh& a, const TaskMesh& b) {
    return times_[static_cast<size_t>(a.index) * meshes_ + static_cast<size_t>(b.index)];
  }

  size_t meshes_;
  std::vector<int> times_;
  std::map<std::string, std::set<int32_t>> meshes_of_blob_;
};

TEST_P(PlanTiles, MeasureEveryDirectedPairOnceAndKnowTheirAlignments) {
  const int n = GetParam();
  FakeJob job(n);
  const auto plan = job.Plan(SpecOf(Method::kOne, PoseMode::kNone), job.AllIndices());
  PairTally tally(n);
  while (!plan->Done()) {
    for (const Task& task : plan->TakeReadyTasks()) {
      const TaskResult result = job.ResultOf(task);
      if (task.kind == TaskKind::kAlign) {
        tally.AddAlignments(task, result.output);
      } else if (task.kind == TaskKind::kCompare) {
        ASSERT_NO_FATAL_FAILURE(tally.AddTile(task));
      }
      ASSERT_THAT(plan->TaskFinished(task.number, result), IsOk());
    }
  }
  EXPECT_EQ(tally.Times(), std::set<int>{1});
}

INSTANTIATE_TEST_SUITE_P(Sizes, PlanTiles, ::testing::Values(2, 3, 13, 97, 400, 1000));

// ---- Known meshes ----

TEST(PlanWithKnownMeshes, SkipsTheirIngestButKeepsTheNumbers) {
  FakeJob job(3);
  const auto plan = job.Plan(SpecOf(Method::kNone), {0, 2});
  EXPECT_EQ(plan->CurrentProgress().tasks_total, 1 + 6 + 3 + 1);
  EXPECT_THAT(job.RunReady(*plan), ElementsAre("1 ingest: b raw"));
  EXPECT_EQ(job.RunReady(*plan)[0], "3 variation: a | to a | moves reference");
}

TEST(PlanWithKnownMeshes, BeginsAfterIngestWhenAllAreKnown) {
  FakeJob job(3);
  const auto plan = job.Plan(SpecOf(Method::kOne), job.AllIndices());
  EXPECT_EQ(plan->CurrentProgress().stage, "align");
  EXPECT_EQ(job.RunReady(*plan)[0],
            "3 align: a | to a | pose, variation, counts index, moves reference");
}

// ---- Bookkeeping ----

TEST(JobPlan, HandsOutATaskOnce) {
  FakeJob job(3);
  const auto plan = job.Plan(SpecOf(Method::kNone));
  EXPECT_EQ(plan->TakeReadyTasks().size(), 3u);
  EXPECT_THAT(plan->TakeReadyTasks(), IsEmpty());
}

TEST(JobPlan, StartsTheNextStepOnlyWhenEveryTaskIsIn) {
  FakeJob job(3);
  const auto plan = job.Plan(SpecOf(Method::kAverage));
  const std::vector<Task> tasks = plan->TakeReadyTasks();
  for (const size_t place : {2, 0}) {
    EXPECT_THAT(plan->TaskFinished(tasks[place].number, job.ResultOf(tasks[place])), IsOk());
    EXPECT_THAT(plan->TakeReadyTasks(), IsEmpty());
  }
  EXPECT_THAT(plan->TaskFinished(1, job.ResultOf(tasks[1])), IsOk());
  EXPECT_EQ(plan->TakeReadyTasks().size(), 3u);
}

TEST(JobPlan, CountsATaskOnceHoweverOftenItIsFinished) {
  FakeJob job(2);
  const auto plan = job.Plan(SpecOf(Method::kNone));
  const std::vector<Task> tasks = plan->TakeReadyTasks();
  const TaskResult result = job.ResultOf(tasks[0]);
  EXPECT_THAT(plan->TaskFinished(0, result), IsOk());
  EXPECT_THAT(plan->TaskFinished(0, result), IsOk());
  EXPECT_EQ(plan->TotalCounters().pairs, 1);
  EXPECT_EQ(plan->CurrentProgress().tasks_done, 1);
  EXPECT_THAT(plan->TaskFinished(1, job.ResultOf(tasks[1])), IsOk());
  EXPECT_THAT(plan->TaskFinished(0, result), IsOk()) << "its stage has ended";
  EXPECT_EQ(plan->TotalCounters().pairs, 2);
}

TEST(JobPlan, ShowsTheStageOfTheEarliestUnfinishedTask) {
  FakeJob job(2);
  const auto plan = job.Plan(SpecOf(Method::kNone));
  EXPECT_EQ(plan->CurrentProgress().stage, "ingest");
  (void)job.RunReady(*plan);
  EXPECT_EQ(plan->CurrentProgress().stage, "variation");
  (void)job.RunReady(*plan);
  const std::vector<Task> tasks = plan->TakeReadyTasks();
  EXPECT_EQ(plan->CurrentProgress().stage, "summarize");
  for (const Task& task : tasks) {
    if (task.kind == TaskKind::kSummarize) {
      ASSERT_THAT(plan->TaskFinished(task.number, job.ResultOf(task)), IsOk());
    }
  }
  EXPECT_EQ(plan->CurrentProgress().stage, "compare");
  for (const Task& task : tasks) {
    ASSERT_THAT(plan->TaskFinished(task.number, job.ResultOf(task)), IsOk());
  }
  EXPECT_TRUE(plan->Done());
  EXPECT_EQ(plan->CurrentProgress().stage, "");
}

class PlanOfMethod : public ::testing::TestWithParam<Method> {};

TEST_P(PlanOfMethod, AnnouncesItsWorkFromTheBeginning) {
  FakeJob job(30);
  const auto plan = job.Plan(SpecOf(GetParam(), PoseMode::kPrincipalAxes, 3));
  const Progress first = plan->CurrentProgress();
  int64_t done = 0;
  double cost_done = 0;
  while (!plan->Done()) {
    for (const Task& task : plan->TakeReadyTasks()) {
      ASSERT_THAT(plan->TaskFinished(task.number, job.ResultOf(task)), IsOk());
      const Progress now = plan->CurrentProgress();
      EXPECT_EQ(now.tasks_total, first.tasks_total);
      // Vertices are as the file sizes promise: 100 in 6000 bytes.
      EXPECT_NEAR(now.cost_total, first.cost_total, 1e-9 * first.cost_total);
      EXPECT_EQ(now.tasks_done, ++done);
      EXPECT_GE(now.cost_done, cost_done * (1 - 1e-12));
      EXPECT_LE(now.cost_done, now.cost_total);
      cost_done = now.cost_done;
    }
  }
  EXPECT_EQ(plan->CurrentProgress().cost_done, plan->CurrentProgress().cost_total);
}

TEST_P(PlanOfMethod, IsTheSameWhateverTheOrderOfResults) {
  std::vector<std::string> expected;
  for (uint64_t seed = 0; seed < 30; ++seed) {
    FakeJob job(14);
    job.RejectIn("ingest", 3);
    job.RejectIn("pose", 5);
    job.RejectIn("align 1", 7);
    job.RejectIn("align 1", 8);
    job.RejectIn("align", 9);
    const auto plan = job.Plan(SpecOf(GetParam(), PoseMode::kPrincipalAxes, 2));
    Random random(seed);
    std::vector<std::string> lines;
    while (!plan->Done()) {
      std::vector<Task> tasks = plan->TakeReadyTasks();
      ASSERT_FALSE(tasks.empty());
      for (const Task& task : tasks) {
        lines.push_back(job.Line(task));
      }
      for (size_t left = tasks.size(); seed > 0 && left > 1; --left) {
        std::swap(tasks[left - 1],
                  tasks[static_cast<size_t>(random.Below(static_cast<int64_t>(left)))]);
      }
      for (const Task& task : tasks) {
        ASSERT_THAT(plan->TaskFinished(task.number, job.ResultOf(task)), IsOk());
      }
    }
    lines.push_back(job.NamesOf(plan->Outputs().tiles));
    lines.push_back(job.NamesOf(plan->Outputs().alignments));
    lines.push_back(absl::StrCat("cost ", plan->CurrentProgress().cost_done));
    if (seed == 0) {
      expected = lines;
    }
    ASSERT_EQ(lines, expected) << "seed " << seed;
  }
}

// A result as it reached the catalog.
struct Arrival {
  int64_t number;
  TaskResult result;
};

// A server dies after any number of results; the next one makes the plan again from what the
// catalog holds: those results, by number, and all meshes that were ingested meanwhile.
TEST_P(PlanOfMethod, GoesOnAfterARestartWithTheSameNumbers) {
  FakeJob job(9);
  job.RejectIn("ingest", 3);
  job.RejectIn("pose", 5);
  job.RejectIn("align 1", 7);
  const JobSpec spec = SpecOf(GetParam(), PoseMode::kPrincipalAxes, 2);
  const auto whole = job.Plan(spec);
  std::map<int64_t, std::string> expected;
  std::vector<Arrival> arrivals;
  while (!whole->Done()) {
    std::vector<Task> tasks = whole->TakeReadyTasks();
    std::reverse(tasks.begin(), tasks.end());
    for (const Task& task : tasks) {
      expected[task.number] = job.Line(task);
      arrivals.push_back({task.number, job.ResultOf(task)});
      ASSERT_THAT(whole->TaskFinished(task.number, arrivals.back().result), IsOk());
    }
  }
  for (size_t kept = 0; kept <= arrivals.size(); ++kept) {
    SCOPED_TRACE(absl::StrCat("after ", kept, " results"));
    std::map<int64_t, TaskResult> catalog;
    std::vector<int32_t> known;
    for (size_t i = 0; i < kept; ++i) {
      catalog[arrivals[i].number] = arrivals[i].result;
      for (const IngestedMesh& mesh : arrivals[i].result.ingested) {
        known.push_back(mesh.index);
      }
    }
    const auto again = job.Plan(spec, known);
    for (const auto& [number, result] : catalog) {
      ASSERT_THAT(again->TaskFinished(number, result), IsOk());
    }
    std::set<int64_t> rest;
    while (!again->Done()) {
      const std::vector<Task> tasks = again->TakeReadyTasks();
      ASSERT_FALSE(tasks.empty());
      for (const Task& task : tasks) {
        EXPECT_EQ(job.Line(task), expected[task.number]);
        EXPECT_TRUE(rest.insert(task.number).second);
        ASSERT_THAT(again->TaskFinished(task.number, job.ResultOf(task)), IsOk());
      }
    }
    EXPECT_EQ(rest.size(), arrivals.size() - kept);
    EXPECT_EQ(again->Outputs().tiles, whole->Outputs().tiles);
    EXPECT_EQ(again->Outputs().alignments, whole->Outputs().alignments);
    EXPECT_EQ(again->Outputs().mean_shape, whole->Outputs().mean_shape);
    EXPECT_EQ(again->Outputs().summary, whole->Outputs().summary);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Methods,
    PlanOfMethod,
    ::testing::Values(Method::kAverage, Method::kOne, Method::kEach, Method::kNone),
    [](const auto& method) { return std::string(MethodName(method.param)); });

}  // namespace
}  // namespace cohort
