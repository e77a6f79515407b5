// Disks that fail: whichever write or sync it is, nothing acknowledged is lost.

#include "tests/server/catalog/disk_faults.h"

#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/status_macros.h"
#include "server/catalog/catalog.h"
#include "tests/server/catalog/catalog_fixture.h"

namespace cohort {
namespace {

struct Plan {
  bool is_on = false;
  int number = 0;
  testing::DiskFaults::Which which = testing::DiskFaults::Which::kOne;
  int error_number = 0;
  int operations = 0;
  int failed = 0;
  int syncs = 0;
};
thread_local Plan plan;

/// Counts an operation; whether it is to fail, with errno set.
bool Fails() {
  if (!plan.is_on) {
    return false;
  }
  const int number = plan.operations++;
  const bool fails = number == plan.number ||
                     (plan.which == testing::DiskFaults::Which::kAllFrom && number > plan.number);
  if (fails) {
    ++plan.failed;
    errno = plan.error_number;
  }
  return fails;
}

}  // namespace

namespace testing {

DiskFaults::DiskFaults(int number, Which which, int error_number) {
  plan = {.is_on = true, .number = number, .which = which, .error_number = error_number};
}
DiskFaults::~DiskFaults() {
  plan = {};
}
int DiskFaults::Failed() const {
  return plan.failed;
}
int DiskFaults::Syncs() const {
  return plan.syncs;
}

}  // namespace testing
}  // namespace cohort

// Found by the dynamic linker before the C library's, whose headers name parameters __fd.
// NOLINTBEGIN(readability-inconsistent-declaration-parameter-name)
extern "C" {
int fdatasync(int fd) {
  ++cohort::plan.syncs;
  return cohort::Fails() ? -1 : static_cast<int>(syscall(SYS_fdatasync, fd));
}
int fsync(int fd) {
  ++cohort::plan.syncs;
  return cohort::Fails() ? -1 : static_cast<int>(syscall(SYS_fsync, fd));
}
ssize_t pwrite64(int fd, const void* bytes, size_t size, off64_t offset) {
  return cohort::Fails() ? -1 : syscall(SYS_pwrite64, fd, bytes, size, offset);
}
int ftruncate64(int fd, off64_t size) noexcept {
  return cohort::Fails() ? -1 : static_cast<int>(syscall(SYS_ftruncate, fd, size));
}
}
// NOLINTEND(readability-inconsistent-declaration-parameter-name)

namespace cohort {
namespace {

using testing::DiskFaults;
using testing::IsOk;
using testing::LoadTasks;
using testing::MakeFirstCatalog;
using testing::ScratchFolder;
using testing::SmallDisk;
using testing::SomeJob;
using testing::SomeMesh;
using testing::SomeTask;

/// What a client was told is done.
struct Acknowledged {
  std::vector<std::string> meshes;
  std::vector<JobId> jobs;
  std::vector<std::string> actions;
};

/// Writes of each kind until one fails. @return its error.
absl::Status Work(Catalog& catalog, const std::string& prefix, Acknowledged& done) {
  for (int i = 0; i < 2; ++i) {
    const std::string name = prefix + std::to_string(i);
    COHORT_RETURN_IF_ERROR(catalog.AddMesh("s", SomeMesh(name)));
    done.meshes.push_back(name);
    const absl::StatusOr<Job> job = catalog.CreateJob(SomeJob("s"), {SomeMesh("a")}, name, 1);
    COHORT_RETURN_IF_ERROR(job.status());
    done.jobs.push_back(job->id);
    const JobTask granted{.job = job->id, .task = SomeTask(1)};
    COHORT_RETURN_IF_ERROR(catalog.SaveGrants({{granted}}, {}));
    Completion completion{.job = *job, .task = SomeTask(1), .ingested = {}, .action_key = name};
    completion.task.result = TaskResult();
    COHORT_RETURN_IF_ERROR(catalog.SaveCompletions({{completion}}, 1));
    done.actions.push_back(name);
  }
  return absl::OkStatus();
}

void ExpectAll(Catalog& catalog, const Acknowledged& done) {
  for (const std::string& name : done.meshes) {
    // The same bytes under the name are there: other ones are refused.
    SetMesh other = SomeMesh(name);
    other.raw = Sha256::Of("other");
    EXPECT_TRUE(absl::IsAlreadyExists(catalog.AddMesh("s", other))) << name;
  }
  for (const JobId& id : done.jobs) {
    EXPECT_THAT(catalog.GetJob(id), IsOk());
    EXPECT_EQ(catalog.GetJobMeshes(id)->size(), 1u);
  }
  EXPECT_EQ(catalog.FindActions(done.actions)->size(), done.actions.size());
}

struct Fault {
  const char* name;
  DiskFaults::Which which;
  int error_number;
  absl::StatusCode code;
};

class DiskFaultsTest : public ::testing::TestWithParam<Fault> {
 protected:
  [[nodiscard]] std::string File(int number) const {
    // In memory where that can be: a sync takes no time there.
    const std::string name = std::to_string(number) + ".db";
    return disk_.Mounted() ? disk_.Path() / name : folder_.Path() / name;
  }
  /// The whole life of a catalog while operation `number` fails.
  /// @return whether it failed, or the life was shorter.
  bool LivesThrough(int number) {
    Acknowledged done;
    std::unique_ptr<Catalog> catalog;
    bool has_failed = false;
    {
      const DiskFaults faults(number, GetParam().which, GetParam().error_number);
      absl::StatusOr<std::unique_ptr<Catalog>> opened = Catalog::Open(File(number));
      absl::Status status = opened.status();
      if (opened.ok()) {
        catalog = *std::move(opened);
        status = Work(*catalog, "a", done);
      }
      has_failed = faults.Failed() > 0;
      if (!status.ok()) {
        EXPECT_TRUE(has_failed) << status;
        EXPECT_EQ(status.code(), GetParam().code) << status;
      }
      if (number % 2 == 0) {
        catalog.reset();  // The checkpoint at the end is under the faults, too.
        has_failed = faults.Failed() > 0;
      }
    }
    if (catalog != nullptr) {
      // The disk is well again: the same session goes on.
      ExpectAll(*catalog, done);
      EXPECT_THAT(Work(*catalog, "b", done), IsOk());
      catalog.reset();
    }
    absl::StatusOr<std::unique_ptr<Catalog>> reopened = Catalog::Open(File(number));
    EXPECT_THAT(reopened, IsOk());
    if (reopened.ok()) {
      ExpectAll(**reopened, done);
      EXPECT_THAT(Work(**reopened, "c", done), IsOk());
      ExpectAll(**reopened, done);
    }
    return has_failed;
  }

  SmallDisk disk_{"64m"};
  ScratchFolder folder_;
};

TEST_P(DiskFaultsTest, LoseNothingAcknowledgedWhicheverOperationFails) {
  int number = 0;
  while (LivesThrough(number) && !HasFailure()) {
    ++number;
  }
  EXPECT_FALSE(HasFailure()) << "operation " << number;
  EXPECT_GT(number, 40);  // Else the faults do not reach SQLite.
  RecordProperty("operations", number);
}

TEST_P(DiskFaultsTest, LoseNothingOfAnOlderCatalogWhicheverOperationFails) {
  bool has_failed = true;
  int number = 0;
  for (; has_failed && !HasFailure(); ++number) {
    MakeFirstCatalog(File(number));
    {
      const DiskFaults faults(number, GetParam().which, GetParam().error_number);
      const absl::Status status = Catalog::Open(File(number)).status();
      has_failed = faults.Failed() > 0;
      EXPECT_TRUE(has_failed || status.ok()) << status;
    }
    const auto catalog = Catalog::Open(File(number));
    ASSERT_THAT(catalog, IsOk());
    EXPECT_EQ((*catalog)->ListMeshes("faces", 9, "")->items.size(), 2u);
    EXPECT_EQ(LoadTasks(**catalog, {"j-000001"})->size(), 2u);
    EXPECT_THAT((*catalog)->FindActions({"k"}), IsOk());
  }
  EXPECT_FALSE(HasFailure()) << "operation " << number;
  EXPECT_GT(number, 20);
}

TEST(DiskSyncs, GrantsAreOnDiskWithTheNextResult) {
  const ScratchFolder folder;
  const auto catalog = Catalog::Open(folder.Path() / "catalog.db").value();
  const Job job = catalog->CreateJob(SomeJob("s"), {SomeMesh("a")}, "", 1).value();
  const JobTask granted{.job = job.id, .task = SomeTask(1)};
  Completion completion{.job = job, .task = SomeTask(1), .ingested = {}, .action_key = "k"};
  completion.task.result = TaskResult();
  for (int i = 0; i < 3; ++i) {
    const DiskFaults counted(DiskFaults::kNone, DiskFaults::Which::kOne, 0);
    EXPECT_THAT(catalog->SaveGrants({{granted}}, {}), IsOk());
    EXPECT_EQ(counted.Syncs(), 0);
    EXPECT_THAT(catalog->SaveCompletions({{completion}}, 1), IsOk());
    EXPECT_EQ(counted.Syncs(), 1);
    EXPECT_THAT(catalog->SaveTasks({{granted}}, {}), IsOk());
    EXPECT_EQ(counted.Syncs(), 2);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Each,
    DiskFaultsTest,
    ::testing::Values(
        Fault{"OneEio", DiskFaults::Which::kOne, EIO, absl::StatusCode::kUnavailable},
        Fault{"AllEio", DiskFaults::Which::kAllFrom, EIO, absl::StatusCode::kUnavailable},
        Fault{"OneFull", DiskFaults::Which::kOne, ENOSPC, absl::StatusCode::kResourceExhausted},
        Fault{"AllFull", DiskFaults::Which::kAllFrom, ENOSPC,
              absl::StatusCode::kResourceExhausted}),
    [](const ::testing::TestParamInfo<Fault>& fault) { return std::string(fault.param.name); });

}  // namespace
}  // namespace cohort
