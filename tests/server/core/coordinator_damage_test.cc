// One damaged or missing file of any kind of blob, in the middle of a job and after it: the job
// ends with the same outputs or with an error that says what to do, never with another number.
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <absl/strings/str_cat.h>

#include "common/store/blob_damage.h"
#include "tests/server/core/store_fixture.h"

namespace cohort {
namespace {

using testing::DoneTask;
using ::testing::HasSubstr;
using testing::IsOk;
using testing::StatusIs;

/// The blobs of a result by the field that names them.
std::map<std::string, Digest> BlobsOf(const DoneTask& done) {
  std::map<std::string, Digest> blobs = {
      {"output", done.result.output}, {"second output", done.result.second_output},
      {"poses", done.result.poses},   {"variation", done.result.variation},
      {"fields", done.result.fields}, {"placed", done.result.placed}};
  if (!done.result.ingested.empty()) {
    blobs["canonical mesh"] = done.result.ingested[0].blob;
  }
  if (!done.result.copies.empty()) {
    blobs["symmetric copy"] = done.result.copies[0].blob;
  }
  std::erase_if(blobs, [](const auto& blob) { return blob.second.empty(); });
  return blobs;
}

/// A blob and the first task that makes it.
struct BlobOfJob {
  std::string what;  ///< "align 1, output".
  int64_t task = 0;
  Digest digest;
};

/// One of each kind: of each stage and field.
std::vector<BlobOfJob> OneOfEach(const std::vector<DoneTask>& tasks) {
  std::vector<BlobOfJob> blobs;
  std::set<std::string> seen;
  for (const DoneTask& done : tasks) {
    for (const auto& [field, digest] : BlobsOf(done)) {
      const std::string what = absl::StrCat(done.task.stage, ", ", field);
      if (seen.insert(what).second) {
        blobs.push_back({.what = what, .task = done.task.number, .digest = digest});
      }
    }
  }
  return blobs;
}

std::vector<Digest> AllOutputs(const JobOutputs& outputs) {
  std::vector<Digest> all = {outputs.mean_shape, outputs.summary, outputs.variation_shape,
                             outputs.base_choice};
  for (const auto* list : {&outputs.tiles, &outputs.alignments, &outputs.fields, &outputs.preview,
                           &outputs.poses, &outputs.signatures}) {
    all.insert(all.end(), list->begin(), list->end());
  }
  std::erase_if(all, [](const Digest& digest) { return digest.empty(); });
  return all;
}

class CoordinatorDamageTest : public testing::StoreFixture {
 protected:
  /// Runs a job undisturbed and remembers what it did.
  void RunCalmJob() {
    spec_ = EveryBlobSpec();
    calm_ = Submit(spec_, true);
    tasks_ = Work();
    ASSERT_EQ(coordinator_->GetJob(calm_.id)->state, JobState::kSucceeded)
        << coordinator_->GetJob(calm_.id)->error;
    expected_ = OutputsOf(calm_);
    matrix_ = MatrixOf(calm_).value();
  }

  absl::StatusOr<std::vector<double>> MatrixOf(const Job& job) {
    std::vector<double> values;
    const absl::Status read =
        coordinator_->GetMatrix(job.id, Metric::kRms, [&](const MatrixBlock& block) {
          values.insert(values.end(), block.values.begin(), block.values.end());
          return true;
        });
    if (!read.ok()) {
      return read;
    }
    return values;
  }

  /// Reads all outputs as clients do: through the store, which moves damaged ones aside.
  int CountLostOutputs(const Job& job) {
    int lost = 0;
    for (const Digest& digest : AllOutputs(coordinator_->GetOutputs(job.id).value())) {
      lost += store_->QuarantineIfUnreadable(digest).value() ? 1 : 0;
    }
    return lost;
  }

  /// The job has the results of the calm one, or its readers are told that they are lost, and a
  /// retry or the same job again makes them.
  enum class Remedy { kRetry, kSubmitAgain };
  void ExpectResultsOf(const Job& job, int most_tasks, Remedy remedy = Remedy::kRetry) {
    ASSERT_EQ(coordinator_->GetJob(job.id)->state, JobState::kSucceeded)
        << coordinator_->GetJob(job.id)->error;
    EXPECT_EQ(OutputsOf(job), expected_);
    const auto matrix = MatrixOf(job);
    if (matrix.ok()) {
      EXPECT_EQ(*matrix, matrix_);
    } else {
      EXPECT_EQ(ErrorReason(matrix.status()), "BLOB_DAMAGED");
      EXPECT_THAT(matrix, StatusIs(absl::StatusCode::kDataLoss, "cohort retry " + job.id.value));
    }
    if (CountLostOutputs(job) == 0 && matrix.ok()) {
      return;
    }
    done_ = 0;
    Job again = job;
    if (remedy == Remedy::kRetry) {
      ASSERT_THAT(coordinator_->RetryJob(job.id), IsOk());
    } else {
      again = Submit(spec_, false);
    }
    Work();
    EXPECT_EQ(coordinator_->GetJob(again.id)->state, JobState::kSucceeded);
    EXPECT_LE(done_, most_tasks) << "only what is lost";
    EXPECT_EQ(OutputsOf(again), expected_);
    EXPECT_EQ(MatrixOf(again).value(), matrix_);
    EXPECT_EQ(CountLostOutputs(again), 0);
  }

  JobSpec spec_;
  Job calm_;
  std::vector<DoneTask> tasks_;
  std::string expected_;
  std::vector<double> matrix_;
};

TEST_F(CoordinatorDamageTest, AJobHasABlobOfEveryKind) {
  RunCalmJob();
  std::vector<std::string> kinds;
  for (const BlobOfJob& blob : OneOfEach(tasks_)) {
    kinds.push_back(blob.what);
  }
  // Two alignments: poses and displacement come with the first, whose alignments are in its result;
  // the variation comes with the last.
  EXPECT_THAT(kinds, ::testing::IsSupersetOf(
                         {"ingest, canonical mesh", "align 1, poses", "align 1, second output",
                          "average 1, output", "align 2, output", "align 2, variation",
                          "align 2, second output", "align 2, fields", "compare, output",
                          "compare, fields", "preview, output", "summarize, output"}))
      << ::testing::PrintToString(kinds);
}

TEST_F(CoordinatorDamageTest, AnyBlobLostAsSoonAsItIsMadeIsMadeAgain) {
  RunCalmJob();
  for (const BlobOfJob& blob : OneOfEach(tasks_)) {
    for (const Damage damage : kDamages) {
      SCOPED_TRACE(absl::StrCat(blob.what, ", damage ", static_cast<int>(damage)));
      const Job job = Submit(spec_, true);
      Work([&](const DoneTask& done) { return done.task.number == blob.task; });
      Spoil(blob.digest, damage);
      Work();
      ExpectResultsOf(job, 1);
    }
  }
}

TEST_F(CoordinatorDamageTest, AnyBlobLostNearTheEndIsMadeAgainIfItIsReadAgain) {
  RunCalmJob();
  const int tasks = static_cast<int>(tasks_.size());
  for (const BlobOfJob& blob : OneOfEach(tasks_)) {
    SCOPED_TRACE(blob.what);
    const Job job = Submit(spec_, true);
    int left = tasks - 2;
    Work([&](const DoneTask&) { return --left == 0; });
    Spoil(blob.digest, Damage::kFlippedByte);
    done_ = 0;
    Work();
    EXPECT_LE(done_, 2 + 1) << "what is known is not done again";
    ExpectResultsOf(job, 1);
  }
}

TEST_F(CoordinatorDamageTest, ARestartBetweenDamageAndRepairChangesNothing) {
  RunCalmJob();
  for (const BlobOfJob& blob : OneOfEach(tasks_)) {
    SCOPED_TRACE(blob.what);
    const Job job = Submit(spec_, true);
    Work([&](const DoneTask& done) { return done.task.number == blob.task; });
    Spoil(blob.digest, Damage::kDeleted);
    const int failed = failed_;
    while (failed_ == failed && DoOne().has_value()) {
    }
    Restart();
    clock_.Advance(3600);  // No lease is left.
    Work();
    ExpectResultsOf(job, 1);
  }
}

TEST_F(CoordinatorDamageTest, AnyBlobLostAfterTheJobIsMadeAgainByTheSameJob) {
  RunCalmJob();
  for (const BlobOfJob& blob : OneOfEach(tasks_)) {
    for (const Damage damage : kDamages) {
      SCOPED_TRACE(absl::StrCat(blob.what, ", damage ", static_cast<int>(damage)));
      Spoil(blob.digest, damage);
      ExpectResultsOf(calm_, 1, Remedy::kSubmitAgain);
      // Intermediate blobs are no outputs: whoever reads them next finds the damage.
      ASSERT_THAT(store_->QuarantineIfUnreadable(blob.digest), IsOk());
      const Job again = Submit(spec_, false);
      Work();
      ExpectResultsOf(again, 1);
    }
  }
}

TEST_F(CoordinatorDamageTest, ARetryMakesAllThatIsLostAtOnce) {
  RunCalmJob();
  EXPECT_EQ(ErrorReason(coordinator_->RetryJob(calm_.id).status()), "JOB_NOT_FAILED")
      << "nothing is lost";
  for (const BlobOfJob& blob : OneOfEach(tasks_)) {
    Spoil(blob.digest, Damage::kFlippedByte);
  }
  EXPECT_THAT(MatrixOf(calm_), StatusIs(absl::StatusCode::kDataLoss, "cohort retry"));
  ASSERT_THAT(coordinator_->RetryJob(calm_.id), IsOk());
  Work();
  ASSERT_EQ(coordinator_->GetJob(calm_.id)->state, JobState::kSucceeded)
      << coordinator_->GetJob(calm_.id)->error;
  EXPECT_EQ(OutputsOf(calm_), expected_);
  EXPECT_EQ(MatrixOf(calm_).value(), matrix_);
  EXPECT_EQ(CountLostOutputs(calm_), 0);
}

TEST_F(CoordinatorDamageTest, WhatAJobKeepsOfAnotherIsMadeAgainByThatOne) {
  spec_ = EveryBlobSpec();
  spec_.pose = PoseMode::kPrincipalAxes;
  spec_.landmarks = {};
  spec_.preview = false;
  const Job first = Submit(spec_, true);
  Work();
  const std::vector<SetMesh> more = testing::PutDemoScans(*store_, kPeople + 1, 1, kVertices);
  ASSERT_THAT(coordinator_->AddMesh("set", more.back()), IsOk());
  JobSpec spec;
  spec.reference_job = first.id.value;
  const Job calm = Submit(spec, true);
  Work();
  ASSERT_EQ(coordinator_->GetJob(calm.id)->state, JobState::kSucceeded)
      << coordinator_->GetJob(calm.id)->error;
  const std::string expected = OutputsOf(calm);
  const std::vector<double> matrix = MatrixOf(calm).value();
  const JobOutputs own = coordinator_->GetOutputs(calm.id).value();
  const JobOutputs kept = coordinator_->GetOutputs(first.id).value();

  // Pairs of the first job, found by who reads the second.
  Spoil(kept.tiles.at(0), Damage::kFlippedByte);
  EXPECT_THAT(MatrixOf(calm), StatusIs(absl::StatusCode::kDataLoss, "retry " + first.id.value));
  ASSERT_THAT(coordinator_->RetryJob(first.id), IsOk());
  Work();
  EXPECT_EQ(MatrixOf(calm).value(), matrix);

  // Pairs and alignments of the second.
  for (const Digest& blob : {own.tiles.at(0), own.alignments.front(), own.alignments.back()}) {
    Spoil(blob, Damage::kCutShort);
    ASSERT_THAT(coordinator_->RetryJob(calm.id), IsOk());
    Work();
    EXPECT_EQ(coordinator_->GetJob(calm.id)->state, JobState::kSucceeded);
    EXPECT_EQ(OutputsOf(calm), expected);
    EXPECT_EQ(MatrixOf(calm).value(), matrix);
    EXPECT_EQ(CountLostOutputs(calm), 0);
  }

  // The frame itself, while a job needs it.
  const Job disturbed = Submit(spec, true);
  Spoil(kept.frame.reference, Damage::kDeleted);
  Work();
  EXPECT_THAT(coordinator_->GetJob(disturbed.id)->error, HasSubstr("retry " + first.id.value));
  ASSERT_THAT(coordinator_->RetryJob(first.id), IsOk());
  Work();
  ASSERT_THAT(coordinator_->RetryJob(disturbed.id), IsOk());
  Work();
  EXPECT_EQ(OutputsOf(disturbed), expected);
}

TEST_F(CoordinatorDamageTest, ALostMeshFileFailsTheJobUntilItIsAddedAgain) {
  RunCalmJob();
  const SetMesh& mesh = meshes_[1];
  const std::string bytes = store_->Get(mesh.raw).value();
  for (const Damage damage : kDamages) {
    SCOPED_TRACE(static_cast<int>(damage));
    const Job job = Submit(spec_, true);
    Spoil(mesh.raw, damage);
    Work();
    const Job failed = *coordinator_->GetJob(job.id);
    EXPECT_EQ(failed.state, JobState::kFailed);
    EXPECT_THAT(failed.error, HasSubstr("the file of mesh " + mesh.name));
    EXPECT_THAT(failed.error, HasSubstr("cohort add --set set"));
    EXPECT_THAT(*coordinator_->FindMissing({mesh.raw}), ::testing::ElementsAre(mesh.raw))
        << "cohort add sends it";

    ASSERT_THAT(store_->Put(bytes), IsOk());
    ASSERT_THAT(coordinator_->RetryJob(job.id), IsOk());
    Work();
    ExpectResultsOf(job, 0);
  }
}

TEST_F(CoordinatorDamageTest, AMeshFileThatNobodyReadsAgainIsNotMissed) {
  RunCalmJob();
  const Job job = Submit(spec_, true);
  Work([](const DoneTask& done) { return done.task.kind != TaskKind::kIngest; });
  Spoil(meshes_[0].raw, Damage::kDeleted);
  Work();
  ExpectResultsOf(job, 0);
}

TEST_F(CoordinatorDamageTest, LostLandmarksFailTheJobUntilTheyAreSentAgain) {
  RunCalmJob();
  const std::string bytes = store_->Get(spec_.landmarks).value();
  for (const Damage damage : kDamages) {
    SCOPED_TRACE(static_cast<int>(damage));
    const Job job = Submit(spec_, true);
    Spoil(spec_.landmarks, damage);
    Work();
    const Job failed = *coordinator_->GetJob(job.id);
    EXPECT_EQ(failed.state, JobState::kFailed);
    EXPECT_THAT(failed.error, HasSubstr("landmarks"));
    EXPECT_THAT(failed.error, HasSubstr("submit the job again with the same landmark files"));
    EXPECT_EQ(ErrorReason(coordinator_->CreateJob("set", spec_, "").status()), "BLOB_MISSING");

    ASSERT_THAT(store_->Put(bytes), IsOk());
    ASSERT_THAT(coordinator_->RetryJob(job.id), IsOk());
    Work();
    ExpectResultsOf(job, 0);
  }
}

TEST_F(CoordinatorDamageTest, ADiskThatKeepsNothingEndsTheJobWithItsName) {
  RunCalmJob();
  const Job job = Submit(spec_, true);
  const auto made = Work([](const DoneTask& done) { return done.task.kind == TaskKind::kAverage; });
  const Digest mean = made.back().result.output;
  // Whenever it has been made, it is damaged again.
  for (int i = 0; i < 20 && !IsFinal(coordinator_->GetJob(job.id)->state); ++i) {
    if (store_->Contains(mean).value()) {
      Spoil(mean, Damage::kFlippedByte);
    }
    for (int tasks = 0; tasks < 2; ++tasks) {
      DoOne();
      clock_.Advance(5);
    }
  }
  const Job failed = *coordinator_->GetJob(job.id);
  EXPECT_EQ(failed.state, JobState::kFailed);
  EXPECT_THAT(failed.error, HasSubstr(mean.Hex()));
  EXPECT_THAT(failed.error, HasSubstr("check the disk"));
}

TEST_F(CoordinatorDamageTest, AWorkerThatSeesAnotherStoreFailsOnItsOwn) {
  RunCalmJob();
  const Job job = Submit(spec_, true);
  for (int i = 0; i < 20 && !IsFinal(coordinator_->GetJob(job.id)->state); ++i) {
    for (const GrantedTask& granted : Take(1)) {
      const Digest blob = granted.task.meshes[0].blob;  // The server has it.
      ASSERT_THAT(coordinator_->FailTask(
                      WorkerId{"w"}, granted.lease,
                      WithUnreadableBlob(absl::NotFoundError("blob is not in /elsewhere"), blob)),
                  IsOk());
    }
    clock_.Advance(60);
  }
  const Job failed = *coordinator_->GetJob(job.id);
  EXPECT_EQ(failed.state, JobState::kFailed) << "not tried for ever";
  EXPECT_THAT(failed.error, HasSubstr("/elsewhere"));
  EXPECT_THAT(store_->Contains(meshes_[0].raw), testing::IsOkAndHolds(true));
}

TEST_F(CoordinatorDamageTest, ALateReportAboutALostBlobChangesNothing) {
  RunCalmJob();
  const Job job = Submit(spec_, true);
  const auto granted = Take(1);
  ASSERT_EQ(granted.size(), 1U);
  ASSERT_THAT(coordinator_->CancelJob(job.id), IsOk());
  EXPECT_THAT(coordinator_->FailTask(
                  WorkerId{"w"}, granted[0].lease,
                  WithUnreadableBlob(absl::NotFoundError("gone"), Sha256::Of("no such blob"))),
              IsOk());
  EXPECT_EQ(coordinator_->GetJob(job.id)->state, JobState::kCancelled);
}

}  // namespace
}  // namespace cohort
