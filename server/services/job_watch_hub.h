#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>

#include "cohort/v1/job_service.grpc.pb.h"
#include "common/base/mutex.h"
#include "server/core/coordinator.h"

namespace cohort {

class JobWatch;

/// Passes changes of jobs on to the open WatchJob streams: a new state or stage at once, progress
/// within it ten times a second. A slow client gets the newest state only; it never holds up anyone
/// else. Thread-safe.
class JobWatchHub final : public JobObserver {
 public:
  void OnJobChanged(const Job& job) override;

  /// Starts a stream that begins with `job` if it is newer than `since_version`.
  /// @return the reactor, which frees itself when the stream is over.
  grpc::ServerWriteReactor<v1::WatchJobResponse>* Watch(const Job& job, int64_t since_version);

  /// Ends every stream with UNAVAILABLE ("server is stopping"), and those that come later.
  void Close();

 private:
  friend class JobWatch;
  void Remove(const std::shared_ptr<JobWatch>& watch);

  Mutex mutex_;
  std::map<JobId, std::set<std::shared_ptr<JobWatch>>> watches_ ABSL_GUARDED_BY(mutex_);
  bool closed_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace cohort
