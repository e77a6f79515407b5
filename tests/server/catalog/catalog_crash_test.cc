// The server dies at any moment: what it acknowledged is there, once.

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <functional>
#include <map>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/base/random.h"
#include "server/catalog/catalog.h"
#include "tests/server/catalog/catalog_fixture.h"

namespace cohort {
namespace {

using testing::CatalogTest;
using testing::DatabaseKind;
using testing::DatabaseName;
using testing::EachDatabase;
using testing::IsOk;
using testing::LoadTasks;
using testing::PostgresCluster;
using testing::SomeJob;
using testing::SomeMesh;
using testing::SomeTask;

constexpr int kTasks = 3;
constexpr uint64_t kSeed = 20261122;

std::string RequestOf(int64_t number) {
  return "request " + std::to_string(number);
}

/// Creates jobs and completes tasks, and says so after each acknowledgement: "j12" and "t12".
/// @param first  number of the first request; the one before it may have died on its way.
[[noreturn]] void Serve(const std::string& location, int64_t first, int pipe) {
  const auto catalog = Catalog::Open(location);
  if (!catalog.ok()) {
    ::_exit(3);
  }
  for (int64_t number = first;; ++number) {
    Job job = SomeJob(RequestOf(number));
    const auto created =
        (*catalog)->CreateJob(job, {SomeMesh("a"), SomeMesh("b")}, RequestOf(number), 1);
    if (!created.ok()) {
      ::_exit(4);
    }
    const std::string said_job = "j" + std::to_string(number) + "\n";
    std::vector<Completion> completions;
    for (int task = 0; task < kTasks; ++task) {
      completions.push_back({.job = *created,
                             .task = SomeTask(task),
                             .ingested = {},
                             .action_key = RequestOf(number) + " " + std::to_string(task)});
      completions.back().task.result = TaskResult();
    }
    if (::write(pipe, said_job.data(), said_job.size()) < 0 ||
        !(*catalog)->SaveCompletions(completions, 1).ok()) {
      ::_exit(5);
    }
    const std::string said_tasks = "t" + std::to_string(number) + "\n";
    if (::write(pipe, said_tasks.data(), said_tasks.size()) < 0) {
      ::_exit(6);
    }
  }
}

class CatalogCrashTest : public CatalogTest {
 protected:
  /// Starts a server, kills it after a while.
  /// @param kill  ends it; by default SIGKILL to the server.
  void Round(int64_t microseconds, const std::function<void(pid_t)>& kill) {
    int ends[2];
    ASSERT_EQ(::pipe(ends), 0);
    const pid_t server = ::fork();
    if (server == 0) {
      ::close(ends[0]);
      Serve(location_, next_, ends[1]);
    }
    ::close(ends[1]);
    std::this_thread::sleep_for(std::chrono::microseconds(microseconds));
    kill(server);
    ReadAcknowledged(ends[0]);
    ::close(ends[0]);
    ::waitpid(server, nullptr, 0);
  }

  void ReadAcknowledged(int pipe) {
    std::string said;
    char buffer[4096];
    for (ssize_t count = 0; (count = ::read(pipe, buffer, sizeof(buffer))) > 0;) {
      said.append(buffer, static_cast<size_t>(count));
    }
    std::istringstream lines(said);
    for (std::string line; std::getline(lines, line);) {
      const int64_t number = std::stoll(line.substr(1));
      (line[0] == 'j' ? jobs_ : tasks_) = number + 1;
      // The next server starts with the last request: its client heard nothing, or asks again.
      next_ = number;
    }
  }

  /// All acknowledged is there once; what was not acknowledged is there as a whole or not at all.
  void Check() {
    std::map<std::string, std::string> jobs;  // Id by set, which is the request.
    std::string token;
    do {
      const Page<Job> page = catalog_->ListJobs(1'000, token).value();
      for (const Job& job : page.items) {
        ASSERT_TRUE(jobs.emplace(job.set, job.id.value).second) << job.set << " twice";
      }
      token = page.next_token;
    } while (!token.empty());
    ASSERT_GE(static_cast<int64_t>(jobs.size()), jobs_);
    ASSERT_LE(static_cast<int64_t>(jobs.size()), jobs_ + 1);
    for (int64_t number = std::max<int64_t>(0, checked_ - 1);
         number < static_cast<int64_t>(jobs.size()); ++number) {
      const auto found = jobs.find(RequestOf(number));
      ASSERT_NE(found, jobs.end()) << number;
      ASSERT_EQ(catalog_->GetJobMeshes({found->second})->size(), 2u);
      const size_t tasks = LoadTasks(*catalog_, {found->second})->size();
      ASSERT_TRUE(tasks == kTasks || (tasks == 0 && number >= tasks_)) << number << ": " << tasks;
      std::vector<std::string> keys;
      keys.reserve(kTasks);
      for (int task = 0; task < kTasks; ++task) {
        keys.push_back(RequestOf(number) + " " + std::to_string(task));
      }
      ASSERT_EQ(catalog_->FindActions(keys)->size(), tasks);
    }
    checked_ = jobs_;
  }

  int64_t next_ = 0;
  int64_t jobs_ = 0;     ///< Requests below this have an acknowledged job.
  int64_t tasks_ = 0;    ///< Requests below this have acknowledged tasks.
  int64_t checked_ = 0;  ///< Requests below this were looked at in an earlier round.
};

TEST_P(CatalogCrashTest, HoldsEveryAcknowledgedRowOnceWhereverTheServerWasKilled) {
  const int rounds = GetParam() == DatabaseKind::kSqlite ? 200 : 50;
  Random random(kSeed);
  for (int round = 0; round < rounds; ++round) {
    catalog_.reset();
    Round(random.Below(60'000), [](pid_t server) { ::kill(server, SIGKILL); });
    ASSERT_FALSE(HasFatalFailure());
    absl::StatusOr<std::unique_ptr<Catalog>> opened = Catalog::Open(location_);
    ASSERT_THAT(opened, IsOk()) << "round " << round << " of seed " << kSeed;
    catalog_ = *std::move(opened);
    Check();
    ASSERT_FALSE(HasFatalFailure()) << "round " << round << " of seed " << kSeed;
  }
  checked_ = 0;
  Check();
  EXPECT_GT(jobs_, rounds / 2);  // Else the servers died before they did anything.
  RecordProperty("jobs", std::to_string(jobs_));
}

TEST_P(CatalogCrashTest, HoldsEveryAcknowledgedRowOnceWhenTheDatabaseServerIsKilled) {
  if (GetParam() == DatabaseKind::kSqlite) {
    GTEST_SKIP() << "SQLite has no server";
  }
  Random random(kSeed);
  for (int round = 0; round < 10; ++round) {
    catalog_.reset();
    Round(30'000 + random.Below(60'000), [](pid_t) { PostgresCluster::Shared().Crash(); });
    Reopen();
    Check();
    ASSERT_FALSE(HasFatalFailure()) << "round " << round << " of seed " << kSeed;
  }
  EXPECT_GT(jobs_, 5);
}

INSTANTIATE_TEST_SUITE_P(On, CatalogCrashTest, EachDatabase(), DatabaseName);

}  // namespace
}  // namespace cohort
