#include "server/services/job_watch_hub.h"

#include <chrono>
#include <optional>
#include <utility>
#include <vector>

#include <grpcpp/alarm.h>

#include "common/rpc/convert.h"
#include "common/rpc/grpc_status.h"

namespace cohort {
namespace {

/// Progress alone is sent no more often: nobody reads faster, and a job has a change for each task.
constexpr std::chrono::milliseconds kLeastPause(100);

/// What people wait for; the rest of a job is progress.
struct Milestone {
  JobState state = JobState::kQueued;
  std::string stage;
  std::string waiting_for;
  friend bool operator==(const Milestone&, const Milestone&) = default;
};

Milestone MilestoneOf(const Job& job) {
  return {.state = job.state, .stage = job.progress.stage, .waiting_for = job.progress.waiting_for};
}

}  // namespace

/// One open stream: one write at a time, and between writes only the newest state is kept. gRPC may
/// call back from inside StartWrite and Finish, so neither is called with a lock held. Lives as
/// long as gRPC (through self_) or the hub uses it.
class JobWatch final : public grpc::ServerWriteReactor<v1::WatchJobResponse>,
                       public std::enable_shared_from_this<JobWatch> {
 public:
  JobWatch(JobWatchHub& hub, JobId id, int64_t since_version)
      : hub_(hub), id_(std::move(id)), sent_version_(since_version) {}

  void HoldUntilDone(std::shared_ptr<JobWatch> self) { self_ = std::move(self); }
  [[nodiscard]] const JobId& Id() const { return id_; }

  void Offer(const Job& job) {
    {
      MutexLock lock(mutex_);
      if (!newest_ || newest_->version < job.version) {
        newest_ = job;
      }
    }
    Pump();
  }

  void End(const grpc::Status& status) {
    {
      MutexLock lock(mutex_);
      if (!end_) {
        end_ = status;
      }
    }
    Pump();
  }

  void OnWriteDone(bool ok) override {
    {
      MutexLock lock(mutex_);
      writing_ = false;
      if (!ok && !end_) {
        end_ = grpc::Status::CANCELLED;
      }
    }
    Pump();
  }
  void OnCancel() override { End(grpc::Status::CANCELLED); }
  void OnDone() override {
    hub_.Remove(self_);
    self_.reset();  // May delete this.
  }

 private:
  /// Starts the next write, or finishes, unless a write is under way.
  void Pump() {
    std::optional<grpc::Status> finish;
    {
      MutexLock lock(mutex_);
      if (finished_ || writing_) {
        return;
      }
      if (!end_ && newest_ && newest_->version > sent_version_) {
        if (MustWait()) {
          return;
        }
        sent_version_ = newest_->version;
        sent_ = MilestoneOf(*newest_);
        sent_at_ = std::chrono::steady_clock::now();
        *message_.mutable_job() = ToProto(*newest_);
        writing_ = true;
      } else if (end_ || (newest_ && IsFinal(newest_->state))) {
        finish = end_.value_or(grpc::Status::OK);
        finished_ = true;
      } else {
        return;
      }
    }
    if (finish) {
      Finish(*finish);
    } else {
      StartWrite(&message_);
    }
  }

  /// Whether the newest state is to be sent later; then Pump is called again by itself.
  bool MustWait() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    const auto wait = sent_at_ + kLeastPause - std::chrono::steady_clock::now();
    if (!sent_ || *sent_ != MilestoneOf(*newest_) || wait <= wait.zero()) {
      return false;
    }
    if (!pausing_) {
      pausing_ = true;
      // A new one each time: the last may be what calls us now.
      alarm_ = std::make_unique<grpc::Alarm>();
      alarm_->Set(std::chrono::system_clock::now() + wait,
                  [watch = weak_from_this()](bool /*expired*/) {
                    if (const auto held = watch.lock()) {
                      held->EndPause();
                    }
                  });
    }
    return true;
  }
  void EndPause() {
    {
      MutexLock lock(mutex_);
      pausing_ = false;
      sent_at_ = {};
    }
    Pump();
  }

  JobWatchHub& hub_;
  const JobId id_;
  std::shared_ptr<JobWatch> self_;
  Mutex mutex_;
  std::optional<Job> newest_ ABSL_GUARDED_BY(mutex_);
  std::optional<grpc::Status> end_ ABSL_GUARDED_BY(mutex_);
  int64_t sent_version_ ABSL_GUARDED_BY(mutex_);
  std::optional<Milestone> sent_ ABSL_GUARDED_BY(mutex_);  ///< In this stream.
  std::chrono::steady_clock::time_point sent_at_ ABSL_GUARDED_BY(mutex_);
  bool pausing_ ABSL_GUARDED_BY(mutex_) = false;
  std::unique_ptr<grpc::Alarm> alarm_ ABSL_GUARDED_BY(mutex_);
  bool writing_ ABSL_GUARDED_BY(mutex_) = false;
  bool finished_ ABSL_GUARDED_BY(mutex_) = false;
  v1::WatchJobResponse message_;  ///< Belongs to gRPC while writing_.
};

void JobWatchHub::OnJobChanged(const Job& job) {
  std::set<std::shared_ptr<JobWatch>> watches;
  {
    MutexLock lock(mutex_);
    const auto found = watches_.find(job.id);
    if (found == watches_.end()) {
      return;
    }
    watches = found->second;
  }
  for (const auto& watch : watches) {
    watch->Offer(job);
  }
}

grpc::ServerWriteReactor<v1::WatchJobResponse>* JobWatchHub::Watch(const Job& job,
                                                                   int64_t since_version) {
  const auto watch = std::make_shared<JobWatch>(*this, job.id, since_version);
  watch->HoldUntilDone(watch);
  bool closed = false;
  {
    MutexLock lock(mutex_);
    closed = closed_;
    watches_[job.id].insert(watch);
  }
  if (closed) {
    watch->End(ToGrpcStatus(absl::UnavailableError("server is stopping")));
  } else {
    watch->Offer(job);
  }
  return watch.get();
}

void JobWatchHub::Remove(const std::shared_ptr<JobWatch>& watch) {
  MutexLock lock(mutex_);
  const auto found = watches_.find(watch->Id());
  if (found != watches_.end()) {
    found->second.erase(watch);
    if (found->second.empty()) {
      watches_.erase(found);
    }
  }
}

void JobWatchHub::Close() {
  std::vector<std::shared_ptr<JobWatch>> all;
  {
    MutexLock lock(mutex_);
    closed_ = true;
    for (const auto& [id, watches] : watches_) {
      all.insert(all.end(), watches.begin(), watches.end());
    }
  }
  for (const auto& watch : all) {
    watch->End(ToGrpcStatus(absl::UnavailableError("server is stopping")));
  }
}

}  // namespace cohort
