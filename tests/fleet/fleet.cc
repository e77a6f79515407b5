// A simulated fleet: thousands of workers that speak the real protocol to a real server process
// with a real catalog, and answer every task after a while with a made-up result. Measures what the
// server can take: completions a second, how long calls last, its memory.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <mutex>
#include <optional>
#include <queue>
#include <string>
#include <thread>
#include <vector>

#include <absl/strings/str_cat.h>
#include <grpcpp/grpcpp.h>
#include <CLI/CLI.hpp>

#include "client/child_process.h"
#include "client/session.h"
#include "common/base/process.h"
#include "common/base/random.h"
#include "common/base/status_macros.h"
#include "common/jobs/blobs.h"
#include "common/jobs/worker_build.h"
#include "common/rpc/channel.h"
#include "worker/grpc_coordinator_link.h"

namespace cohort {
namespace {

using Clock = std::chrono::steady_clock;

/// Claimed of every mesh: so many that each tile holds a single pair of meshes.
constexpr int64_t kClaimedVertices = 40'000'000;
constexpr size_t kUploadBytes = 4 << 20;

struct Options {
  std::string server_program;
  std::string folder = "/tmp";
  int workers = 500;
  int64_t tasks = 15'000;
  double task_seconds = 0.5;
  bool carries_reports = false;
  int threads = 24;   ///< Calls under way at once.
  int channels = 24;  ///< Connections.
  int watchers = 0;
  int uploads = 0;
  uint64_t seed = 1;
  double least_rate = 0;    ///< Completions a second.
  double most_sync_ms = 0;  ///< 99th percentile.
  double most_server_mb = 0;
};

/// How long calls lasted. Thread-safe.
class Latencies {
 public:
  void Add(Clock::duration duration) {
    const std::lock_guard lock(mutex_);
    milliseconds_.push_back(std::chrono::duration<double, std::milli>(duration).count());
  }
  [[nodiscard]] double Quantile(double share) {
    const std::lock_guard lock(mutex_);
    if (milliseconds_.empty()) {
      return 0;
    }
    std::sort(milliseconds_.begin(), milliseconds_.end());
    const auto last = static_cast<double>(milliseconds_.size() - 1);
    return milliseconds_[static_cast<size_t>(std::llround(share * last))];
  }

 private:
  std::mutex mutex_;
  std::vector<double> milliseconds_;
};

/// One worker: computes one task at a time.
struct SimulatedWorker {
  WorkerReport report;
  std::optional<GrantedTask> task;
  GrpcCoordinatorLink* link = nullptr;
};

class Fleet {
 public:
  Fleet(const Options& options, const std::string& address, const Digest& blob)
      : options_(options), random_(options.seed), blob_(blob) {
    for (int i = 0; i < options.channels; ++i) {
      grpc::ChannelArguments arguments;
      arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);  // A connection each.
      links_.push_back(std::make_unique<GrpcCoordinatorLink>(
          grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments),
          address));
    }
    workers_.resize(static_cast<size_t>(options.workers));
    for (size_t i = 0; i < workers_.size(); ++i) {
      workers_[i].link = links_[i % links_.size()].get();
      workers_[i].report.worker = WorkerId{absl::StrCat("simulated-", i)};
      workers_[i].report.build = WorkerBuild();
      workers_[i].report.slots = 1;
      At(random_.Uniform(0, 1), i);
    }
  }

  void Run() {
    std::vector<std::thread> threads;
    threads.reserve(static_cast<size_t>(options_.threads));
    for (int i = 0; i < options_.threads; ++i) {
      threads.emplace_back([this] {
        while (std::optional<size_t> worker = Next()) {
          Serve(workers_[*worker], *worker);
        }
      });
    }
    for (std::thread& thread : threads) {
      thread.join();
    }
  }
  void Stop() {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
    changed_.notify_all();
  }

  std::atomic<int64_t> completed = 0;
  std::atomic<int64_t> superseded = 0;
  std::atomic<int64_t> errors = 0;
  Latencies synchronize;
  Latencies complete;

 private:
  struct Event {
    Clock::time_point at;
    size_t worker;
    bool operator<(const Event& other) const { return at > other.at; }
  };

  void At(double seconds, size_t worker) {
    const std::lock_guard lock(mutex_);
    events_.push(
        {Clock::now() + std::chrono::microseconds(static_cast<int64_t>(seconds * 1e6)), worker});
    changed_.notify_one();
  }
  std::optional<size_t> Next() {
    std::unique_lock lock(mutex_);
    while (!stopped_) {
      if (events_.empty()) {
        changed_.wait(lock);
      } else if (events_.top().at > Clock::now()) {
        changed_.wait_until(lock, events_.top().at);
      } else {
        const size_t worker = events_.top().worker;
        events_.pop();
        return worker;
      }
    }
    return std::nullopt;
  }
  double TaskSeconds() {
    const std::lock_guard lock(mutex_);
    return options_.task_seconds * random_.Uniform(0.5, 1.5);
  }

  /// Reports the task if there is one, and asks for the next: in a call of its own, unless the
  /// result is to carry the report as a worker's does that has another task in hand.
  void Serve(SimulatedWorker& worker, size_t index) {
    worker.report.free_slots = 1;
    std::optional<WorkerOrders> orders;
    if (worker.task) {
      const auto start = Clock::now();
      absl::StatusOr<std::optional<WorkerOrders>> said = worker.link->CompleteTask(
          worker.report.worker, worker.task->lease, Result(*worker.task),
          options_.carries_reports ? std::optional(worker.report) : std::nullopt);
      complete.Add(Clock::now() - start);
      if (!said.ok()) {
        Complain(said.status());
        At(0.5, index);
        return;
      }
      ++completed;
      worker.task.reset();
      orders = *std::move(said);
    }
    if (!orders || orders->grants.empty()) {
      const auto start = Clock::now();
      absl::StatusOr<WorkerOrders> answered = worker.link->Synchronize(worker.report);
      synchronize.Add(Clock::now() - start);
      if (!answered.ok()) {
        Complain(answered.status());
        At(0.5, index);
        return;
      }
      orders = *std::move(answered);
    }
    if (orders->grants.empty()) {
      At(std::max(0.3, orders->next_sync_seconds), index);
      return;
    }
    worker.task = orders->grants[0];
    At(TaskSeconds(), index);
  }
  void Complain(const absl::Status& status) {
    if (++errors <= 3) {
      std::cerr << "fleet: " << status.message() << "\n";
    }
  }

  [[nodiscard]] TaskResult Result(const GrantedTask& granted) const {
    TaskResult result;
    const Task& task = granted.task;
    if (task.kind == TaskKind::kIngest) {
      for (const TaskMesh& mesh : task.meshes) {
        IngestedMesh ingested;
        ingested.index = mesh.index;
        ingested.blob = blob_;
        ingested.vertices = kClaimedVertices;
        ingested.faces = 1;
        ingested.health.vertices = kClaimedVertices;
        ingested.health.diagonal = 200;
        ingested.health.rms_radius = 80;
        result.ingested.push_back(ingested);
      }
      return result;
    }
    if (task.wants_displacement) {
      std::vector<MeshAlignment> alignments;
      for (const TaskMesh& mesh : task.meshes) {
        alignments.push_back({.mesh = mesh.index, .alignment = {}});
      }
      result.alignments = EncodeAlignmentBlob(alignments);
    } else {
      result.output = blob_;
    }
    if (task.kind == TaskKind::kSummarize || task.wants_displacement) {
      result.second_output = blob_;
    }
    if (task.wants_pose) {
      result.poses = blob_;
    }
    if (task.wants_variation) {
      result.variation = blob_;
    }
    result.counters.pairs = 2;
    result.seconds = options_.task_seconds;
    return result;
  }

  const Options options_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::priority_queue<Event> events_;
  bool stopped_ = false;
  Random random_;
  Digest blob_;
  std::vector<std::unique_ptr<GrpcCoordinatorLink>> links_;
  std::vector<SimulatedWorker> workers_;
};

/// Streams and uploads that go on beside the workers.
class Crowd {
 public:
  Crowd(const Options& options, const std::string& address, const JobId& job) {
    for (int i = 0; i < options.watchers; ++i) {
      threads_.emplace_back([this, address, job] {
        const auto session = Session::Open(address);
        if (session.ok()) {
          (void)(*session)->WatchJob(job, [this](const Job&) {
            ++seen;
            return !stop_;
          });
        }
      });
    }
    for (int i = 0; i < options.uploads; ++i) {
      threads_.emplace_back(
          [this, address, i, folder = options.folder] { Upload(address, i, folder); });
    }
  }
  void Stop() {
    stop_ = true;
    for (std::thread& thread : threads_) {
      thread.join();
    }
  }
  std::atomic<int64_t> seen = 0;
  std::atomic<int64_t> uploaded_bytes = 0;

 private:
  void Upload(const std::string& address, int number, const std::string& folder) {
    const auto session = Session::Open(address);
    Random random(static_cast<uint64_t>(number) + 1000);
    for (int round = 0; session.ok() && !stop_; ++round) {
      std::string bytes(kUploadBytes, '\0');
      for (char& byte : bytes) {
        byte = static_cast<char>(random.NextBits());
      }
      const std::string path = absl::StrCat(folder, "/upload-", number);
      std::ofstream(path, std::ios::binary) << bytes;
      SetMesh mesh;
      mesh.name = absl::StrCat("upload-", number, "-", round);
      mesh.raw = Sha256::Of(bytes);
      mesh.size_bytes = static_cast<int64_t>(bytes.size());
      if ((*session)->AddMesh("uploads", mesh, path).ok()) {
        uploaded_bytes += mesh.size_bytes;
      }
    }
  }

  std::atomic<bool> stop_ = false;
  std::vector<std::thread> threads_;
};

/// Peak resident memory of a process, MB.
double PeakMemoryMb(pid_t pid) {
  std::ifstream file(absl::StrCat("/proc/", pid, "/status"));
  std::string line;
  while (std::getline(file, line)) {
    if (line.starts_with("VmHWM:")) {
      return std::stod(line.substr(6)) / 1024;
    }
  }
  return 0;
}

/// A set of so many meshes that the comparison has about `tasks` tiles of one pair.
absl::StatusOr<Job> SubmitJob(Session& session, const Options& options, const Digest& blob) {
  const auto meshes = static_cast<int64_t>(std::sqrt(2.0 * static_cast<double>(options.tasks)));
  for (int64_t i = 0; i < std::max<int64_t>(meshes, 2); ++i) {
    SetMesh mesh;
    mesh.name = absl::StrCat("m", 1'000'000 + i);
    mesh.raw = blob;
    mesh.size_bytes = 4;
    COHORT_RETURN_IF_ERROR(session.AddMesh("fleet", mesh, ""));
  }
  JobSpec spec;
  spec.method = Method::kNone;
  spec.compare.retention = Retention::kMetrics;
  spec.fresh = true;
  return session.CreateJob("fleet", spec, "");
}

/// While it lives, a signal to end this program ends the server with it.
class EndsWithUs {
 public:
  explicit EndsWithUs(int server)
      : thread_([this, server] {
          if (WaitForStopSignal(&is_over_, 0) != 0) {
            ::kill(server, SIGKILL);
            std::_Exit(1);
          }
        }) {}
  ~EndsWithUs() {
    is_over_ = true;
    thread_.join();
  }
  EndsWithUs(const EndsWithUs&) = delete;
  EndsWithUs& operator=(const EndsWithUs&) = delete;

 private:
  std::atomic<bool> is_over_ = false;
  std::thread thread_;
};

absl::Status Run(const Options& options) {
  const std::string socket = options.folder + "/server.sock";
  COHORT_ASSIGN_OR_RETURN(ChildProcess server,
                          ChildProcess::Start(options.server_program,
                                              {"--data", options.folder + "/data", "--listen",
                                               "unix:" + socket, "--log-level", "warn"},
                                              options.folder + "/server.log"));
  const EndsWithUs end(server.Pid());
  const std::string address = "unix:" + socket;
  COHORT_ASSIGN_OR_RETURN(const std::unique_ptr<Session> session, Session::Open(address));
  COHORT_RETURN_IF_ERROR(session->WaitUntilReady(30));
  COHORT_ASSIGN_OR_RETURN(const Digest blob, session->Blobs().Put("fake"));
  COHORT_ASSIGN_OR_RETURN(Job job, SubmitJob(*session, options, blob));
  Crowd crowd(options, address, job.id);
  Fleet fleet(options, address, blob);
  std::thread running([&] { fleet.Run(); });
  const auto start = Clock::now();
  // The rate is that of the comparison alone, where nothing waits for anything.
  std::optional<std::pair<Clock::time_point, int64_t>> first;
  std::optional<std::pair<Clock::time_point, int64_t>> last;
  absl::Status status;
  while (!IsFinal(job.state)) {
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    const absl::StatusOr<Job> now = session->GetJob(job.id);
    if (!now.ok()) {
      status = now.status();
      break;
    }
    job = *now;
    if (job.progress.stage == "compare") {
      last = {Clock::now(), fleet.completed};
      first = first.value_or(*last);
    }
  }
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  const double memory_mb = PeakMemoryMb(server.Pid());
  fleet.Stop();
  running.join();
  crowd.Stop();
  COHORT_RETURN_IF_ERROR(status);
  if (job.state != JobState::kSucceeded) {
    return absl::InternalError(absl::StrCat("the job has failed: ", job.error));
  }
  const double rate = last && last->first > first->first
                          ? static_cast<double>(last->second - first->second) /
                                std::chrono::duration<double>(last->first - first->first).count()
                          : static_cast<double>(job.progress.tasks_done) / seconds;
  const double sync_ms = fleet.synchronize.Quantile(0.99);
  std::printf(
      "fleet: %d workers, %lld tasks in %.1f s: %.0f completions a second; Synchronize p50 %.1f "
      "ms, "
      "p99 %.1f ms; CompleteTask p99 %.1f ms; %lld calls failed; server %.0f MB%s\n",
      options.workers, static_cast<long long>(job.progress.tasks_done), seconds, rate,
      fleet.synchronize.Quantile(0.5), sync_ms, fleet.complete.Quantile(0.99),
      static_cast<long long>(fleet.errors), memory_mb,
      options.watchers + options.uploads > 0
          ? absl::StrCat("; ", options.watchers, " streams saw ", crowd.seen.load(), " changes, ",
                         options.uploads, " clients sent ", crowd.uploaded_bytes >> 20, " MiB")
                .c_str()
          : "");
  if (job.progress.tasks_done != job.progress.tasks_total) {
    return absl::InternalError("the job ended with tasks undone");
  }
  if (rate < options.least_rate) {
    return absl::InternalError(absl::StrCat("fewer than ", options.least_rate, " a second"));
  }
  if (options.most_sync_ms > 0 && sync_ms > options.most_sync_ms) {
    return absl::InternalError(absl::StrCat("p99 above ", options.most_sync_ms, " ms"));
  }
  if (options.most_server_mb > 0 && memory_mb > options.most_server_mb) {
    return absl::InternalError(absl::StrCat("server above ", options.most_server_mb, " MB"));
  }
  return absl::OkStatus();
}

int Main(int argc, char** argv) {
  CLI::App app("cohort-fleet: what a server takes from thousands of workers.");
  Options options;
  options.server_program = SiblingProgram("cohort-server");
  app.add_option("--server-program", options.server_program)->capture_default_str();
  app.add_option("--folder", options.folder, "empty folder for the server's data")->required();
  app.add_option("--workers", options.workers)->capture_default_str();
  app.add_option("--tasks", options.tasks)->capture_default_str();
  app.add_option("--task-seconds", options.task_seconds)->capture_default_str();
  app.add_flag("--carry-reports", options.carries_reports, "results carry the next report");
  app.add_option("--threads", options.threads, "calls under way at once")->capture_default_str();
  app.add_option("--channels", options.channels, "connections")->capture_default_str();
  app.add_option("--watchers", options.watchers, "WatchJob streams besides");
  app.add_option("--uploads", options.uploads, "clients that send meshes besides");
  app.add_option("--seed", options.seed)->capture_default_str();
  app.add_option("--least-rate", options.least_rate, "fails below; completions a second");
  app.add_option("--most-sync-ms", options.most_sync_ms, "fails above; 99th percentile");
  app.add_option("--most-server-mb", options.most_server_mb, "fails above; peak memory");
  CLI11_PARSE(app, argc, argv);
  const absl::Status status = Run(options);
  if (!status.ok()) {
    std::cerr << "fleet: FAILED: " << status.message() << "\n";
    return 1;
  }
  return 0;
}

}  // namespace
}  // namespace cohort

int main(int argc, char** argv) {
  cohort::BlockStopSignals();
  try {
    return cohort::Main(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "fleet: FAILED: " << error.what() << "\n";
    return 1;
  }
}
