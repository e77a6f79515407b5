// A catalog of the first build, row by row as that build wrote it, opened by this one.

#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/catalog/catalog.h"
#include "server/catalog/schema.h"
#include "tests/server/catalog/catalog_fixture.h"

namespace cohort {
namespace {

using testing::FileCatalogTest;
using testing::IsOk;
using testing::SomeIngested;
using testing::SomeMesh;
using testing::SomeTask;

class CatalogMigrationTest : public FileCatalogTest {
 protected:
  /// Puts the first build's catalog in place of the new one, still closed.
  void StartWithTheFirstCatalog() {
    catalog_.reset();
    std::filesystem::remove(File());
    testing::MakeFirstCatalog(File());
    ASSERT_EQ(UserVersion(), 1);
  }

  [[nodiscard]] int UserVersion() const {
    sqlite3* database = nullptr;
    sqlite3_stmt* statement = nullptr;
    EXPECT_EQ(sqlite3_open(File().c_str(), &database), SQLITE_OK);
    EXPECT_EQ(sqlite3_prepare_v2(database, "PRAGMA user_version", -1, &statement, nullptr),
              SQLITE_OK);
    EXPECT_EQ(sqlite3_step(statement), SQLITE_ROW);
    const int version = sqlite3_column_int(statement, 0);
    sqlite3_finalize(statement);
    sqlite3_close(database);
    return version;
  }
};

TEST_F(CatalogMigrationTest, ReadsTheSetsAndWhatIngestMadeOfThem) {
  StartWithTheFirstCatalog();
  Reopen();

  const Page<SetMesh> page = catalog_->ListMeshes("faces", 9, "").value();
  ASSERT_EQ(page.items.size(), 2u);
  EXPECT_EQ(page.items[0].raw, SomeMesh("a.ply").raw);
  EXPECT_EQ(page.items[1].labels, SomeMesh("b.ply").labels);
  const auto ingested = catalog_->FindIngested(SomeMesh("a.ply").raw, 18).value();
  ASSERT_TRUE(ingested.has_value());
  EXPECT_EQ(ingested->blob, SomeIngested("a").blob);
  EXPECT_EQ(ingested->centroid, SomeIngested("a").centroid);
  EXPECT_EQ(ingested->health.warnings, SomeIngested("a").health.warnings);
}

TEST_F(CatalogMigrationTest, ReadsAJobThatRunsAndItsTasks) {
  StartWithTheFirstCatalog();
  Reopen();

  const std::vector<Job> unfinished = catalog_->UnfinishedJobs().value();
  ASSERT_EQ(unfinished.size(), 1u);
  const Job& job = unfinished[0];
  EXPECT_EQ(job.id.value, "j-000001");
  EXPECT_EQ(job.spec.rounds, 7);
  EXPECT_EQ(job.spec.base, "b.ply");
  EXPECT_EQ(job.spec.icp.max_iterations, 200);
  EXPECT_EQ(job.spec.icp.scale_mode, ScaleMode::kFree);  // "free" then, "least-squares" now.
  // What that build did not know means what it did.
  EXPECT_EQ(job.spec.arithmetic, Arithmetic::kExact);
  EXPECT_TRUE(job.spec.landmarks.empty());
  EXPECT_EQ(job.version, 5);
  EXPECT_EQ(job.plan_version, 0);
  EXPECT_EQ(job.results_version, 0);
  EXPECT_EQ(job.progress.stage, "align 1");
  EXPECT_EQ(job.progress.cost_total, 2);
  EXPECT_TRUE(job.progress.stages.empty());
  EXPECT_EQ(job.counters.align.lookups, 123'456'789'012);
  const std::vector<TaskRecord> tasks = testing::LoadTasks(*catalog_, job.id).value();
  ASSERT_EQ(tasks.size(), 2u);
  EXPECT_EQ(tasks[0].result->output, Sha256::Of("output"));
  EXPECT_EQ(tasks[0].result->ingested.size(), 2u);
  EXPECT_TRUE(tasks[0].result->placed.empty());
  EXPECT_FALSE(tasks[1].result.has_value());
  EXPECT_EQ(tasks[1].last_error, SomeTask(2).last_error);
}

TEST_F(CatalogMigrationTest, ReadsAFinishedJobAndItsOutputs) {
  StartWithTheFirstCatalog();
  Reopen();

  EXPECT_EQ(catalog_->GetJob({"j-000002"})->state, JobState::kSucceeded);
  const JobOutputs outputs = catalog_->GetOutputs({"j-000002"}).value();
  EXPECT_EQ(outputs.tiles, std::vector<Digest>{Sha256::Of("tile")});
  EXPECT_EQ(outputs.summary, Sha256::Of("summary"));
  EXPECT_TRUE(outputs.poses.empty());
  const std::vector<JobMesh> meshes = catalog_->GetJobMeshes({"j-000002"}).value();
  ASSERT_EQ(meshes.size(), 2u);
  EXPECT_EQ(meshes[0].ingested->blob, SomeIngested("a").blob);
  EXPECT_EQ(meshes[1].rejection, "line 7: NaN");
}

TEST_F(CatalogMigrationTest, GoesOnInANewerVersionAndStaysThere) {
  StartWithTheFirstCatalog();
  Reopen();

  Completion completion{.job = catalog_->GetJob({"j-000001"}).value(),
                        .task = SomeTask(2),
                        .ingested = {},
                        .action_key = "key"};
  completion.task.result = TaskResult();
  ASSERT_THAT(catalog_->SaveCompletions({{completion}}, 1), IsOk());
  Reopen();
  EXPECT_EQ(catalog_->FindActions({"key"})->size(), 1u);
  EXPECT_EQ(catalog_->CreateJob(testing::SomeJob("faces"), {}, "", 1)->id.value, "j-000003");
  catalog_.reset();

  EXPECT_EQ(UserVersion(), static_cast<int>(SchemaMigrations().size()));
}

}  // namespace
}  // namespace cohort
