// What every managed store promises, held against both.
#include "common/store/managed_blob_store.h"

#include <sys/stat.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/error_reason.h"
#include "common/store/blob_damage.h"
#include "common/store/directory_blob_store.h"
#include "common/store/memory_blob_store.h"
#include "tests/common/store/scratch_folder.h"
#include "tests/testing/fake_clock.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

namespace fs = std::filesystem;

using testing::IsOk;
using testing::IsOkAndHolds;
using testing::StatusIs;

constexpr double kDay = 24 * 3600;

enum class Kind { kMemory, kDirectory };

class ManagedBlobStoreTest : public ::testing::TestWithParam<Kind> {
 protected:
  ManagedBlobStoreTest() {
    if (GetParam() == Kind::kMemory) {
      store_ = std::make_unique<MemoryBlobStore>(clock_);
    } else {
      store_ = DirectoryBlobStore::Create(folder_.Path()).value();
    }
  }

  /// As if the blob had been written that long ago.
  void Age(const Digest& digest, double seconds) {
    if (GetParam() == Kind::kMemory) {
      clock_.Advance(seconds);  // All blobs age; tests put the young ones afterwards.
      return;
    }
    const fs::path file = folder_.Path() / "sha256" / digest.Hex().substr(0, 2) / digest.Hex();
    fs::last_write_time(
        file, fs::last_write_time(file) - std::chrono::seconds(static_cast<int64_t>(seconds)));
  }

  std::map<Digest, StoredBlob> List() {
    std::map<Digest, StoredBlob> blobs;
    EXPECT_THAT(store_->Visit([&](const StoredBlob& blob) {
      blobs[blob.digest] = blob;
      return absl::OkStatus();
    }),
                IsOk());
    return blobs;
  }

  testing::ScratchFolder folder_;
  testing::FakeClock clock_;
  std::unique_ptr<ManagedBlobStore> store_;
};

INSTANTIATE_TEST_SUITE_P(Stores,
                         ManagedBlobStoreTest,
                         ::testing::Values(Kind::kMemory, Kind::kDirectory),
                         [](const auto& kind) {
                           return kind.param == Kind::kMemory ? "Memory" : "Directory";
                         });

TEST_P(ManagedBlobStoreTest, TellsEveryBlobWithSizeAndAge) {
  const Digest old = store_->Put("four").value();
  Age(old, 2 * kDay);
  const Digest young = store_->Put("sixsix").value();

  const auto blobs = List();

  ASSERT_EQ(blobs.size(), 2U);
  EXPECT_EQ(blobs.at(old).size_bytes, 4);
  EXPECT_NEAR(blobs.at(old).age_seconds, 2 * kDay, 60);
  EXPECT_EQ(blobs.at(young).size_bytes, 6);
  EXPECT_LT(blobs.at(young).age_seconds, 60);
}

TEST_P(ManagedBlobStoreTest, AVisitEndsAtTheFirstErrorAndMayRemove) {
  for (const char* bytes : {"a", "b", "c"}) {
    ASSERT_THAT(store_->Put(bytes), IsOk());
  }
  int seen = 0;
  EXPECT_THAT(store_->Visit([&](const StoredBlob&) {
    ++seen;
    return absl::AbortedError("enough");
  }),
              StatusIs(absl::StatusCode::kAborted, "enough"));
  EXPECT_EQ(seen, 1);
  EXPECT_THAT(store_->Visit([&](const StoredBlob& blob) { return store_->Remove(blob.digest); }),
              IsOk());
  EXPECT_TRUE(List().empty());
}

TEST_P(ManagedBlobStoreTest, RemovesOnlyWhatIsOldEnough) {
  const Digest blob = store_->Put("abc").value();

  EXPECT_THAT(store_->RemoveIfOlder(blob, kDay), IsOkAndHolds(false));
  EXPECT_THAT(store_->Get(blob), IsOkAndHolds(std::string("abc")));
  Age(blob, kDay + 60);
  EXPECT_THAT(store_->RemoveIfOlder(blob, kDay), IsOkAndHolds(true));
  EXPECT_THAT(store_->Get(blob), StatusIs(absl::StatusCode::kNotFound, blob.Hex()));
  EXPECT_THAT(store_->RemoveIfOlder(blob, kDay), IsOkAndHolds(false)) << "it is gone";
}

TEST_P(ManagedBlobStoreTest, ABlobPutAgainOrRenewedIsYoung) {
  const Digest put = store_->Put("put").value();
  const Digest renewed = store_->Put("renewed").value();
  Age(put, 2 * kDay);
  if (GetParam() == Kind::kDirectory) {
    Age(renewed, 2 * kDay);
  }

  ASSERT_THAT(store_->Put("put"), IsOk());
  EXPECT_THAT(store_->Renew(renewed), IsOkAndHolds(true));

  EXPECT_THAT(store_->RemoveIfOlder(put, kDay), IsOkAndHolds(false));
  EXPECT_THAT(store_->RemoveIfOlder(renewed, kDay), IsOkAndHolds(false));
  EXPECT_THAT(store_->Renew(Sha256::Of("never put")), IsOkAndHolds(false));
}

TEST_P(ManagedBlobStoreTest, KnowsItsSpace) {
  const StoreSpace space = store_->Space().value();

  EXPECT_GT(space.free_bytes, 0);
  EXPECT_GE(space.total_bytes, space.free_bytes);
}

TEST_P(ManagedBlobStoreTest, ReportsABlobThatIsMissingAndLeavesAGoodOneAlone) {
  const Digest blob = store_->Put("abc").value();
  const Digest missing = Sha256::Of("never put");

  EXPECT_THAT(store_->QuarantineIfUnreadable(missing), IsOkAndHolds(true));
  EXPECT_THAT(store_->QuarantineIfUnreadable(blob), IsOkAndHolds(false));
  EXPECT_THAT(store_->Get(blob), IsOkAndHolds(std::string("abc")));
  EXPECT_EQ(UnreadableBlob(store_->Get(missing).status()), missing);
}

TEST_P(ManagedBlobStoreTest, AnUploadGoesOnWhereItWasCutOff) {
  const Digest digest = Sha256::Of("abcdefgh");
  EXPECT_THAT(store_->UploadedBytes(digest), IsOkAndHolds(0));
  {
    const auto writer = store_->ResumePut(digest, 0).value();
    ASSERT_THAT(writer->Append("abc"), IsOk());
  }

  EXPECT_THAT(store_->UploadedBytes(digest), IsOkAndHolds(3));
  EXPECT_THAT(store_->Contains(digest), IsOkAndHolds(false));
  const auto writer = store_->ResumePut(digest, 3).value();
  ASSERT_THAT(writer->Append("defgh"), IsOk());
  EXPECT_THAT(writer->Commit(), IsOkAndHolds(digest));
  EXPECT_THAT(store_->Get(digest), IsOkAndHolds(std::string("abcdefgh")));
  EXPECT_THAT(store_->UploadedBytes(digest), IsOkAndHolds(0));
}

TEST_P(ManagedBlobStoreTest, RefusesAnUploadAtTheWrongOffset) {
  const Digest digest = Sha256::Of("abcdefgh");
  ASSERT_THAT(store_->ResumePut(digest, 0).value()->Append("abc"), IsOk());

  for (const int64_t offset : {0, 2, 4}) {
    const auto refused = store_->ResumePut(digest, offset);
    EXPECT_THAT(refused, StatusIs(absl::StatusCode::kOutOfRange, "at byte 3"));
    EXPECT_EQ(ErrorReason(refused.status()), "WRONG_OFFSET");
  }
}

TEST_P(ManagedBlobStoreTest, AnUploadOfOtherBytesLeavesNothing) {
  const Digest digest = Sha256::Of("abcdefgh");
  {
    const auto writer = store_->ResumePut(digest, 0).value();
    ASSERT_THAT(writer->Append("abcdefgX"), IsOk());

    const auto committed = writer->Commit();

    EXPECT_THAT(committed, StatusIs(absl::StatusCode::kDataLoss, digest.Hex()));
    EXPECT_EQ(ErrorReason(committed.status()), "UPLOAD_DAMAGED");
  }
  EXPECT_THAT(store_->Contains(digest), IsOkAndHolds(false));
  EXPECT_THAT(store_->UploadedBytes(digest), IsOkAndHolds(0));
}

TEST_P(ManagedBlobStoreTest, OneConnectionAtATimeHasAnUpload) {
  const Digest digest = Sha256::Of("abc");
  auto first = store_->ResumePut(digest, 0).value();

  const auto second = store_->ResumePut(digest, 0);
  EXPECT_THAT(second, StatusIs(absl::StatusCode::kAborted, "another connection"));
  EXPECT_EQ(ErrorReason(second.status()), "UPLOAD_BUSY");

  first.reset();
  EXPECT_THAT(store_->ResumePut(digest, 0), IsOk());
}

/// What only files can show.
class DirectoryDamageTest : public ::testing::Test {
 protected:
  [[nodiscard]] fs::path FileOf(const Digest& digest) const {
    return folder_.Path() / "sha256" / digest.Hex().substr(0, 2) / digest.Hex();
  }
  testing::ScratchFolder folder_;
  std::unique_ptr<DirectoryBlobStore> store_ = DirectoryBlobStore::Create(folder_.Path()).value();
};

TEST_F(DirectoryDamageTest, MovesADamagedFileToWherePeopleFindIt) {
  const Digest blob = store_->Put("abc").value();
  fs::permissions(FileOf(blob), fs::perms(0644));
  std::ofstream(FileOf(blob)) << "abX";
  EXPECT_EQ(UnreadableBlob(store_->Get(blob).status()), blob);

  EXPECT_THAT(store_->QuarantineIfUnreadable(blob), IsOkAndHolds(true));

  EXPECT_THAT(store_->Contains(blob), IsOkAndHolds(false));
  const fs::directory_iterator kept(folder_.Path() / "damaged");
  ASSERT_NE(kept, fs::directory_iterator());
  EXPECT_EQ(kept->path().filename().string().rfind(blob.Hex() + "-", 0), 0U) << kept->path();
  EXPECT_EQ(fs::file_size(kept->path()), 3U);
}

TEST_F(DirectoryDamageTest, SweepsUploadsThatNobodyGoesOnWith) {
  const Digest digest = Sha256::Of("abc");
  ASSERT_THAT(store_->ResumePut(digest, 0).value()->Append("ab"), IsOk());
  EXPECT_THAT(store_->SweepIncoming(kDay), IsOk());
  EXPECT_THAT(store_->UploadedBytes(digest), IsOkAndHolds(2));
  for (const auto& file : fs::directory_iterator(folder_.Path() / "incoming")) {
    fs::last_write_time(file.path(), fs::file_time_type::clock::now() - std::chrono::hours(25));
  }
  EXPECT_THAT(store_->SweepIncoming(kDay), IsOk());
  EXPECT_THAT(store_->UploadedBytes(digest), IsOkAndHolds(0));
}

TEST_F(DirectoryDamageTest, AFileThatIsNoBlobIsNotListed) {
  ASSERT_THAT(store_->Put("abc"), IsOk());
  std::ofstream(folder_.Path() / "sha256" / "ab" / "notes.txt") << "by people";
  std::ofstream(folder_.Path() / "sha256" / "README") << "by people";
  int seen = 0;
  EXPECT_THAT(store_->Visit([&](const StoredBlob&) {
    ++seen;
    return absl::OkStatus();
  }),
              IsOk());
  EXPECT_EQ(seen, 1);
}

TEST(DirectoryUpload, WaitsForSpaceAndKeepsWhatItHas) {
  const testing::SmallDisk disk("2m");
  if (!disk.Mounted()) {
    GTEST_SKIP() << "cannot mount a small disk: not root";
  }
  const auto store = DirectoryBlobStore::Create(disk.Path()).value();
  const Digest filler = store->Put(std::string(1'500'000, 'x')).value();
  const std::string bytes(600'000, 'y');
  const Digest digest = Sha256::Of(bytes);
  {
    const auto writer = store->ResumePut(digest, 0).value();
    ASSERT_THAT(writer->Append(bytes.substr(0, 100'000)), IsOk());
    ASSERT_THAT(writer->Append(bytes.substr(100'000)),
                StatusIs(absl::StatusCode::kResourceExhausted, "No space left"));
    EXPECT_THAT(writer->Commit(), StatusIs(absl::StatusCode::kResourceExhausted, ""));
  }
  EXPECT_THAT(store->UploadedBytes(digest), IsOkAndHolds(100'000));
  ASSERT_THAT(store->Remove(filler), IsOk());
  const auto writer = store->ResumePut(digest, 100'000).value();
  ASSERT_THAT(writer->Append(bytes.substr(100'000)), IsOk());
  EXPECT_THAT(writer->Commit(), IsOkAndHolds(digest));
}

}  // namespace
}  // namespace cohort
