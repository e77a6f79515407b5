#include "client/local_cluster.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <utility>

#include "common/base/status_macros.h"
#include "common/geometry/nearest/instruction_set.h"

namespace cohort {
namespace {

constexpr int kMaxRestarts = 5;
constexpr std::chrono::milliseconds kSuperviseStep(100);
constexpr double kStopSeconds = 6;
constexpr std::chrono::seconds kStartTime(60);

}  // namespace

std::function<void(const absl::Status&)> EndProgramOnFailure(
    const std::filesystem::path& data_dir) {
  return [data_dir](const absl::Status& failure) {
    std::fprintf(stderr, "\ncohort: logs are in %s; what is done is not done again\ncohort: %s\n",
                 data_dir.c_str(), std::string(failure.message()).c_str());
    std::_Exit(EXIT_FAILURE);
  };
}

absl::StatusOr<std::unique_ptr<LocalCluster>> LocalCluster::Start(
    const LocalClusterOptions& options) {
  // Workers would refuse it, one after the other.
  COHORT_RETURN_IF_ERROR(ChooseInstructionSet().status());
  std::unique_ptr<LocalCluster> cluster(new LocalCluster(options));
  // Not in the data folder: a socket's path may have 107 bytes at most.
  std::string socket_dir = (std::filesystem::temp_directory_path() / "cohort-XXXXXX").string();
  if (mkdtemp(socket_dir.data()) == nullptr) {
    return absl::UnavailableError("cannot create a folder " + socket_dir + " for the socket");
  }
  cluster->socket_dir_ = socket_dir;
  cluster->address_ = "unix:" + socket_dir + "/server.sock";
  const std::string parent = std::to_string(getpid());
  COHORT_RETURN_IF_ERROR(cluster->StartMember(
      "server", "cohort-server",
      {"--data", options.data_dir.string(), "--listen", cluster->address_, "--lease-seconds", "10",
       // A laptop's disk is often nearly full, and one job is all that is written here: it fails
       // when there is really no space.
       "--min-free-percent", "0", "--min-free-gb", "0", "--port-file",
       (cluster->socket_dir_ / "addresses").string(), "--exit-with-parent", parent}));
  COHORT_RETURN_IF_ERROR(cluster->WaitForServer());
  const int processors = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  const int threads = options.threads > 0 ? options.threads
                                          : std::max(1, processors / std::max(1, options.workers));
  std::vector<std::string> worker = {"--server",
                                     cluster->address_,
                                     "--store",
                                     (options.data_dir / "blobs").string(),
                                     "--threads",
                                     std::to_string(threads),
                                     "--drain-seconds",
                                     "1",
                                     "--exit-with-parent",
                                     parent};
  if (options.workers > 1) {
    cluster->shared_ = MemoryFolder::Create();
  }
  if (cluster->shared_ != nullptr) {
    worker.insert(worker.end(), {"--share-dir", cluster->shared_->Path().string(), "--share-mb",
                                 std::to_string(cluster->shared_->Megabytes())});
  }
  for (int i = 1; i <= options.workers; ++i) {
    COHORT_RETURN_IF_ERROR(
        cluster->StartMember("worker-" + std::to_string(i), "cohort-worker", worker));
  }
  cluster->supervisor_ = std::thread([raw = cluster.get()] { raw->Supervise(); });
  return cluster;
}

absl::Status LocalCluster::StartMember(const std::string& name,
                                       const std::string& program,
                                       const std::vector<std::string>& arguments) {
  const std::filesystem::path path = SiblingProgram(program);
  COHORT_ASSIGN_OR_RETURN(ChildProcess process, ChildProcess::Start(path, arguments, LogOf(name)));
  MutexLock lock(mutex_);
  members_.push_back(
      {.name = name, .program = path, .arguments = arguments, .process = std::move(process)});
  return absl::OkStatus();
}

absl::Status LocalCluster::WaitForServer() {
  const auto deadline = std::chrono::steady_clock::now() + kStartTime;
  while (!std::filesystem::exists(socket_dir_ / "addresses")) {
    {
      MutexLock lock(mutex_);
      const std::optional<std::string> end = members_.front().process.Ended();
      if (end || std::chrono::steady_clock::now() > deadline) {
        return absl::AbortedError("the server did not start (" + end.value_or("no answer") +
                                  "), see " + LogOf("server").string());
      }
    }
    std::this_thread::sleep_for(kSuperviseStep / 5);
  }
  return absl::OkStatus();
}

std::filesystem::path LocalCluster::LogOf(const std::string& name) const {
  return options_.data_dir / (name + ".log");
}

void LocalCluster::Supervise() {
  while (!stopping_) {
    absl::Status health;
    {
      MutexLock lock(mutex_);
      for (Member& member : members_) {
        RestartIfDead(member);
      }
      health = health_;
    }
    if (!health.ok() && options_.on_failure) {
      StopMembers();
      options_.on_failure(health);
      return;
    }
    std::this_thread::sleep_for(kSuperviseStep);
  }
}

void LocalCluster::RestartIfDead(Member& member) {
  const std::optional<std::string> end = member.process.Ended();
  if (!end || !health_.ok()) {
    return;
  }
  const std::string what =
      member.name + " ended (" + *end + "), see " + LogOf(member.name).string();
  if (++member.restarts > kMaxRestarts) {
    health_ = absl::AbortedError(what + "; it was started " + std::to_string(kMaxRestarts) +
                                 " times before");
    return;
  }
  std::fprintf(stderr, "cohort: %s; starting it again\n", what.c_str());
  absl::StatusOr<ChildProcess> again =
      ChildProcess::Start(member.program, member.arguments, LogOf(member.name));
  if (again.ok()) {
    member.process = *std::move(again);
  } else {
    health_ = again.status();
  }
}

absl::Status LocalCluster::Health() {
  MutexLock lock(mutex_);
  return health_;
}

void LocalCluster::Stop() {
  if (stopping_.exchange(true)) {
    return;
  }
  if (supervisor_.joinable()) {
    supervisor_.join();
  }
  StopMembers();
}

void LocalCluster::StopMembers() {
  MutexLock lock(mutex_);
  // Workers first: they give their tasks back to a server that is still there.
  for (Member& member : members_) {
    if (member.name != "server") {
      member.process.AskToStop();
    }
  }
  for (auto member = members_.rbegin(); member != members_.rend(); ++member) {
    member->process.Stop(kStopSeconds);
  }
  members_.clear();
  std::error_code ignored;  // A temporary folder left behind harms nobody.
  std::filesystem::remove_all(socket_dir_, ignored);
  shared_.reset();
}

LocalCluster::~LocalCluster() {
  Stop();
}

}  // namespace cohort
