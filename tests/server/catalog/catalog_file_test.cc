// What the catalog does about its file: locks, versions, damage, crashes, full disks.

#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/catalog/catalog.h"
#include "tests/server/catalog/catalog_fixture.h"

namespace cohort {
namespace {

namespace fs = std::filesystem;

using testing::FileCatalogTest;
using testing::IsOk;
using testing::OrdinaryUser;
using testing::ScratchFolder;
using testing::SmallDisk;
using testing::SomeJob;
using testing::SomeMesh;
using testing::StatusIs;

using CatalogFileTest = FileCatalogTest;

/// Overwrites part of a file.
void Scribble(const fs::path& file, int64_t offset, const std::string& bytes) {
  std::fstream stream(file, std::ios::binary | std::ios::in | std::ios::out);
  stream.seekp(offset);
  stream << bytes;
}

std::string MeshCount(Catalog& catalog, const std::string& set) {
  return std::to_string(catalog.ListMeshes(set, 1'000'000, "").value().items.size());
}

TEST_F(CatalogFileTest, IsRefusedToASecondServer) {
  EXPECT_THAT(Catalog::Open(File()), StatusIs(absl::StatusCode::kFailedPrecondition,
                                              "another cohort-server uses " + File().string()));

  catalog_.reset();
  EXPECT_THAT(Catalog::Open(File()), IsOk());
}

TEST_F(CatalogFileTest, IsRefusedToASecondProcess) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::_exit(absl::IsFailedPrecondition(Catalog::Open(File()).status()) ? 0 : 1);
  }
  int exit_status = -1;
  ASSERT_EQ(::waitpid(child, &exit_status, 0), child);

  EXPECT_EQ(exit_status, 0);
}

TEST_F(CatalogFileTest, HoldsWhatWasAcknowledgedBeforeItsProcessDied) {
  catalog_.reset();
  const pid_t child = ::fork();
  if (child == 0) {
    const std::unique_ptr<Catalog> catalog = Catalog::Open(File()).value();
    for (int i = 0; i < 200; ++i) {
      if (!catalog->AddMesh("s", SomeMesh(std::to_string(i))).ok()) {
        ::_exit(1);
      }
    }
    ::_exit(catalog->CreateJob(SomeJob("s"), {SomeMesh("0")}, "r", 1).ok() ? 0 : 2);
  }
  int exit_status = -1;
  ASSERT_EQ(::waitpid(child, &exit_status, 0), child);
  ASSERT_EQ(exit_status, 0);
  ASSERT_GT(fs::file_size(File().string() + "-wal"), 0u);

  Reopen();

  EXPECT_EQ(MeshCount(*catalog_, "s"), "200");
  EXPECT_THAT(catalog_->GetJob({"j-000001"}), IsOk());
}

TEST_F(CatalogFileTest, LosesOnlyTheTransactionWhoseLogIsTorn) {
  catalog_.reset();
  const pid_t child = ::fork();
  if (child == 0) {
    const std::unique_ptr<Catalog> catalog = Catalog::Open(File()).value();
    const bool added =
        catalog->AddMesh("s", SomeMesh("a")).ok() && catalog->AddMesh("s", SomeMesh("b")).ok();
    ::_exit(added ? 0 : 1);
  }
  int exit_status = -1;
  ASSERT_EQ(::waitpid(child, &exit_status, 0), child);
  ASSERT_EQ(exit_status, 0);
  const fs::path log = File().string() + "-wal";
  fs::resize_file(log, fs::file_size(log) - 100);

  Reopen();

  EXPECT_EQ(MeshCount(*catalog_, "s"), "1");
}

TEST_F(CatalogFileTest, RefusesANewerVersion) {
  catalog_.reset();
  Tamper("PRAGMA user_version = 1000");

  EXPECT_THAT(Catalog::Open(File()), StatusIs(absl::StatusCode::kFailedPrecondition,
                                              File().string() + ": has version 1000"));
}

TEST_F(CatalogFileTest, RefusesADatabaseOfAnotherProgram) {
  const ScratchFolder folder;
  catalog_.reset();
  Tamper("PRAGMA application_id = 7");

  EXPECT_THAT(Catalog::Open(File()),
              StatusIs(absl::StatusCode::kDataLoss, "not a catalog of Cohort"));
}

TEST_F(CatalogFileTest, RefusesAFileThatIsNoDatabase) {
  const fs::path file = folder_.Path() / "text";
  std::ofstream(file) << std::string(10'000, 'x');

  EXPECT_THAT(Catalog::Open(file), StatusIs(absl::StatusCode::kDataLoss, file.string()));
  EXPECT_EQ(fs::file_size(file), 10'000u);
}

TEST_F(CatalogFileTest, RefusesAFileWithADamagedPage) {
  std::vector<SetMesh> meshes(5'000, SomeMesh("a"));
  ASSERT_THAT(catalog_->CreateJob(SomeJob("s"), meshes, "", 1), IsOk());
  catalog_.reset();
  const int64_t middle = static_cast<int64_t>(fs::file_size(File())) / 2 / 4096 * 4096;
  Scribble(File(), middle, std::string(4096, '\xa5'));

  const absl::Status status = Catalog::Open(File()).status();

  EXPECT_THAT(status, StatusIs(absl::StatusCode::kDataLoss, File().string()));
  EXPECT_THAT(status, StatusIs(absl::StatusCode::kDataLoss, "age"));  // "Tree 7 page 512: ..."
}

TEST_F(CatalogFileTest, RefusesAFileCutShort) {
  std::vector<SetMesh> meshes(5'000, SomeMesh("a"));
  ASSERT_THAT(catalog_->CreateJob(SomeJob("s"), meshes, "", 1), IsOk());
  catalog_.reset();
  fs::resize_file(File(), fs::file_size(File()) / 2 / 4096 * 4096);

  EXPECT_THAT(Catalog::Open(File()), StatusIs(absl::StatusCode::kDataLoss, File().string()));
}

TEST_F(CatalogFileTest, NamesTheFileOfARowThatCannotBeRead) {
  ASSERT_THAT(catalog_->CreateJob(SomeJob("s"), {SomeMesh("a")}, "", 1), IsOk());
  catalog_.reset();
  Tamper("UPDATE job SET spec = '{'; UPDATE job_mesh SET raw = 'abc'");
  Reopen();

  EXPECT_THAT(catalog_->GetJob({"j-000001"}),
              StatusIs(absl::StatusCode::kDataLoss, File().string() + ": job spec"));
  EXPECT_THAT(catalog_->GetJobMeshes({"j-000001"}),
              StatusIs(absl::StatusCode::kDataLoss, File().string()));
}

TEST_F(CatalogFileTest, OpensUnderANameWithSpaces) {
  const fs::path file = folder_.Path() / "my  catalog = 1 .db";
  ASSERT_THAT(Catalog::Open(file), IsOk());

  EXPECT_TRUE(fs::exists(file));
  EXPECT_THAT(Catalog::Open(folder_.Path() / "\"quoted\""),
              StatusIs(absl::StatusCode::kInvalidArgument, "quoted"));
}

TEST_F(CatalogFileTest, SaysWhyAFolderCannotBeUsed) {
  fs::permissions(folder_.Path(), fs::perms(0555));
  catalog_.reset();
  const OrdinaryUser user;

  EXPECT_THAT(Catalog::Open(folder_.Path() / "new.db"),
              StatusIs(absl::StatusCode::kUnavailable, "Permission denied"));
  EXPECT_THAT(Catalog::Open(folder_.Path() / "missing" / "new.db"),
              StatusIs(absl::StatusCode::kUnavailable, "No such file or directory"));
}

TEST_F(CatalogFileTest, SaysWhyAFileThatIsReadOnlyCannotBeUsed) {
  catalog_.reset();
  fs::permissions(folder_.Path(), fs::perms(0777));
  fs::permissions(File(), fs::perms(0444));
  fs::permissions(File().string() + ".lock", fs::perms(0666));
  const OrdinaryUser user;

  EXPECT_THAT(Catalog::Open(File()), StatusIs(absl::StatusCode::kUnavailable, File().string()));
}

TEST(CatalogDisk, SaysWhenItIsFullAndKeepsWhatWasAcknowledged) {
  const SmallDisk disk("1m");
  if (!disk.Mounted()) {
    GTEST_SKIP() << "cannot mount a small disk: not root";
  }
  const fs::path file = disk.Path() / "catalog.db";
  std::unique_ptr<Catalog> catalog = Catalog::Open(file).value();
  int added = 0;
  absl::Status status;
  while (status.ok() && added < 10'000) {
    SetMesh mesh = SomeMesh(std::to_string(added));
    mesh.labels["note"] = std::string(1'000, 'x');
    status = catalog->AddMesh("s", mesh);
    added += status.ok() ? 1 : 0;
  }
  EXPECT_THAT(status, StatusIs(absl::StatusCode::kResourceExhausted, file.string()));
  EXPECT_THAT(status, StatusIs(absl::StatusCode::kResourceExhausted, "full"));
  EXPECT_EQ(MeshCount(*catalog, "s"), std::to_string(added));

  catalog.reset();
  catalog = Catalog::Open(file).value();

  EXPECT_EQ(MeshCount(*catalog, "s"), std::to_string(added));
}

}  // namespace
}  // namespace cohort
