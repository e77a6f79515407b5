// A copy of the catalog made while it is written to.

#include <atomic>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/catalog/backup.h"
#include "server/catalog/catalog.h"
#include "tests/server/catalog/catalog_fixture.h"

namespace cohort {
namespace {

namespace fs = std::filesystem;

using testing::FileCatalogTest;
using testing::IsOk;
using testing::LoadTasks;
using testing::SmallDisk;
using testing::SomeJob;
using testing::SomeMesh;
using testing::SomeTask;
using testing::StatusIs;

class CatalogBackupTest : public FileCatalogTest {
 protected:
  [[nodiscard]] fs::path Copy() const { return folder_.Path() / "copy.db"; }
  /// Files in the folder that are neither the catalog's nor the copy.
  [[nodiscard]] int LeftOvers() const {
    int count = 0;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_.Path())) {
      const std::string name = entry.path().filename();
      count += name.starts_with("copy.db.") ? 1 : 0;
    }
    return count;
  }
};

TEST_F(CatalogBackupTest, HoldsEveryRowAcknowledgedBeforeItBegan) {
  std::atomic<int> acknowledged = 0;
  std::atomic<bool> stop = false;
  Job job = catalog_->CreateJob(SomeJob("s"), {SomeMesh("a")}, "", 1).value();
  std::thread writer([&] {
    for (int i = 0; !stop; ++i) {
      ASSERT_THAT(catalog_->AddMesh("s", SomeMesh(std::to_string(i))), IsOk());
      ++job.version;
      Completion completion{.job = job, .task = SomeTask(i), .ingested = {}, .action_key = "k"};
      completion.task.result = TaskResult();
      ASSERT_THAT(catalog_->SaveCompletions({{completion}}, 1), IsOk());
      acknowledged = i + 1;
    }
  });
  const std::unique_ptr<void, std::function<void(void*)>> join(&stop, [&](void*) {
    stop = true;
    writer.join();
  });
  while (acknowledged == 0) {
    std::this_thread::yield();
  }
  for (int round = 0; round < 10; ++round) {
    const int before = acknowledged;
    const std::string copy = Copy().string() + std::to_string(round);
    EXPECT_THAT(BackUpCatalog(File(), copy), IsOk());
    const auto opened = Catalog::Open(copy);
    EXPECT_THAT(opened, IsOk());
    if (!opened.ok()) {
      break;
    }
    const std::unique_ptr<Catalog>& restored = *opened;
    const size_t meshes = restored->ListMeshes("s", 1'000'000, "").value().items.size();
    const size_t tasks = LoadTasks(*restored, job.id).value().size();
    EXPECT_GE(tasks, static_cast<size_t>(before));
    // Of one moment: the mesh of a task is always there before it.
    EXPECT_TRUE(meshes == tasks || meshes == tasks + 1) << meshes << " meshes, " << tasks;
    EXPECT_EQ(restored->GetJob(job.id)->version, static_cast<int64_t>(tasks));
  }
  EXPECT_EQ(LeftOvers(), 0);
}

TEST_F(CatalogBackupTest, CanBeRestoredAndGoneOnWith) {
  ASSERT_THAT(catalog_->CreateJob(SomeJob("s"), {SomeMesh("a")}, "r", 1), IsOk());
  ASSERT_THAT(BackUpCatalog(File(), Copy()), IsOk());
  ASSERT_THAT(catalog_->CreateJob(SomeJob("s"), {}, "later", 1), IsOk());
  catalog_.reset();
  for (const char* suffix : {"", "-wal", "-shm"}) {
    fs::remove(File().string() + suffix);
  }
  fs::copy_file(Copy(), File());

  Reopen();

  EXPECT_EQ(catalog_->CreateJob(SomeJob("s"), {}, "r", 1)->id.value, "j-000001");
  EXPECT_EQ(catalog_->CreateJob(SomeJob("s"), {}, "new", 1)->id.value, "j-000002");
}

TEST_F(CatalogBackupTest, HasChecksumsOfItsOwn) {
  ASSERT_THAT(catalog_->AddMesh("s", SomeMesh("findme")), IsOk());
  ASSERT_THAT(BackUpCatalog(File(), Copy()), IsOk());
  std::ifstream stream(Copy(), std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  const size_t at = bytes.find("findme");
  ASSERT_NE(at, std::string::npos);
  bytes[at] = 'x';
  std::ofstream(Copy(), std::ios::binary) << bytes;

  EXPECT_THAT(Catalog::Open(Copy()), StatusIs(absl::StatusCode::kDataLoss, "have its checksum"));
}

TEST_F(CatalogBackupTest, IsMadeOfACatalogThatNoServerUses) {
  ASSERT_THAT(catalog_->AddMesh("s", SomeMesh("a")), IsOk());
  catalog_.reset();

  EXPECT_THAT(BackUpCatalog(File(), Copy()), IsOk());

  EXPECT_EQ(Catalog::Open(Copy()).value()->ListMeshes("s", 9, "")->items.size(), 1u);
}

TEST_F(CatalogBackupTest, NeverOverwritesAFile) {
  std::ofstream(Copy()) << "precious";

  EXPECT_THAT(BackUpCatalog(File(), Copy()),
              StatusIs(absl::StatusCode::kAlreadyExists, Copy().string()));

  EXPECT_EQ(fs::file_size(Copy()), 8u);
}

TEST_F(CatalogBackupTest, SaysWhatIsNotThereAndCreatesNothing) {
  EXPECT_THAT(BackUpCatalog(folder_.Path() / "none.db", Copy()),
              StatusIs(absl::StatusCode::kNotFound, "none.db"));
  EXPECT_FALSE(fs::exists(folder_.Path() / "none.db"));
  EXPECT_THAT(BackUpCatalog(File(), folder_.Path() / "none" / "copy.db"),
              StatusIs(absl::StatusCode::kNotFound, "none/copy.db"));
  EXPECT_THAT(BackUpCatalog("postgresql://host/cohort", Copy()),
              StatusIs(absl::StatusCode::kInvalidArgument, "pg_dump"));
  EXPECT_EQ(LeftOvers(), 0);
}

TEST_F(CatalogBackupTest, RefusesWhatIsDamagedOrNoCatalog) {
  const fs::path other = folder_.Path() / "other.db";
  std::ofstream(other) << std::string(10'000, 'x');
  EXPECT_THAT(BackUpCatalog(other, Copy()), StatusIs(absl::StatusCode::kDataLoss, "other.db"));
  catalog_.reset();
  std::fstream stream(File(), std::ios::binary | std::ios::in | std::ios::out);
  stream.seekp(4096 * 3 + 2000);
  stream << "?";
  stream.close();

  EXPECT_THAT(BackUpCatalog(File(), Copy()),
              StatusIs(absl::StatusCode::kDataLoss, "page 4 of " + File().string()));

  EXPECT_FALSE(fs::exists(Copy()));
  EXPECT_EQ(LeftOvers(), 0);
}

TEST_F(CatalogBackupTest, LeavesNothingOnADiskThatIsTooSmall) {
  const SmallDisk disk("64k");
  if (!disk.Mounted()) {
    GTEST_SKIP() << "cannot mount a small disk: not root";
  }
  std::vector<SetMesh> meshes(2'000, SomeMesh("a"));
  ASSERT_THAT(catalog_->CreateJob(SomeJob("s"), meshes, "", 1), IsOk());

  EXPECT_THAT(BackUpCatalog(File(), disk.Path() / "copy.db"),
              StatusIs(absl::StatusCode::kResourceExhausted, "full"));

  EXPECT_TRUE(fs::is_empty(disk.Path()));
}

}  // namespace
}  // namespace cohort
