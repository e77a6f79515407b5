// What is taken out of the catalog, and which blobs it still refers to.

#include <set>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/error_reason.h"
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
using testing::SomeTask;
using testing::StatusIs;
using ::testing::UnorderedElementsAreArray;

class CatalogDeletionTest : public CatalogTest {
 protected:
  Job FinishedJob() {
    Job job = catalog_->CreateJob(SomeJob("s"), {SomeMesh("a")}, "request", 1).value();
    EXPECT_THAT(testing::SaveTasks(*catalog_, job.id, {SomeTask(1), SomeTask(2)}), IsOk());
    job.state = JobState::kSucceeded;
    EXPECT_THAT(catalog_->UpdateJob(job), IsOk());
    return job;
  }
  std::set<std::string> Blobs() {
    std::set<std::string> blobs;
    EXPECT_THAT(catalog_->VisitBlobs([&](const Digest& digest) {
      blobs.insert(digest.Hex());
      return absl::OkStatus();
    }),
                IsOk());
    return blobs;
  }
};

TEST_P(CatalogDeletionTest, DeletesAJobAndNeverNamesItAgain) {
  const Job kept = catalog_->CreateJob(SomeJob("s"), {SomeMesh("a")}, "", 1).value();
  ASSERT_THAT(testing::SaveTasks(*catalog_, kept.id, {SomeTask(1)}), IsOk());
  const Job job = FinishedJob();

  ASSERT_THAT(catalog_->DeleteJob(job.id), IsOk());
  Reopen();

  EXPECT_THAT(catalog_->GetJob(job.id), StatusIs(absl::StatusCode::kNotFound, job.id.value));
  EXPECT_THAT(catalog_->DeleteJob(job.id), StatusIs(absl::StatusCode::kNotFound, job.id.value));
  EXPECT_EQ(testing::LoadTasks(*catalog_, kept.id)->size(), 1u);
  EXPECT_EQ(catalog_->GetJobMeshes(kept.id)->size(), 1u);
  EXPECT_EQ(FinishedJob().id.value, "j-000003");
}

TEST_P(CatalogDeletionTest, RefusesToDeleteAJobThatIsNotFinished) {
  const Job job = catalog_->CreateJob(SomeJob("s"), {SomeMesh("a")}, "", 1).value();

  const absl::Status status = catalog_->DeleteJob(job.id);

  EXPECT_THAT(status, StatusIs(absl::StatusCode::kFailedPrecondition, "j-000001 is queued"));
  EXPECT_EQ(ErrorReason(status), "JOB_NOT_FINISHED");
  EXPECT_EQ(catalog_->GetJobMeshes(job.id)->size(), 1u);
}

TEST_P(CatalogDeletionTest, RemovesAMeshFromItsSetButNotFromJobs) {
  ASSERT_THAT(catalog_->AddMesh("s", SomeMesh("a")), IsOk());
  ASSERT_THAT(catalog_->AddMesh("s", SomeMesh("b")), IsOk());
  ASSERT_THAT(catalog_->AddMesh("t", SomeMesh("a")), IsOk());
  const Job job = FinishedJob();

  ASSERT_THAT(catalog_->RemoveMesh("s", "a"), IsOk());

  ASSERT_EQ(catalog_->ListMeshes("s", 9, "")->items.size(), 1u);
  EXPECT_EQ(catalog_->ListMeshes("s", 9, "")->items[0].name, "b");
  EXPECT_EQ(catalog_->ListMeshes("t", 9, "")->items.size(), 1u);
  EXPECT_EQ(catalog_->GetJobMeshes(job.id)->size(), 1u);
  EXPECT_THAT(catalog_->RemoveMesh("s", "a"),
              StatusIs(absl::StatusCode::kNotFound, "set 's' has no mesh 'a'"));
  EXPECT_THAT(catalog_->RemoveMesh("x", "a"), StatusIs(absl::StatusCode::kNotFound, "'x'"));
}

TEST_P(CatalogDeletionTest, DeletesASetWithItsMeshesOnly) {
  ASSERT_THAT(catalog_->AddMesh("s", SomeMesh("a")), IsOk());
  ASSERT_THAT(catalog_->AddMesh("s", SomeMesh("b")), IsOk());
  ASSERT_THAT(catalog_->AddMesh("t", SomeMesh("a")), IsOk());

  ASSERT_THAT(catalog_->DeleteSet("s"), IsOk());

  ASSERT_EQ(catalog_->ListSets(9, "")->items.size(), 1u);
  EXPECT_EQ(catalog_->ListSets(9, "")->items[0].name, "t");
  EXPECT_THAT(catalog_->DeleteSet("s"), StatusIs(absl::StatusCode::kNotFound, "no set 's'"));
}

TEST_P(CatalogDeletionTest, ForgetsWhatIngestMadeOfFilesThatAreNoMore) {
  ASSERT_THAT(catalog_->AddMesh("s", SomeMesh("in a set")), IsOk());
  ASSERT_THAT(catalog_->CreateJob(SomeJob("s"), {SomeMesh("in a job")}, "", 1), IsOk());
  for (const char* name : {"in a set", "in a job", "in none"}) {
    ASSERT_THAT(catalog_->RecordIngested(SomeMesh(name).raw, 18, SomeIngested(name)), IsOk());
  }

  EXPECT_EQ(catalog_->ForgetUnusedIngested().value(), 1);

  EXPECT_TRUE(catalog_->FindIngested(SomeMesh("in a set").raw, 18)->has_value());
  EXPECT_TRUE(catalog_->FindIngested(SomeMesh("in a job").raw, 18)->has_value());
  EXPECT_FALSE(catalog_->FindIngested(SomeMesh("in none").raw, 18)->has_value());
}

TEST_P(CatalogDeletionTest, TellsEveryBlobThatARowRefersTo) {
  std::vector<std::string> expected;
  const auto blob = [&expected](const std::string& name) {
    expected.push_back(Sha256::Of("blob " + name).Hex());
    return Sha256::Of("blob " + name);
  };
  const auto result_with_blobs = [&blob](const std::string& of) {
    TaskResult result;
    result.output = blob(of + " output");
    result.second_output = blob(of + " second");
    result.placed = blob(of + " placed");
    result.fields = blob(of + " fields");
    result.ingested.emplace_back().blob = blob(of + " ingested");
    result.copies.emplace_back().blob = blob(of + " copy");
    return result;
  };
  SetMesh mesh = SomeMesh("a");
  mesh.raw = blob("raw of the set");
  ASSERT_THAT(catalog_->AddMesh("s", mesh), IsOk());
  mesh.raw = blob("raw of the job");
  Job job = SomeJob("s");
  job.spec.landmarks = blob("landmarks");
  job = catalog_->CreateJob(job, {mesh}, "", 1).value();
  IngestedMesh ingested;
  ingested.blob = blob("ingested");
  Completion completion{.job = job,
                        .task = SomeTask(1),
                        .ingested = {{Sha256::Of("not a blob we need"), ingested}},
                        .action_key = Sha256::Of("no blob").Hex()};
  completion.task.result = result_with_blobs("action");
  ASSERT_THAT(catalog_->SaveCompletions({{completion}}, 1), IsOk());
  completion.task.result = result_with_blobs("task");
  completion.action_key.clear();
  ASSERT_THAT(catalog_->SaveCompletions({{completion}}, 1), IsOk());
  std::vector<JobMesh> meshes = catalog_->GetJobMeshes(job.id).value();
  meshes[0].ingested.emplace().blob = blob("mesh of the job");
  meshes[0].copy.emplace().blob = blob("copy of the job");
  JobOutputs outputs;
  outputs.tiles = {blob("tile 1"), blob("tile 2")};
  outputs.alignments = {blob("alignment")};
  outputs.mean_shape = blob("mean");
  outputs.summary = blob("summary");
  outputs.variation_shape = blob("variation");
  outputs.fields = {blob("field")};
  outputs.base_choice = blob("base");
  outputs.preview = {blob("preview")};
  outputs.frame.reference = blob("frame");
  ImportedPairs& imported = outputs.imported.emplace_back();
  imported.tiles = {blob("imported tile")};
  imported.fields = {blob("imported field")};
  imported.mesh_of = {0, -1};
  outputs.poses = {blob("pose")};
  ASSERT_THAT(catalog_->FinishJob(job, outputs, meshes), IsOk());

  EXPECT_THAT(Blobs(), UnorderedElementsAreArray(expected));
}

TEST_P(CatalogDeletionTest, TellsTheBlobsOfManyPagesOfRows) {
  std::vector<SetMesh> meshes(3'001, SomeMesh("a"));
  for (size_t i = 0; i < meshes.size(); ++i) {
    meshes[i].raw = Sha256::Of(std::to_string(i));
  }
  ASSERT_THAT(catalog_->CreateJob(SomeJob("s"), meshes, "", 1), IsOk());
  ASSERT_THAT(catalog_->CreateJob(SomeJob("s"), {SomeMesh("another")}, "", 1), IsOk());

  EXPECT_EQ(Blobs().size(), 3'002u);
}

TEST_P(CatalogDeletionTest, EndsTheWalkOverBlobsWithTheVisitorsError) {
  ASSERT_THAT(catalog_->AddMesh("s", SomeMesh("a")), IsOk());
  ASSERT_THAT(catalog_->AddMesh("s", SomeMesh("b")), IsOk());
  int visits = 0;

  const absl::Status status = catalog_->VisitBlobs([&](const Digest&) {
    ++visits;
    return absl::CancelledError("enough");
  });

  EXPECT_THAT(status, StatusIs(absl::StatusCode::kCancelled, "enough"));
  EXPECT_EQ(visits, 1);
}

TEST_P(CatalogDeletionTest, LetsAVisitorUseTheCatalog) {
  ASSERT_THAT(catalog_->AddMesh("s", SomeMesh("a")), IsOk());

  EXPECT_THAT(catalog_->VisitBlobs([&](const Digest&) { return catalog_->DeleteSet("s"); }),
              IsOk());
}

INSTANTIATE_TEST_SUITE_P(On, CatalogDeletionTest, EachDatabase(), DatabaseName);

}  // namespace
}  // namespace cohort
