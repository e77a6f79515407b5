#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <absl/status/statusor.h>

#include "client/child_process.h"
#include "client/memory_folder.h"
#include "common/base/mutex.h"

namespace cohort {

struct LocalClusterOptions {
  std::filesystem::path data_dir;  ///< Catalog, blobs and logs.
  int workers = 1;                 ///< 0: the server alone, to read what is there.
  int threads = 0;                 ///< Of each worker; 0: processors / workers.
  /// Called, from a thread of the cluster, when a member dies over and over: everything has been
  /// stopped then, and who waits for the server would wait long.
  std::function<void(const absl::Status&)> on_failure = {};
};

/// For programs that do nothing but wait for the cluster: says on stderr why it cannot go on, and
/// ends the process. @param data_dir  where the logs are.
[[nodiscard]] std::function<void(const absl::Status&)> EndProgramOnFailure(
    const std::filesystem::path& data_dir);

/// A server and its workers as child processes on a unix socket: what `cohort run` computes with.
/// A child that dies is started again, as long as that does not happen over and over.
class LocalCluster {
 public:
  /// @return as ChildProcess::Start.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<LocalCluster>> Start(
      const LocalClusterOptions& options);
  ~LocalCluster();
  LocalCluster(const LocalCluster&) = delete;
  LocalCluster& operator=(const LocalCluster&) = delete;

  /// Address of the server, "unix:PATH".
  [[nodiscard]] const std::string& Address() const { return address_; }
  /// Why it cannot go on; OK while it can.
  [[nodiscard]] absl::Status Health();
  /// Stops everything; the data folder stays.
  void Stop();

 private:
  struct Member {
    std::string name;  ///< "server", "worker-1"; of its log file too.
    std::filesystem::path program;
    std::vector<std::string> arguments;
    ChildProcess process;
    int restarts = 0;
  };

  explicit LocalCluster(const LocalClusterOptions& options) : options_(options) {}
  absl::Status StartMember(const std::string& name,
                           const std::string& program,
                           const std::vector<std::string>& arguments);
  /// Until the server listens.
  absl::Status WaitForServer();
  void Supervise();
  void RestartIfDead(Member& member) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void StopMembers() ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] std::filesystem::path LogOf(const std::string& name) const;

  const LocalClusterOptions options_;
  std::filesystem::path socket_dir_;
  std::string address_;
  std::unique_ptr<MemoryFolder> shared_;  ///< What several workers share.
  Mutex mutex_;
  std::vector<Member> members_ ABSL_GUARDED_BY(mutex_);
  absl::Status health_ ABSL_GUARDED_BY(mutex_);
  std::atomic<bool> stopping_ = false;
  std::thread supervisor_;
};

}  // namespace cohort
