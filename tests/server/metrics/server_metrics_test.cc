// The page of a server whose coordinator is driven by hand, read as Prometheus reads it.
#include "server/metrics/server_metrics.h"

#include <filesystem>
#include <map>
#include <memory>
#include <set>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <unistd.h>

#include "common/base/version.h"
#include "common/store/memory_blob_store.h"
#include "server/core/coordinator.h"
#include "tests/testing/demo_scans.h"
#include "tests/testing/fake_clock.h"
#include "tests/testing/status_matchers.h"
#include "worker/tasks/mesh_cache.h"
#include "worker/tasks/task_runner.h"

namespace cohort {
namespace {

using ::testing::EndsWith;
using ::testing::Gt;
using testing::IsOk;
using ::testing::MatchesRegex;

constexpr double kLeaseSeconds = 10;

/// A page as text, taken apart.
struct ParsedPage {
  std::map<std::string, std::string> help;
  std::map<std::string, std::string> type;
  std::map<std::string, double> values;  ///< By name with labels, as written.
};

ParsedPage Parse(const MetricPage& page) {
  ParsedPage parsed;
  std::istringstream lines(page.Text());
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string first;
    std::string name;
    words >> first;
    if (first == "#") {
      words >> first >> name;
      std::string rest;
      std::getline(words >> std::ws, rest);
      (first == "HELP" ? parsed.help : parsed.type)[name] = rest;
      continue;
    }
    const size_t space = line.rfind(' ');
    parsed.values[line.substr(0, space)] = std::stod(line.substr(space + 1));
  }
  return parsed;
}

class ServerMetricsTest : public ::testing::Test {
 protected:
  ServerMetricsTest() {
    folder_ = std::filesystem::temp_directory_path() /
              ("server_metrics_test-" + std::to_string(getpid()) + "-" +
               ::testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
    catalog_ = *Catalog::Open(folder_ / "catalog.db");
    CoordinatorOptions options;
    options.scheduler.lease_seconds = kLeaseSeconds;
    options.build = "1";
    coordinator_ = *Coordinator::Create(options, *catalog_, store_, clock_);
  }
  ~ServerMetricsTest() override {
    coordinator_.reset();
    catalog_.reset();
    std::filesystem::remove_all(folder_);
  }

  void AddScans(int people) {
    for (const SetMesh& mesh : testing::PutDemoScans(store_, people, 1)) {
      ASSERT_THAT(coordinator_->AddMesh("set", mesh), IsOk());
    }
  }

  Job Submit() {
    JobSpec spec;
    spec.rounds = 1;
    spec.icp.max_iterations = 3;
    return *coordinator_->CreateJob("set", spec, "");
  }

  WorkerOrders Report(const std::string& worker, int free, const std::vector<HeldTask>& held) {
    WorkerReport report{.worker = WorkerId{worker}, .build = "1", .held = held, .free_slots = free};
    report.slots = 2;
    return *coordinator_->Synchronize(report, [] { return false; });
  }

  bool Do(const std::string& worker, const GrantedTask& granted) {
    MeshCache cache(store_, 1 << 20);
    TaskRunner runner(store_, cache);
    return *coordinator_->CompleteTask(WorkerId{worker}, granted.lease,
                                       *runner.Run(granted.task, {}));
  }

  void WorkUntilDone() {
    while (true) {
      const WorkerOrders orders = Report("w", 1, {});
      if (orders.grants.empty()) {
        return;
      }
      Do("w", orders.grants[0]);
    }
  }

  [[nodiscard]] ParsedPage Page() const {
    return Parse(MakeServerPage(coordinator_->Figures(),
                                {.start_unix_seconds = 5, .store_free_bytes = 1000}));
  }

  std::filesystem::path folder_;
  testing::FakeClock clock_;
  MemoryBlobStore store_;
  std::unique_ptr<Catalog> catalog_;
  std::unique_ptr<Coordinator> coordinator_;
};

TEST_F(ServerMetricsTest, EveryMetricHasHelpATypeAndANameOfTheConventions) {
  AddScans(3);
  Submit();
  WorkUntilDone();
  const ParsedPage page = Page();
  std::set<std::string> described;
  for (const auto& [name, help] : page.help) {
    described.insert(name);
    EXPECT_THAT(name, MatchesRegex("cohort_[a-z_]+"));
    EXPECT_GT(help.size(), 10U) << name;
    ASSERT_TRUE(page.type.contains(name)) << name;
    if (page.type.at(name) == "counter") {
      EXPECT_THAT(name, EndsWith("_total"));
    }
  }
  for (const auto& [key, value] : page.values) {
    std::string name = key.substr(0, key.find('{'));
    for (const std::string suffix : {"_bucket", "_sum", "_count"}) {
      const std::string base = name.substr(0, name.size() - std::min(name.size(), suffix.size()));
      if (base + suffix == name && page.type.contains(base) && page.type.at(base) == "histogram") {
        name = base;
        break;
      }
    }
    EXPECT_TRUE(described.contains(name)) << key;
  }
  EXPECT_GE(described.size(), 20U);
  EXPECT_EQ(page.values.at("cohort_build_info{program=\"cohort-server\",version=\"" +
                           std::string(BuildVersion()) + "\"}"),
            1);
  EXPECT_EQ(page.values.at("cohort_store_free_bytes"), 1000);
}

TEST_F(ServerMetricsTest, CountsTasksJobsAndWorkersThroughAJob) {
  AddScans(3);
  EXPECT_EQ(Page().values.at("cohort_tasks_ready"), 0);
  Submit();
  ParsedPage page = Page();
  EXPECT_EQ(page.values.at("cohort_tasks_ready"), 3) << "one ingest for each mesh";
  EXPECT_EQ(page.values.at("cohort_jobs{state=\"queued\"}"), 1);
  EXPECT_EQ(page.values.at("cohort_workers"), 0);

  const std::vector<GrantedTask> tasks = Report("w", 2, {}).grants;
  ASSERT_EQ(tasks.size(), 2U);
  Report("w", 0, {{.lease = tasks[0].lease, .ticks = 3}, {.lease = tasks[1].lease}});
  page = Page();
  EXPECT_EQ(page.values.at("cohort_tasks_ready"), 1);
  EXPECT_EQ(page.values.at("cohort_tasks_leased"), 2);
  EXPECT_EQ(page.values.at("cohort_jobs{state=\"queued\"}"), 0);
  EXPECT_EQ(page.values.at("cohort_jobs{state=\"running\"}"), 1);
  EXPECT_EQ(page.values.at("cohort_workers"), 1);
  EXPECT_EQ(page.values.at("cohort_worker_slots"), 2);
  EXPECT_EQ(page.values.at("cohort_worker_slots_busy"), 1) << "the other is not begun";
  EXPECT_EQ(page.values.at("cohort_synchronize_seconds_count"), 2);

  EXPECT_TRUE(Do("w", tasks[0]));
  EXPECT_FALSE(Do("w", tasks[0])) << "a second time";
  ASSERT_THAT(coordinator_->FailTask({"w"}, tasks[1].lease, absl::InternalError("no")), IsOk());
  page = Page();
  EXPECT_EQ(page.values.at("cohort_tasks_completed_total{stage=\"ingest\"}"), 1);
  EXPECT_EQ(page.values.at("cohort_tasks_superseded_total"), 1);
  EXPECT_EQ(page.values.at("cohort_tasks_failed_total"), 1);
  EXPECT_EQ(page.values.at("cohort_complete_task_seconds_count"), 2);
  EXPECT_THAT(page.values.at("cohort_catalog_write_seconds_count"), Gt(3));

  clock_.Advance(2);  // Over the back-off of the failed one.
  WorkUntilDone();
  page = Page();
  EXPECT_EQ(page.values.at("cohort_tasks_completed_total{stage=\"ingest\"}"), 3);
  EXPECT_GT(page.values.at("cohort_task_seconds_total{stage=\"align\"}"), 0) << "align 1 and 2";
  EXPECT_EQ(page.values.at("cohort_tasks_ready"), 0);
  EXPECT_EQ(page.values.at("cohort_jobs{state=\"running\"}"), 0);
  EXPECT_EQ(page.values.at("cohort_jobs_ended_total{state=\"succeeded\"}"), 1);
  EXPECT_EQ(page.values.at("cohort_tasks_reused_total"), 0);
  const double done = static_cast<double>(Submit().progress.tasks_done);
  EXPECT_EQ(Page().values.at("cohort_tasks_reused_total"), done);
}

TEST_F(ServerMetricsTest, TellsHowLongReadyTasksHaveWaitedAndWhatASilentWorkerLost) {
  AddScans(3);
  Submit();
  EXPECT_EQ(Page().values.at("cohort_tasks_ready_wait_seconds"), 0);
  clock_.Advance(7);
  EXPECT_EQ(Page().values.at("cohort_tasks_ready_wait_seconds"), 7);
  const std::vector<GrantedTask> tasks = Report("w", 1, {}).grants;
  EXPECT_EQ(Page().values.at("cohort_tasks_ready_wait_seconds"), 0) << "one was handed out";
  clock_.Advance(11);
  ASSERT_THAT(coordinator_->Tick(), IsOk());
  const ParsedPage page = Page();
  EXPECT_EQ(page.values.at("cohort_tasks_lost_total"), 1);
  EXPECT_EQ(page.values.at("cohort_workers"), 0) << "silent for longer than a lease";
  EXPECT_EQ(page.values.at("cohort_tasks_ready"), 3);
}

TEST(MetricPage, WritesAHistogramThatAddsUp) {
  CallTimer timer;
  timer.Add(0.0001);
  timer.Add(0.001);  // A bound belongs to its bin.
  timer.Add(0.3);
  timer.Add(100);
  MetricPage page;
  page.AddHistogram("cohort_x_seconds", "Nothing but a test.", timer.Times());
  const ParsedPage parsed = Parse(page);
  EXPECT_EQ(parsed.values.at("cohort_x_seconds_bucket{le=\"0.0005\"}"), 1);
  EXPECT_EQ(parsed.values.at("cohort_x_seconds_bucket{le=\"0.001\"}"), 2);
  EXPECT_EQ(parsed.values.at("cohort_x_seconds_bucket{le=\"0.25\"}"), 2);
  EXPECT_EQ(parsed.values.at("cohort_x_seconds_bucket{le=\"0.5\"}"), 3);
  EXPECT_EQ(parsed.values.at("cohort_x_seconds_bucket{le=\"25\"}"), 3);
  EXPECT_EQ(parsed.values.at("cohort_x_seconds_bucket{le=\"+Inf\"}"), 4);
  EXPECT_EQ(parsed.values.at("cohort_x_seconds_count"), 4);
  EXPECT_DOUBLE_EQ(parsed.values.at("cohort_x_seconds_sum"), 100.3011);
}

}  // namespace
}  // namespace cohort
