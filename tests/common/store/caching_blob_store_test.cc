#include "common/store/caching_blob_store.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/store/blob_damage.h"
#include "common/store/memory_blob_store.h"
#include "tests/common/store/scratch_folder.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

namespace fs = std::filesystem;

using testing::IsOk;
using testing::IsOkAndHolds;
using testing::StatusIs;

/// Hands calls on to a store that others look at.
class BorrowedStore final : public BlobStore {
 public:
  explicit BorrowedStore(BlobStore& store) : store_(store) {}
  absl::StatusOr<std::unique_ptr<BlobWriter>> StartPut() override { return store_.StartPut(); }
  absl::StatusOr<std::unique_ptr<BlobReader>> Open(const Digest& digest) override {
    return store_.Open(digest);
  }
  absl::StatusOr<bool> Contains(const Digest& digest) override { return store_.Contains(digest); }

 private:
  BlobStore& store_;
};

class CachingBlobStoreTest : public ::testing::Test {
 protected:
  std::unique_ptr<CachingBlobStore> MakeCache(int64_t max_bytes) {
    return CachingBlobStore::Create(std::make_unique<BorrowedStore>(source_), folder_.Path(),
                                    max_bytes)
        .value();
  }
  [[nodiscard]] fs::path FileOf(const Digest& digest) const {
    return folder_.Path() / "sha256" / digest.Hex().substr(0, 2) / digest.Hex();
  }
  /// Bytes of all files in the folder, wherever they are.
  [[nodiscard]] int64_t FolderBytes() const {
    int64_t bytes = 0;
    for (const auto& file : fs::recursive_directory_iterator(folder_.Path())) {
      bytes += file.is_regular_file() ? static_cast<int64_t>(file.file_size()) : 0;
    }
    return bytes;
  }

  MemoryBlobStore source_;
  testing::ScratchFolder folder_;
};

TEST_F(CachingBlobStoreTest, AsksTheSourceOnce) {
  const auto cache = MakeCache(1000);
  const Digest blob = source_.Put("abc").value();
  EXPECT_THAT(cache->Get(blob), IsOkAndHolds(std::string("abc")));
  EXPECT_EQ(cache->Hits(), 0);
  ASSERT_THAT(source_.Remove(blob), IsOk());

  EXPECT_THAT(cache->Get(blob), IsOkAndHolds(std::string("abc")));

  EXPECT_EQ(cache->Hits(), 1);
  EXPECT_THAT(cache->Contains(blob), IsOkAndHolds(false)) << "the source's answer";
}

TEST_F(CachingBlobStoreTest, WritesGoThrough) {
  const auto cache = MakeCache(1000);

  const Digest blob = cache->Put("abc").value();

  EXPECT_THAT(source_.Get(blob), IsOkAndHolds(std::string("abc")));
  EXPECT_EQ(FolderBytes(), 0);
}

TEST_F(CachingBlobStoreTest, SurvivesARestartAndServesSeveralProcesses) {
  const Digest blob = source_.Put("abc").value();
  ASSERT_THAT(MakeCache(1000)->Get(blob), IsOk());
  ASSERT_THAT(source_.Remove(blob), IsOk());

  EXPECT_THAT(MakeCache(1000)->Get(blob), IsOkAndHolds(std::string("abc")));
}

TEST_F(CachingBlobStoreTest, DropsADamagedFileAndFetchesItAgain) {
  const auto cache = MakeCache(1000);
  const Digest blob = source_.Put("abc").value();
  for (const char* damaged : {"abX", "ab", "abcd", ""}) {
    ASSERT_THAT(cache->Get(blob), IsOk());
    fs::permissions(FileOf(blob), fs::perms(0644));
    std::ofstream(FileOf(blob)) << damaged;

    EXPECT_THAT(cache->Get(blob), IsOkAndHolds(std::string("abc"))) << damaged;
  }
  EXPECT_EQ(FolderBytes(), 3) << "nothing damaged is kept";
}

TEST_F(CachingBlobStoreTest, StaysUnderItsLimitAndKeepsWhatWasReadLast) {
  const auto cache = MakeCache(1000);
  const Digest favourite = source_.Put(std::string(100, 'f')).value();
  for (int i = 0; i < 100; ++i) {
    // Far enough apart for the time stamps of any file system.
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    ASSERT_THAT(cache->Get(favourite), IsOk());
    const Digest other = source_.Put("other " + std::to_string(i) + std::string(90, ' ')).value();
    ASSERT_THAT(cache->Get(other), IsOk());
    ASSERT_LE(FolderBytes(), 1000) << i;
  }
  EXPECT_GE(FolderBytes(), 500);
  EXPECT_EQ(cache->Hits(), 99);
}

TEST_F(CachingBlobStoreTest, ALowerLimitHoldsFromTheStart) {
  for (int i = 0; i < 10; ++i) {
    const Digest blob = source_.Put("blob " + std::to_string(i) + std::string(94, ' ')).value();
    ASSERT_THAT(MakeCache(1000)->Get(blob), IsOk());
  }
  ASSERT_EQ(FolderBytes(), 1000);
  const auto cache = MakeCache(500);
  EXPECT_LE(FolderBytes(), 500);
}

TEST_F(CachingBlobStoreTest, LeavesOutWhatIsLargerThanTheLimit) {
  const auto cache = MakeCache(10);
  const Digest blob = source_.Put("more than ten bytes").value();
  EXPECT_THAT(cache->Get(blob), IsOkAndHolds(std::string("more than ten bytes")));
  EXPECT_EQ(FolderBytes(), 0);
}

TEST_F(CachingBlobStoreTest, NamesABlobThatTheSourceDoesNotHave) {
  const auto cache = MakeCache(1000);
  const Digest missing = Sha256::Of("never put");
  const auto read = cache->Get(missing);
  EXPECT_THAT(read, StatusIs(absl::StatusCode::kNotFound, missing.Hex()));
  EXPECT_EQ(UnreadableBlob(read.status()), missing);
}

TEST_F(CachingBlobStoreTest, AFullDiskCostsOnlyTheCache) {
  const testing::SmallDisk disk("1m");
  if (!disk.Mounted()) {
    GTEST_SKIP() << "cannot mount a small disk: not root";
  }
  const auto cache =
      CachingBlobStore::Create(std::make_unique<BorrowedStore>(source_), disk.Path(), 100'000'000)
          .value();
  const std::string bytes(3'000'000, 'x');
  const Digest blob = source_.Put(bytes).value();
  EXPECT_THAT(cache->Get(blob), IsOkAndHolds(bytes));
}

TEST_F(CachingBlobStoreTest, TwoProcessesShareAFolder) {
  std::vector<Digest> blobs;
  blobs.reserve(60);
  for (int i = 0; i < 60; ++i) {
    blobs.push_back(source_.Put("blob " + std::to_string(i) + std::string(90, ' ')).value());
  }
  const auto one = MakeCache(2000);
  const auto other = MakeCache(2000);
  std::vector<absl::Status> failed(4);
  std::vector<std::thread> readers;
  for (size_t i = 0; i < failed.size(); ++i) {
    readers.emplace_back([&, i] {
      CachingBlobStore& cache = i % 2 == 0 ? *one : *other;
      for (size_t k = 0; k < 600 && failed[i].ok(); ++k) {
        const Digest& blob = blobs[(k * (i + 7)) % blobs.size()];
        const auto bytes = cache.Get(blob);
        failed[i] = bytes.ok() && Sha256::Of(*bytes) != blob ? absl::DataLossError("other bytes")
                                                             : bytes.status();
      }
    });
  }
  for (std::thread& reader : readers) {
    reader.join();
  }
  EXPECT_THAT(failed, ::testing::Each(IsOk()));
  // The limit, and what each adds before it looks again, with a blob of each thread under way.
  EXPECT_LE(FolderBytes(), 2000 + 2 * 2000 / 16 + 4 * 100);
}

}  // namespace
}  // namespace cohort
