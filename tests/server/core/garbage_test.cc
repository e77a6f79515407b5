// What a collection of garbage takes and what it never takes.
#include "server/core/garbage.h"

#include <chrono>
#include <map>
#include <random>
#include <set>
#include <string>

#include "tests/server/core/store_fixture.h"

namespace cohort {
namespace {

using testing::IsOk;
using testing::IsOkAndHolds;
using testing::StatusIs;

constexpr double kDay = 24 * 3600;
/// Everything that no row names, however young; nothing is remembered for jobs to come.
constexpr GarbageOptions kAtOnce{.age_seconds = 0, .remember_seconds = 0};

class GarbageTest : public testing::StoreFixture {
 protected:
  std::set<Digest> Blobs() {
    std::set<Digest> blobs;
    EXPECT_THAT(store_->Visit([&](const StoredBlob& blob) {
      blobs.insert(blob.digest);
      return absl::OkStatus();
    }),
                IsOk());
    return blobs;
  }
  void MakeOld(const Digest& digest) {
    std::filesystem::last_write_time(
        FileOf(digest), std::filesystem::file_time_type::clock::now() - std::chrono::hours(25));
  }
  void Collect() {
    ++collections_;
    ASSERT_THAT(coordinator_->CollectGarbage(kAtOnce), IsOk());
  }
  /// All that earlier jobs made is gone: nothing but a new job's rows keeps its blobs.
  void ForgetAll() {
    const Page<Job> earlier = coordinator_->ListJobs(100, "").value();
    for (const Job& old : earlier.items) {
      ASSERT_THAT(coordinator_->DeleteJob(old.id), IsOk());
    }
    Collect();
  }
  /// Before a report it hurts: the task's outputs are in no row. Not again before the task is done:
  /// three failures end a task.
  void WorkWhileCollecting(std::mt19937& random) {
    bool may_hurt = true;
    for (int idle = 0; idle < 5;) {
      const int failed = failed_;
      const auto done = DoOne([&] {
        if (may_hurt && random() % 3 == 0) {
          Collect();
        }
      });
      may_hurt = failed_ == failed;
      idle = done || !may_hurt ? 0 : idle + 1;
      clock_.Advance(5);
      if (random() % 3 == 0) {
        Collect();
      }
    }
  }

  int collections_ = 0;
};

TEST_F(GarbageTest, TakesOldBlobsThatNothingNamesAndNoOthers) {
  const Digest old = store_->Put("old garbage").value();
  const Digest young = store_->Put("young garbage").value();
  MakeOld(old);
  for (const SetMesh& mesh : meshes_) {
    MakeOld(mesh.raw);
  }

  const GarbageCount count = coordinator_->CollectGarbage({}).value();

  EXPECT_EQ(count.blobs, 1);
  EXPECT_EQ(count.bytes, 11);
  EXPECT_EQ(count.kept_blobs, 4);
  EXPECT_THAT(store_->Contains(old), IsOkAndHolds(false));
  EXPECT_THAT(store_->Contains(young), IsOkAndHolds(true));
  for (const SetMesh& mesh : meshes_) {
    EXPECT_THAT(store_->Contains(mesh.raw), IsOkAndHolds(true));
  }
}

TEST_F(GarbageTest, WhoeverWasToldThatABlobIsThereMayCountOnIt) {
  const Digest mesh = store_->Put("a mesh of old").value();
  MakeOld(mesh);
  ASSERT_TRUE(coordinator_->FindMissing({mesh})->empty());
  EXPECT_EQ(coordinator_->CollectGarbage({})->blobs, 0);
  SetMesh added;
  added.name = "z.ply";
  added.raw = mesh;
  added.size_bytes = 13;
  EXPECT_THAT(coordinator_->AddMesh("set", added), IsOk());
}

TEST_F(GarbageTest, LeavesAllThatAFinishedJobAndItsRememberedResultsName) {
  const Job job = Submit(EveryBlobSpec(), false);
  Work();
  const std::set<Digest> before = Blobs();
  EXPECT_EQ(coordinator_->CollectGarbage({.age_seconds = 0})->blobs, 0);
  EXPECT_EQ(Blobs(), before);
  EXPECT_EQ(Submit(EveryBlobSpec(), false).state, JobState::kSucceeded);
}

TEST_F(GarbageTest, ADeletedJobsBlobsGoOnceItsResultsAreForgotten) {
  const Job job = Submit(EveryBlobSpec(), false);
  Work();
  ASSERT_THAT(coordinator_->DeleteJob(job.id), IsOk());
  EXPECT_EQ(coordinator_->CollectGarbage({.age_seconds = 0})->blobs, 1) << "its landmarks";
  clock_.Advance(100 * kDay);

  const GarbageCount count = coordinator_->CollectGarbage({.age_seconds = 0}).value();

  EXPECT_GT(count.blobs, 10);
  // The files of the set, and what ingest made of them, as long as the set has them.
  EXPECT_EQ(count.kept_blobs, 2 * kPeople);
  ASSERT_THAT(coordinator_->DeleteSet("set"), IsOk());
  EXPECT_EQ(coordinator_->CollectGarbage({.age_seconds = 0})->blobs, 2 * kPeople);
  EXPECT_TRUE(Blobs().empty());
}

TEST_F(GarbageTest, AtAnyTimeItCostsAtMostSomeWork) {
  const Job calm = Submit(EveryBlobSpec(), true);
  Work();
  const std::string expected = OutputsOf(calm);
  for (uint32_t seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE(seed);
    ForgetAll();
    std::mt19937 random(seed);
    const Job job = Submit(EveryBlobSpec(), true);
    WorkWhileCollecting(random);
    ASSERT_EQ(coordinator_->GetJob(job.id)->state, JobState::kSucceeded)
        << coordinator_->GetJob(job.id)->error;
    EXPECT_EQ(OutputsOf(job), expected);
    const JobOutputs outputs = coordinator_->GetOutputs(job.id).value();
    for (const Digest& tile : outputs.tiles) {
      EXPECT_THAT(store_->Get(tile), IsOk());
    }
  }
  EXPECT_GT(failed_, 0) << "it did hurt";
  EXPECT_GT(collections_, 25);
}

TEST_F(GarbageTest, RefusesAnAgeThatIsNone) {
  EXPECT_THAT(coordinator_->CollectGarbage({.age_seconds = -1}),
              StatusIs(absl::StatusCode::kInvalidArgument, "-1"));
}

}  // namespace
}  // namespace cohort
