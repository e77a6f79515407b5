#include <chrono>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "server/catalog/catalog.h"
#include "tests/server/catalog/catalog_fixture.h"

namespace cohort {
namespace {

using testing::CatalogTest;
using testing::DatabaseName;
using testing::EachDatabase;
using testing::IsOk;
using testing::SomeIngested;
using testing::SomeJob;
using testing::SomeMesh;
using testing::SomeResult;
using testing::SomeTask;
using testing::StatusIs;

class CatalogJobsTest : public CatalogTest {};

void ExpectEqual(const Job& a, const Job& b) {
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.set, b.set);
  EXPECT_EQ(ToJson(a.spec), ToJson(b.spec));
  EXPECT_EQ(a.state, b.state);
  EXPECT_EQ(a.error, b.error);
  EXPECT_EQ(a.version, b.version);
  EXPECT_EQ(a.plan_version, b.plan_version);
  EXPECT_EQ(a.results_version, b.results_version);
  EXPECT_EQ(a.created_unix_ms, b.created_unix_ms);
  EXPECT_EQ(a.started_unix_ms, b.started_unix_ms);
  EXPECT_EQ(a.finished_unix_ms, b.finished_unix_ms);
  EXPECT_EQ(a.meshes, b.meshes);
  EXPECT_EQ(a.rejected_meshes, b.rejected_meshes);
  EXPECT_EQ(a.progress.stage, b.progress.stage);
  EXPECT_EQ(a.progress.tasks_done, b.progress.tasks_done);
  EXPECT_EQ(a.progress.tasks_total, b.progress.tasks_total);
  EXPECT_EQ(a.progress.cost_done, b.progress.cost_done);
  EXPECT_EQ(a.progress.cost_total, b.progress.cost_total);
  EXPECT_EQ(a.counters, b.counters);
}

void ExpectEqual(const TaskRecord& a, const TaskRecord& b) {
  EXPECT_EQ(a.number, b.number);
  EXPECT_EQ(a.epoch, b.epoch);
  EXPECT_EQ(a.failures, b.failures);
  EXPECT_EQ(a.losses, b.losses);
  EXPECT_EQ(a.worker, b.worker);
  EXPECT_EQ(a.last_error, b.last_error);
  ASSERT_EQ(a.result.has_value(), b.result.has_value());
  if (a.result.has_value()) {
    EXPECT_EQ(ToJson(*a.result), ToJson(*b.result));
  }
}

/// Everything of the job that can change, changed.
void Advance(Job& job) {
  job.state = JobState::kRunning;
  job.error = "none 'yet'";
  job.version += 5;
  job.started_unix_ms = 1'700'000'000'001;
  job.finished_unix_ms = 1'700'000'000'002;
  job.rejected_meshes = 1;
  job.progress = {"align 1", 3, 10, 1.0 / 3, 1e10, {{"ingest", 4, 5}}, 2, 1, "space"};
  job.counters.align = {5, 123'456'789'012};
  job.counters.pairs = 9;
}

TEST_P(CatalogJobsTest, CreatesAJobThatSurvivesAReopening) {
  const std::vector<SetMesh> meshes = {SomeMesh("b"), SomeMesh("a")};

  const absl::StatusOr<Job> created =
      catalog_->CreateJob(SomeJob("s"), meshes, "", 1'700'000'000'000);
  ASSERT_THAT(created, IsOk());
  Reopen();

  EXPECT_EQ(created->id.value, "j-000001");
  EXPECT_EQ(created->created_unix_ms, 1'700'000'000'000);
  EXPECT_EQ(created->meshes, 2);
  const absl::StatusOr<Job> found = catalog_->GetJob(created->id);
  ASSERT_THAT(found, IsOk());
  ExpectEqual(*found, *created);
  EXPECT_EQ(found->spec.rounds, 7);
}

TEST_P(CatalogJobsTest, KeepsTheMeshesOfAJobInItsOrder) {
  const Job job = catalog_->CreateJob(SomeJob("s"), {SomeMesh("b"), SomeMesh("a")}, "", 1).value();

  const absl::StatusOr<std::vector<JobMesh>> meshes = catalog_->GetJobMeshes(job.id);

  ASSERT_THAT(meshes, IsOk());
  ASSERT_EQ(meshes->size(), 2u);
  EXPECT_EQ((*meshes)[0].mesh.name, "b");
  EXPECT_EQ((*meshes)[1].mesh.name, "a");
  EXPECT_EQ((*meshes)[1].mesh.raw, Sha256::Of("a"));
  EXPECT_EQ((*meshes)[1].mesh.size_bytes, 5'000'000'000);
  EXPECT_EQ((*meshes)[1].mesh.labels, SomeMesh("a").labels);
  EXPECT_FALSE((*meshes)[1].ingested.has_value());
  EXPECT_EQ((*meshes)[1].rejection, "");
}

TEST_P(CatalogJobsTest, TakesASnapshotOfTheMeshes) {
  SetMesh mesh = SomeMesh("a");
  ASSERT_THAT(catalog_->AddMesh("s", mesh), IsOk());
  const Job job = catalog_->CreateJob(SomeJob("s"), {mesh}, "", 1).value();
  mesh.labels = {{"person", "other"}};
  ASSERT_THAT(catalog_->AddMesh("s", mesh), IsOk());

  EXPECT_EQ(catalog_->GetJobMeshes(job.id).value()[0].mesh.labels, SomeMesh("a").labels);
}

TEST_P(CatalogJobsTest, NumbersJobsOnAfterAReopening) {
  ASSERT_THAT(catalog_->CreateJob(SomeJob("s"), {}, "", 1), IsOk());
  Reopen();

  EXPECT_EQ(catalog_->CreateJob(SomeJob("s"), {}, "", 1)->id.value, "j-000002");
}

TEST_P(CatalogJobsTest, CreatesOneJobPerRequestAndKeepsTheFirstSpec) {
  const Job first = catalog_->CreateJob(SomeJob("s"), {SomeMesh("a")}, "r-1", 10).value();
  Reopen();
  Job changed = SomeJob("another set");
  changed.spec.rounds = 2;

  const absl::StatusOr<Job> again = catalog_->CreateJob(changed, {}, "r-1", 20);

  ASSERT_THAT(again, IsOk());
  ExpectEqual(*again, first);
  EXPECT_EQ(catalog_->ListJobs(10, "")->items.size(), 1u);
  EXPECT_NE(catalog_->CreateJob(changed, {}, "r-2", 20)->id, first.id);
  EXPECT_NE(catalog_->CreateJob(changed, {}, "", 20)->id,
            catalog_->CreateJob(changed, {}, "", 20)->id);
}

TEST_P(CatalogJobsTest, CreatesOneJobForARequestThatComesFromEightThreadsAtOnce) {
  std::vector<std::string> ids(8);
  std::vector<std::thread> callers;
  callers.reserve(ids.size());
  for (std::string& id : ids) {
    callers.emplace_back([&] {
      id = catalog_->CreateJob(SomeJob("s"), {SomeMesh("a")}, "r-1", 10).value().id.value;
    });
  }
  for (std::thread& caller : callers) {
    caller.join();
  }

  EXPECT_THAT(ids, ::testing::Each("j-000001"));
  EXPECT_EQ(catalog_->ListJobs(10, "")->items.size(), 1u);
}

TEST_P(CatalogJobsTest, WritesEverythingThatCanChange) {
  Job job = catalog_->CreateJob(SomeJob("s"), {SomeMesh("a")}, "", 1).value();
  Advance(job);

  ASSERT_THAT(catalog_->UpdateJob(job), IsOk());
  Reopen();

  ExpectEqual(catalog_->GetJob(job.id).value(), job);
}

TEST_P(CatalogJobsTest, FinishesAJobWithItsOutputsAndTheFateOfEachMesh) {
  Job job = catalog_->CreateJob(SomeJob("s"), {SomeMesh("a"), SomeMesh("b")}, "", 1).value();
  Advance(job);
  job.state = JobState::kSucceeded;
  JobOutputs outputs;
  outputs.tiles = {Sha256::Of("1"), Sha256::Of("2")};
  outputs.alignments = {Sha256::Of("3")};
  outputs.mean_shape = Sha256::Of("4");
  outputs.variation_shape = Sha256::Of("7");
  outputs.fields = {Sha256::Of("5")};
  outputs.base_choice = Sha256::Of("6");
  outputs.preview = {Sha256::Of("7")};
  outputs.frame = {.reference = Sha256::Of("10"), .center = {1, -2, 1.0 / 3}};
  outputs.imported.push_back({.tiles = {Sha256::Of("11")}, .fields = {}, .mesh_of = {1, -1, 0}});
  outputs.poses = {Sha256::Of("8"), Sha256::Of("9")};
  std::vector<JobMesh> meshes = catalog_->GetJobMeshes(job.id).value();
  meshes[0].rejection = "line 7: NaN";
  meshes[1].ingested = SomeIngested("b");
  meshes[1].copy = SymmetricCopy{.index = 1, .blob = Sha256::Of("copy"), .asymmetry = 0.125};

  ASSERT_THAT(catalog_->FinishJob(job, outputs, meshes), IsOk());
  Reopen();

  ExpectEqual(catalog_->GetJob(job.id).value(), job);
  const JobOutputs found = catalog_->GetOutputs(job.id).value();
  EXPECT_EQ(found.tiles, outputs.tiles);
  EXPECT_EQ(found.alignments, outputs.alignments);
  EXPECT_EQ(found.mean_shape, outputs.mean_shape);
  EXPECT_EQ(found.summary, outputs.summary);
  EXPECT_EQ(found.variation_shape, outputs.variation_shape);
  EXPECT_EQ(found.fields, outputs.fields);
  EXPECT_EQ(found.base_choice, outputs.base_choice);
  EXPECT_EQ(found.poses, outputs.poses);
  EXPECT_EQ(found.frame, outputs.frame);
  EXPECT_EQ(found.imported, outputs.imported);
  const std::vector<JobMesh> fates = catalog_->GetJobMeshes(job.id).value();
  ASSERT_EQ(fates.size(), 2u);
  EXPECT_EQ(fates[0].rejection, "line 7: NaN");
  EXPECT_FALSE(fates[0].ingested.has_value());
  ASSERT_TRUE(fates[1].ingested.has_value());
  EXPECT_EQ(fates[1].ingested->blob, SomeIngested("b").blob);
  EXPECT_EQ(fates[1].ingested->index, 1);
  EXPECT_EQ(fates[1].copy, meshes[1].copy);
  EXPECT_FALSE(fates[0].copy.has_value());
}

TEST_P(CatalogJobsTest, ChangesNothingWhenAJobIsFinishedWithMeshesItDoesNotHave) {
  Job job = catalog_->CreateJob(SomeJob("s"), {SomeMesh("a")}, "", 1).value();
  const Job before = job;
  Advance(job);

  EXPECT_THAT(catalog_->FinishJob(job, {}, std::vector<JobMesh>(2)),
              StatusIs(absl::StatusCode::kInvalidArgument, "j-000001 has no mesh 1"));

  ExpectEqual(catalog_->GetJob(job.id).value(), before);
}

TEST_P(CatalogJobsTest, NamesTheJobThatIsMissing) {
  Job job = catalog_->CreateJob(SomeJob("s"), {}, "", 1).value();
  job.id.value = "j-000002";

  EXPECT_THAT(catalog_->GetJob(job.id), StatusIs(absl::StatusCode::kNotFound, "j-000002"));
  EXPECT_THAT(catalog_->GetOutputs(job.id), StatusIs(absl::StatusCode::kNotFound, "j-000002"));
  EXPECT_THAT(catalog_->GetJobMeshes(job.id), StatusIs(absl::StatusCode::kNotFound, "j-000002"));
  EXPECT_THAT(testing::LoadTasks(*catalog_, job.id),
              StatusIs(absl::StatusCode::kNotFound, "j-000002"));
  EXPECT_THAT(catalog_->UpdateJob(job), StatusIs(absl::StatusCode::kNotFound, "j-000002"));
  EXPECT_THAT(catalog_->FinishJob(job, {}, {}), StatusIs(absl::StatusCode::kNotFound, "j-000002"));
  EXPECT_THAT(testing::SaveTasks(*catalog_, job.id, {SomeTask(1)}),
              StatusIs(absl::StatusCode::kNotFound, "j-000002"));
  EXPECT_THAT(catalog_->SaveCompletions({{Completion{job, SomeTask(1), {}, ""}}}, 1),
              StatusIs(absl::StatusCode::kNotFound, "j-000002"));
}

TEST_P(CatalogJobsTest, KnowsAJobByOneNameOnly) {
  ASSERT_THAT(catalog_->CreateJob(SomeJob("s"), {}, "", 1), IsOk());

  EXPECT_THAT(catalog_->GetJob({"j-1"}), StatusIs(absl::StatusCode::kNotFound, "j-1"));
  EXPECT_THAT(catalog_->GetJob({"j-0000001"}), StatusIs(absl::StatusCode::kNotFound, "j-0000001"));
  EXPECT_THAT(catalog_->GetJob({"000001"}), StatusIs(absl::StatusCode::kNotFound, "000001"));
  EXPECT_THAT(catalog_->GetJob({""}), StatusIs(absl::StatusCode::kNotFound, ""));
}

TEST_P(CatalogJobsTest, ListsJobsNewestFirst) {
  for (int i = 0; i < 5; ++i) {
    ASSERT_THAT(catalog_->CreateJob(SomeJob("s"), {}, "", i), IsOk());
  }
  std::vector<std::string> ids;
  std::string token;
  do {
    const Page<Job> page = catalog_->ListJobs(2, token).value();
    for (const Job& job : page.items) {
      ids.push_back(job.id.value);
    }
    token = page.next_token;
    // A job that comes between two pages does not shift the later ones.
    ASSERT_THAT(catalog_->CreateJob(SomeJob("s"), {}, "", 9), IsOk());
  } while (!token.empty());

  EXPECT_THAT(ids,
              ::testing::ElementsAre("j-000005", "j-000004", "j-000003", "j-000002", "j-000001"));
}

TEST_P(CatalogJobsTest, TellsTheUnfinishedJobsOldestFirst) {
  std::vector<Job> jobs;
  for (const JobState state : {JobState::kSucceeded, JobState::kRunning, JobState::kFailed,
                               JobState::kCancelled, JobState::kQueued}) {
    Job job = catalog_->CreateJob(SomeJob("s"), {}, "", 1).value();
    job.state = state;
    ASSERT_THAT(catalog_->UpdateJob(job), IsOk());
    jobs.push_back(job);
  }

  const std::vector<Job> unfinished = catalog_->UnfinishedJobs().value();

  ASSERT_EQ(unfinished.size(), 2u);
  ExpectEqual(unfinished[0], jobs[1]);
  ExpectEqual(unfinished[1], jobs[4]);
}

TEST_P(CatalogJobsTest, HandsOutMoreTasksThanAPageInTheirOrder) {
  const Job job = catalog_->CreateJob(SomeJob("s"), {}, "", 1).value();
  for (const int64_t count : {999, 1000, 1001, 2000, 2500}) {
    std::vector<TaskRecord> tasks;
    for (int64_t number = 0; number < count; ++number) {
      tasks.push_back(SomeTask(3 * number));
    }
    ASSERT_THAT(testing::SaveTasks(*catalog_, job.id, tasks), IsOk());
    int64_t next = 0;
    ASSERT_THAT(catalog_->VisitTasks(job.id,
                                     [&](const TaskRecord& task) {
                                       EXPECT_EQ(task.number, 3 * next++);
                                       return absl::OkStatus();
                                     }),
                IsOk());
    EXPECT_EQ(next, count);
  }
}

TEST_P(CatalogJobsTest, KeepsGrantsAndTheRowsOfTheirJobs) {
  Job job = catalog_->CreateJob(SomeJob("s"), {}, "", 1).value();
  Advance(job);
  const JobTask granted{.job = job.id, .task = SomeTask(3)};

  ASSERT_THAT(catalog_->SaveGrants({{granted}}, {{job}}), IsOk());

  Reopen();
  ExpectEqual(catalog_->GetJob(job.id).value(), job);
  const std::vector<TaskRecord> tasks = testing::LoadTasks(*catalog_, job.id).value();
  ASSERT_EQ(tasks.size(), 1u);
  ExpectEqual(tasks[0], granted.task);
  const JobTask lost{.job = JobId{"j-000099"}, .task = SomeTask(3)};
  EXPECT_TRUE(absl::IsNotFound(catalog_->SaveGrants({{granted, lost}}, {})));
}

TEST_P(CatalogJobsTest, WritesOnAfterACallThatFailed) {
  const Job job = catalog_->CreateJob(SomeJob("s"), {}, "", 1).value();
  Completion completion{.job = job, .task = SomeTask(1), .ingested = {}, .action_key = "k"};
  completion.task.result = SomeResult();
  Job none = job;
  none.id = JobId{"j-000099"};
  const Completion lost{.job = none, .task = SomeTask(1), .ingested = {}, .action_key = "l"};
  for (int i = 0; i < 3; ++i) {
    EXPECT_TRUE(absl::IsNotFound(catalog_->SaveCompletions({{completion, lost}}, 1)));
    EXPECT_EQ(testing::LoadTasks(*catalog_, job.id)->size(), i == 0 ? 0u : 1u);
    EXPECT_THAT(catalog_->SaveCompletions({{completion}}, 1), IsOk());
    EXPECT_EQ(testing::LoadTasks(*catalog_, job.id)->size(), 1u);
  }
}

TEST_P(CatalogJobsTest, StartingOverForgetsAllOfTheTasksButTheirEpochs) {
  Job job = catalog_->CreateJob(SomeJob("s"), {}, "", 1).value();
  const Job other = catalog_->CreateJob(SomeJob("s"), {}, "", 1).value();
  TaskRecord done = SomeTask(3);
  done.result = SomeResult();
  ASSERT_THAT(testing::SaveTasks(*catalog_, job.id, {done, SomeTask(2)}), IsOk());
  ASSERT_THAT(testing::SaveTasks(*catalog_, other.id, {done}), IsOk());
  Advance(job);
  job.plan_version = 8;
  job.results_version = 9;

  ASSERT_THAT(catalog_->StartOver(job), IsOk());

  Reopen();
  ExpectEqual(catalog_->GetJob(job.id).value(), job);
  const std::vector<TaskRecord> tasks = testing::LoadTasks(*catalog_, job.id).value();
  ASSERT_EQ(tasks.size(), 2u);
  for (const TaskRecord& task : tasks) {
    TaskRecord expected;
    expected.number = task.number;
    expected.epoch = SomeTask(0).epoch;
    ExpectEqual(task, expected);
    EXPECT_FALSE(task.given_up);
  }
  ExpectEqual(testing::LoadTasks(*catalog_, other.id)->at(0), done);
  Job missing = job;
  missing.id = {"j-000099"};
  EXPECT_THAT(catalog_->StartOver(missing), StatusIs(absl::StatusCode::kNotFound, "j-000099"));
}

TEST_P(CatalogJobsTest, KeepsTasksAndWritesThemOver) {
  const Job job = catalog_->CreateJob(SomeJob("s"), {}, "", 1).value();
  ASSERT_THAT(testing::SaveTasks(*catalog_, job.id, {SomeTask(10), SomeTask(2)}), IsOk());
  TaskRecord done = SomeTask(2);
  done.epoch = 4'000'000'000;
  done.worker.clear();
  done.last_error.clear();
  done.result = SomeResult();
  ASSERT_THAT(testing::SaveTasks(*catalog_, job.id, {done}), IsOk());
  Reopen();

  const absl::StatusOr<std::vector<TaskRecord>> tasks = testing::LoadTasks(*catalog_, job.id);

  ASSERT_THAT(tasks, IsOk());
  ASSERT_EQ(tasks->size(), 2u);
  ExpectEqual((*tasks)[0], done);
  ExpectEqual((*tasks)[1], SomeTask(10));
}

TEST_P(CatalogJobsTest, SavesACompletionAsAWhole) {
  Job job = catalog_->CreateJob(SomeJob("s"), {}, "", 1).value();
  job.spec.position_bits = 18;
  Advance(job);
  TaskRecord task = SomeTask(1);
  task.result = SomeResult();

  ASSERT_THAT(catalog_->SaveCompletions(
                  {{Completion{job, task, {{Sha256::Of("raw"), SomeIngested("a")}}, "key"}}}, 1),
              IsOk());
  Reopen();

  ExpectEqual(catalog_->GetJob(job.id).value(), job);
  ExpectEqual(testing::LoadTasks(*catalog_, job.id).value().at(0), task);
  EXPECT_TRUE(catalog_->FindIngested(Sha256::Of("raw"), 18).value().has_value());
}

TEST_P(CatalogJobsTest, SavesNothingOfACompletionThatFailsInItsLastRow) {
  Job job = catalog_->CreateJob(SomeJob("s"), {}, "", 1).value();
  const Job before = job;
  Advance(job);
  TaskRecord task = SomeTask(1);
  task.result = SomeResult();
  IngestedMesh unspeakable = SomeIngested("b");
  unspeakable.health.warnings = {"\xff"};

  EXPECT_THAT(
      catalog_->SaveCompletions(
          {{Completion{job, SomeTask(2), {}, "key"},
            Completion{job,
                       task,
                       {{Sha256::Of("raw"), SomeIngested("a")}, {Sha256::Of("raw 2"), unspeakable}},
                       "key"}}},
          1),
      StatusIs(absl::StatusCode::kInvalidArgument, "UTF-8"));

  ExpectEqual(catalog_->GetJob(job.id).value(), before);
  EXPECT_TRUE(testing::LoadTasks(*catalog_, job.id).value().empty());
  EXPECT_FALSE(catalog_->FindIngested(Sha256::Of("raw"), 18).value().has_value());
  EXPECT_TRUE(catalog_->FindActions({"key"}).value().empty());
}

TEST_P(CatalogJobsTest, CreatesAJobOfAHundredThousandMeshesInSeconds) {
  std::vector<SetMesh> meshes(100'000, SomeMesh("a"));
  for (size_t i = 0; i < meshes.size(); ++i) {
    meshes[i].name = std::to_string(i);
  }
  const auto start = std::chrono::steady_clock::now();

  ASSERT_THAT(catalog_->CreateJob(SomeJob("s"), meshes, "", 1), IsOk());

  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  RecordProperty("seconds", std::to_string(seconds.count()));
  EXPECT_LT(seconds.count(), 10);
  EXPECT_EQ(catalog_->GetJobMeshes({"j-000001"}).value().at(99'999).mesh.name, "99999");
}

INSTANTIATE_TEST_SUITE_P(On, CatalogJobsTest, EachDatabase(), DatabaseName);

}  // namespace
}  // namespace cohort
