// A flipped bit anywhere in the file: told, never read as a value.

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/random.h"
#include "server/catalog/catalog.h"
#include "tests/server/catalog/catalog_fixture.h"

namespace cohort {
namespace {

namespace fs = std::filesystem;

using testing::FileCatalogTest;
using testing::IsOk;
using testing::SomeIngested;
using testing::SomeJob;
using testing::SomeMesh;
using testing::SomeResult;
using testing::SomeTask;
using testing::StatusIs;

constexpr int64_t kPageSize = 4096;

std::string BytesOf(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream bytes;
  bytes << stream.rdbuf();
  return bytes.str();
}

void Flip(const fs::path& file, int64_t offset, int bit) {
  std::fstream stream(file, std::ios::binary | std::ios::in | std::ios::out);
  stream.seekg(offset);
  const int byte = stream.get();
  stream.seekp(offset);
  stream.put(static_cast<char>(byte ^ (1 << bit)));
}

class CatalogDamageTest : public FileCatalogTest {
 protected:
  /// Rows in every table, of one page and of several.
  void Fill() {
    for (int i = 0; i < 100; ++i) {
      ASSERT_THAT(catalog_->AddMesh("s", SomeMesh("mesh " + std::to_string(i))), IsOk());
    }
    std::vector<SetMesh> meshes(100, SomeMesh("a"));
    Job job = catalog_->CreateJob(SomeJob("s"), meshes, "request", 1).value();
    Completion completion{.job = job,
                          .task = SomeTask(1),
                          .ingested = {{Sha256::Of("raw"), SomeIngested("a")}},
                          .action_key = "key"};
    completion.task.result = SomeResult();
    completion.task.result->ingested.resize(50);  // Some overflow pages.
    ASSERT_THAT(catalog_->SaveCompletions({{completion}}, 1), IsOk());
  }
};

TEST_F(CatalogDamageTest, IsToldWhicheverPageItIsOn) {
  Fill();
  catalog_.reset();
  const auto size = static_cast<int64_t>(fs::file_size(File()));
  ASSERT_EQ(size % kPageSize, 0);
  const std::string before = BytesOf(File());
  Random random(1);
  for (int64_t page = 0; page < size / kPageSize; ++page) {
    for (int trial = 0; trial < 5; ++trial) {
      const int64_t offset = page * kPageSize + random.Below(kPageSize);
      const int bit = static_cast<int>(random.Below(8));
      Flip(File(), offset, bit);
      ASSERT_THAT(Catalog::Open(File()).status(),
                  StatusIs(absl::StatusCode::kDataLoss, File().string()))
          << "bit " << bit << " of byte " << offset;
      Flip(File(), offset, bit);
    }
  }
  ASSERT_EQ(BytesOf(File()), before);  // No refusal wrote anything.
  Reopen();
  EXPECT_EQ(catalog_->ListMeshes("s", 1'000, "")->items.size(), 100u);
}

TEST_F(CatalogDamageTest, IsToldInEveryByteOfTheHeader) {
  Fill();
  catalog_.reset();
  for (int64_t offset = 0; offset < 100; ++offset) {
    Flip(File(), offset, static_cast<int>(offset % 8));
    ASSERT_THAT(Catalog::Open(File()).status(),
                StatusIs(absl::StatusCode::kDataLoss, File().string()))
        << "byte " << offset;
    Flip(File(), offset, static_cast<int>(offset % 8));
  }
  Reopen();
}

TEST_F(CatalogDamageTest, IsToldByTheReadThatMeetsItLater) {
  Fill();
  Reopen();  // A checkpoint: the rows are in the file, and the session holds few pages of it.
  const std::string bytes = BytesOf(File());
  int found = 0;
  // Every copy of the name: in the table and in its index.
  for (size_t at = bytes.find("mesh 77"); at != std::string::npos;
       at = bytes.find("mesh 77", at + 1)) {
    Flip(File(), static_cast<int64_t>(at) + 6, 0);  // Becomes "mesh 76".
    ++found;
  }
  ASSERT_GE(found, 2);
  // Pages that the session holds in memory are right still; those it reads are refused.
  for (int i = 0; i < 3; ++i) {
    const absl::StatusOr<Page<SetMesh>> page = catalog_->ListMeshes("s", 1'000, "");
    if (page.ok()) {
      EXPECT_EQ(page->items.size(), 100u);
      EXPECT_EQ(page->items[76].raw, Sha256::Of(page->items[76].name));
    } else {
      EXPECT_THAT(page, StatusIs(absl::StatusCode::kDataLoss, "does not have its checksum"));
    }
  }
  catalog_.reset();
  EXPECT_THAT(Catalog::Open(File()), StatusIs(absl::StatusCode::kDataLoss, File().string()));
}

TEST_F(CatalogDamageTest, IsToldWhenAPageIsThatOfAnotherPlaceOrOfZeros) {
  Fill();
  catalog_.reset();
  const std::string before = BytesOf(File());
  for (const std::string& page :
       {before.substr(4 * kPageSize, kPageSize), std::string(kPageSize, '\0')}) {
    std::string bytes = before;
    bytes.replace(5 * kPageSize, kPageSize, page);
    std::ofstream(File(), std::ios::binary) << bytes;
    EXPECT_THAT(Catalog::Open(File()),
                StatusIs(absl::StatusCode::kDataLoss, "page 6 of " + File().string()));
  }
}

TEST_F(CatalogDamageTest, IsNeverSeenInAFileThatIsWholeThroughMuchChange) {
  Random random(2);
  int64_t jobs = 0;
  for (int round = 0; round < 60; ++round) {
    const std::string set = std::to_string(random.Below(5));
    std::vector<SetMesh> meshes(static_cast<size_t>(random.Below(400)), SomeMesh("a"));
    Job job = catalog_->CreateJob(SomeJob(set), meshes, "", 1).value();
    ++jobs;
    job.state = JobState::kFailed;
    job.error.assign(static_cast<size_t>(random.Below(20'000)), 'x');
    ASSERT_THAT(catalog_->UpdateJob(job), IsOk());
    if (random.Below(2) == 0) {
      ASSERT_THAT(catalog_->DeleteJob(job.id), IsOk());
      --jobs;
    }
    if (random.Below(10) == 0) {
      Reopen();
    }
  }
  Reopen();
  EXPECT_EQ(catalog_->ListJobs(1'000, "")->items.size(), static_cast<size_t>(jobs));
}

}  // namespace
}  // namespace cohort
