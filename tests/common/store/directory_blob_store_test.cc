#include "common/store/directory_blob_store.h"

#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/common/store/scratch_folder.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

namespace fs = std::filesystem;

using ::testing::IsEmpty;
using testing::IsOk;
using testing::IsOkAndHolds;
using testing::OrdinaryUser;
using testing::ScratchFolder;
using testing::SmallDisk;
using testing::StatusIs;

class DirectoryBlobStoreTest : public ::testing::Test {
 protected:
  [[nodiscard]] fs::path Root() const { return folder_.Path() / "store"; }
  [[nodiscard]] fs::path FileOf(const Digest& digest) const {
    return Root() / "sha256" / digest.Hex().substr(0, 2) / digest.Hex();
  }
  [[nodiscard]] std::vector<fs::path> Incoming() const {
    return {fs::directory_iterator(Root() / "incoming"), fs::directory_iterator()};
  }
  /// Replaces the contents of the file of a blob behind the back of the store.
  void Damage(const Digest& digest, const std::string& bytes) const {
    fs::permissions(FileOf(digest), fs::perms(0644));
    std::ofstream(FileOf(digest), std::ios::binary) << bytes;
  }

  ScratchFolder folder_;
  std::unique_ptr<DirectoryBlobStore> store_ = DirectoryBlobStore::Create(Root()).value();
};

/// `size` bytes that do not compress and have no period.
std::string SomeBytes(size_t size) {
  std::string bytes(size, '\0');
  uint64_t state = 1;
  for (char& byte : bytes) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    byte = static_cast<char>(state >> 56);
  }
  return bytes;
}

TEST_F(DirectoryBlobStoreTest, GivesBackWhatWasPut) {
  const std::string bytes = SomeBytes(3'000'001);

  const absl::StatusOr<Digest> digest = store_->Put(bytes);

  ASSERT_THAT(digest, IsOkAndHolds(Sha256::Of(bytes)));
  EXPECT_THAT(store_->Get(*digest), IsOkAndHolds(bytes));
  EXPECT_THAT(store_->Contains(*digest), IsOkAndHolds(true));
  EXPECT_THAT(Incoming(), IsEmpty());
}

TEST_F(DirectoryBlobStoreTest, TakesManyBlobsAtOnce) {
  const Digest there = store_->Put("was there").value();
  const std::string large = SomeBytes(1'500'000);
  const std::vector<std::string_view> blobs = {"one", large, "was there", "", "one"};

  const absl::StatusOr<std::vector<Digest>> digests = store_->PutAll(blobs);

  ASSERT_THAT(digests, IsOk());
  ASSERT_EQ(digests->size(), blobs.size());
  for (size_t i = 0; i < blobs.size(); ++i) {
    EXPECT_EQ((*digests)[i], Sha256::Of(blobs[i]));
    EXPECT_THAT(store_->Get((*digests)[i]), IsOkAndHolds(std::string(blobs[i])));
  }
  EXPECT_EQ((*digests)[2], there);
  EXPECT_THAT(Incoming(), IsEmpty()) << "what was there already leaves nothing behind";
  EXPECT_THAT(store_->PutAll({}), IsOkAndHolds(std::vector<Digest>()));
}

TEST_F(DirectoryBlobStoreTest, MendsDamagedBlobsAmongMany) {
  const Digest damaged = store_->Put("abc").value();
  Damage(damaged, "abd");
  const std::vector<std::string_view> blobs = {"abc", "def"};

  ASSERT_THAT(store_->PutAll(blobs), IsOk());

  EXPECT_THAT(store_->Get(damaged), IsOkAndHolds(std::string("abc")));
}

TEST_F(DirectoryBlobStoreTest, HoldsTheEmptyBlob) {
  ASSERT_THAT(store_->Put(""), IsOkAndHolds(Sha256::Of("")));
  EXPECT_THAT(store_->Get(Sha256::Of("")), IsOkAndHolds(std::string()));
}

TEST_F(DirectoryBlobStoreTest, KeepsABlobAsAReadOnlyFileNamedByItsDigest) {
  const Digest digest = store_->Put("abc").value();

  struct stat status {};
  ASSERT_EQ(::stat(FileOf(digest).c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 07777, 0444u);
  EXPECT_EQ(status.st_size, 3);
}

TEST_F(DirectoryBlobStoreTest, OutlivesTheObjectThatOpenedIt) {
  const Digest digest = store_->Put("abc").value();

  store_ = DirectoryBlobStore::Create(Root()).value();

  EXPECT_THAT(store_->Get(digest), IsOkAndHolds(std::string("abc")));
}

TEST_F(DirectoryBlobStoreTest, TakesARelativeRoot) {
  const fs::path before = fs::current_path();
  fs::current_path(folder_.Path());
  const absl::StatusOr<std::unique_ptr<DirectoryBlobStore>> store =
      DirectoryBlobStore::Create("store");
  fs::current_path(before);

  ASSERT_THAT(store, IsOk());
  const Digest digest = (*store)->Put("abc").value();
  EXPECT_THAT(store_->Contains(digest), IsOkAndHolds(true));
}

TEST_F(DirectoryBlobStoreTest, NamesTheBlobThatIsMissing) {
  const Digest digest = Sha256::Of("never put");

  EXPECT_THAT(store_->Get(digest), StatusIs(absl::StatusCode::kNotFound, digest.Hex()));
  EXPECT_THAT(store_->Contains(digest), IsOkAndHolds(false));
  EXPECT_THAT(store_->Open(Digest()), StatusIs(absl::StatusCode::kNotFound, ""));
}

TEST_F(DirectoryBlobStoreTest, ReadsInPiecesOfTheSizeAskedFor) {
  const Digest digest = store_->Put("abcdefgh").value();
  const std::unique_ptr<BlobReader> reader = store_->Open(digest).value();

  EXPECT_EQ(reader->SizeBytes(), 8);
  EXPECT_THAT(reader->Read(5), IsOkAndHolds(std::string("abcde")));
  EXPECT_THAT(reader->Read(5), IsOkAndHolds(std::string("fgh")));
  EXPECT_THAT(reader->Read(5), IsOkAndHolds(std::string()));
}

TEST_F(DirectoryBlobStoreTest, FindsAFlippedBit) {
  const Digest digest = store_->Put(SomeBytes(100'000)).value();
  std::string flipped = SomeBytes(100'000);
  flipped[50'000] ^= 1;
  Damage(digest, flipped);

  EXPECT_THAT(store_->Get(digest), StatusIs(absl::StatusCode::kDataLoss, FileOf(digest).string()));
}

TEST_F(DirectoryBlobStoreTest, GivesTheLastPieceOfADamagedBlobToNobody) {
  const Digest digest = store_->Put("abcdefgh").value();
  Damage(digest, "abcdefgX");
  const std::unique_ptr<BlobReader> reader = store_->Open(digest).value();

  EXPECT_THAT(reader->Read(4), IsOkAndHolds(std::string("abcd")));
  EXPECT_THAT(reader->Read(4), StatusIs(absl::StatusCode::kDataLoss, "SHA-256"));
  EXPECT_THAT(reader->Read(4), StatusIs(absl::StatusCode::kDataLoss, "SHA-256"));
}

TEST_F(DirectoryBlobStoreTest, FindsAFileCutShort) {
  const Digest digest = store_->Put("abcdefgh").value();
  const std::unique_ptr<BlobReader> reader = store_->Open(digest).value();
  Damage(digest, "abcdef");

  EXPECT_THAT(store_->Get(digest), StatusIs(absl::StatusCode::kDataLoss, FileOf(digest).string()));
  EXPECT_THAT(reader->Read(100), StatusIs(absl::StatusCode::kDataLoss, "2 bytes are missing"));
}

TEST_F(DirectoryBlobStoreTest, FindsAFileThatHasGrown) {
  const Digest digest = store_->Put("abcdefgh").value();
  const std::unique_ptr<BlobReader> reader = store_->Open(digest).value();
  Damage(digest, "abcdefghi");

  EXPECT_THAT(store_->Get(digest), StatusIs(absl::StatusCode::kDataLoss, FileOf(digest).string()));
  EXPECT_THAT(reader->Read(100), StatusIs(absl::StatusCode::kDataLoss, "grown beyond 8 bytes"));
}

TEST_F(DirectoryBlobStoreTest, KeepsABlobThatIsThere) {
  const Digest digest = store_->Put("abc").value();
  struct stat before {};
  ASSERT_EQ(::stat(FileOf(digest).c_str(), &before), 0);

  EXPECT_THAT(store_->Put("abc"), IsOkAndHolds(digest));

  struct stat after {};
  ASSERT_EQ(::stat(FileOf(digest).c_str(), &after), 0);
  EXPECT_EQ(after.st_ino, before.st_ino);
  EXPECT_THAT(Incoming(), IsEmpty());
}

TEST_F(DirectoryBlobStoreTest, MendsADamagedBlobThatIsPutAgain) {
  const Digest digest = store_->Put("abc").value();
  Damage(digest, "abX");

  EXPECT_THAT(store_->Put("abc"), IsOkAndHolds(digest));

  EXPECT_THAT(store_->Get(digest), IsOkAndHolds(std::string("abc")));
}

TEST_F(DirectoryBlobStoreTest, LeavesNothingOfAnAbortedWrite) {
  {
    const std::unique_ptr<BlobWriter> writer = store_->StartPut().value();
    ASSERT_THAT(writer->Append("abc"), IsOk());
    EXPECT_EQ(Incoming().size(), 1u);
  }

  EXPECT_THAT(Incoming(), IsEmpty());
  EXPECT_THAT(store_->Contains(Sha256::Of("abc")), IsOkAndHolds(false));
}

TEST_F(DirectoryBlobStoreTest, ShowsABlobOnlyOnceItIsCommitted) {
  const std::unique_ptr<BlobWriter> writer = store_->StartPut().value();
  ASSERT_THAT(writer->Append("ab"), IsOk());
  ASSERT_THAT(writer->Append("c"), IsOk());
  EXPECT_THAT(store_->Contains(Sha256::Of("abc")), IsOkAndHolds(false));

  EXPECT_THAT(writer->Commit(), IsOkAndHolds(Sha256::Of("abc")));

  EXPECT_THAT(store_->Contains(Sha256::Of("abc")), IsOkAndHolds(true));
}

TEST_F(DirectoryBlobStoreTest, TakesTheSameBytesFromManyWritersAtOnce) {
  const std::string bytes = SomeBytes(200'000);
  std::vector<absl::Status> statuses(8);
  std::vector<std::thread> writers;
  writers.reserve(statuses.size());
  for (absl::Status& status : statuses) {
    writers.emplace_back([&] {
      const std::unique_ptr<DirectoryBlobStore> store = DirectoryBlobStore::Create(Root()).value();
      for (int i = 0; i < 10 && status.ok(); ++i) {
        status = store->Put(bytes).status();
      }
    });
  }
  for (std::thread& writer : writers) {
    writer.join();
  }

  EXPECT_THAT(statuses, ::testing::Each(IsOk()));
  EXPECT_THAT(store_->Get(Sha256::Of(bytes)), IsOkAndHolds(bytes));
  EXPECT_THAT(Incoming(), IsEmpty());
}

TEST_F(DirectoryBlobStoreTest, SweepsWhatADeadProcessLeft) {
  const pid_t child = ::fork();
  if (child == 0) {
    const std::unique_ptr<BlobWriter> writer = store_->StartPut().value();
    ::_exit(writer->Append("abc").ok() ? 0 : 1);
  }
  int exit_status = 0;
  ASSERT_EQ(::waitpid(child, &exit_status, 0), child);
  ASSERT_EQ(exit_status, 0);
  ASSERT_EQ(Incoming().size(), 1u);
  fs::last_write_time(Incoming()[0], fs::file_time_type::clock::now() - std::chrono::hours(25));
  const std::unique_ptr<BlobWriter> alive = store_->StartPut().value();
  ASSERT_THAT(alive->Append("def"), IsOk());

  EXPECT_THAT(store_->SweepIncoming(24 * 3600), IsOk());

  EXPECT_EQ(Incoming().size(), 1u);
  EXPECT_THAT(alive->Commit(), IsOkAndHolds(Sha256::Of("def")));
}

TEST_F(DirectoryBlobStoreTest, NamesTheFolderItMayNotWrite) {
  const OrdinaryUser user;
  fs::path root = Root();
  if (::geteuid() != 65534) {
    fs::permissions(root / "incoming", fs::perms(0555));
  }

  EXPECT_THAT(store_->StartPut(),
              StatusIs(absl::StatusCode::kPermissionDenied, (root / "incoming").string()));
  EXPECT_THAT(store_->StartPut(),
              StatusIs(absl::StatusCode::kPermissionDenied, "Permission denied"));
}

TEST(DirectoryBlobStore, NamesTheRootItMayNotCreate) {
  const ScratchFolder folder;
  fs::permissions(folder.Path(), fs::perms(0555));
  const OrdinaryUser user;
  const fs::path root = folder.Path() / "store";

  EXPECT_THAT(DirectoryBlobStore::Create(root),
              StatusIs(absl::StatusCode::kPermissionDenied, root.string()));
}

TEST(DirectoryBlobStore, RefusesARootThatIsAFile) {
  const ScratchFolder folder;
  const fs::path root = folder.Path() / "file";
  std::ofstream(root) << "abc";

  EXPECT_THAT(DirectoryBlobStore::Create(root),
              StatusIs(absl::StatusCode::kUnavailable, root.string()));
}

TEST(DirectoryBlobStore, SaysWhenTheDiskIsFullAndRecovers) {
  const SmallDisk disk("1m");
  if (!disk.Mounted()) {
    GTEST_SKIP() << "cannot mount a small disk: not root";
  }
  const std::unique_ptr<DirectoryBlobStore> store = DirectoryBlobStore::Create(disk.Path()).value();
  const Digest small = store->Put("abc").value();

  const absl::StatusOr<Digest> large = store->Put(SomeBytes(2'000'000));

  EXPECT_THAT(large, StatusIs(absl::StatusCode::kResourceExhausted, "No space left on device"));
  EXPECT_THAT(large, StatusIs(absl::StatusCode::kResourceExhausted, disk.Path().string()));
  EXPECT_THAT(store->Get(small), IsOkAndHolds(std::string("abc")));
  EXPECT_THAT(store->Put(SomeBytes(500'000)), IsOk());
}

TEST(DirectoryBlobStore, WritesNoneOfManyBlobsThatDoNotFit) {
  const SmallDisk disk("1m");
  if (!disk.Mounted()) {
    GTEST_SKIP() << "cannot mount a small disk: not root";
  }
  const std::unique_ptr<DirectoryBlobStore> store = DirectoryBlobStore::Create(disk.Path()).value();
  const std::string large = SomeBytes(2'000'000);
  const std::vector<std::string_view> blobs = {"abc", large, "def"};

  EXPECT_THAT(store->PutAll(blobs),
              StatusIs(absl::StatusCode::kResourceExhausted, "No space left on device"));

  EXPECT_THAT(store->Contains(Sha256::Of("abc")), IsOkAndHolds(false));
  EXPECT_TRUE(fs::is_empty(disk.Path() / "incoming"));
  EXPECT_THAT(store->PutAll(std::vector<std::string_view>{"abc", "def"}), IsOk());
}

TEST(DirectoryBlobStore, NeverCommitsAfterAFailedAppend) {
  const SmallDisk disk("1m");
  if (!disk.Mounted()) {
    GTEST_SKIP() << "cannot mount a small disk: not root";
  }
  const std::unique_ptr<DirectoryBlobStore> store = DirectoryBlobStore::Create(disk.Path()).value();
  const std::unique_ptr<BlobWriter> writer = store->StartPut().value();
  ASSERT_FALSE(writer->Append(SomeBytes(2'000'000)).ok());

  EXPECT_THAT(writer->Append("abc"), StatusIs(absl::StatusCode::kResourceExhausted, ""));
  EXPECT_THAT(writer->Commit(), StatusIs(absl::StatusCode::kResourceExhausted, ""));
}

}  // namespace
}  // namespace cohort
