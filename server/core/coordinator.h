#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <absl/status/statusor.h>

#include "common/base/clock.h"
#include "common/base/mutex.h"
#include "common/jobs/job_state.h"
#include "common/jobs/lease.h"
#include "common/jobs/task.h"
#include "common/jobs/worker_protocol.h"
#include "common/store/blob_store.h"
#include "server/catalog/catalog.h"
#include "server/core/active_job.h"
#include "server/results/matrix_builder.h"
#include "server/scheduling/scheduler.h"

namespace cohort {

struct CoordinatorOptions {
  SchedulerOptions scheduler;
  std::string build;  ///< Workers of another build are refused.
};

/// Hears of every change of a job. Called without any lock held, possibly from several threads.
class JobObserver {
 public:
  virtual ~JobObserver() = default;
  virtual void OnJobChanged(const Job& job) = 0;
};

/// Every use case of the server, one method each; all front ends call only this.
///
/// What a method acknowledges is in the catalog before it returns. Catalog writes happen under the
/// one lock, so that memory never runs ahead of the disk. Thread-safe.
class Coordinator {
 public:
  /// Takes up the unfinished jobs of the catalog; their workers have one lease time to report in.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<Coordinator>> Create(
      const CoordinatorOptions& options, Catalog& catalog, BlobStore& store, const Clock& clock);

  /// Set before the first call, or null.
  void SetObserver(JobObserver* observer) { observer_ = observer; }

  // Sets and meshes.
  /// @return kInvalidArgument for a bad name; kFailedPrecondition (BLOB_MISSING) if the bytes are
  ///         not in the store; kAlreadyExists if the set has other bytes under that name.
  [[nodiscard]] absl::StatusOr<SetMesh> AddMesh(const std::string& set, const SetMesh& mesh);
  [[nodiscard]] absl::StatusOr<std::vector<Digest>> FindMissing(const std::vector<Digest>& digests);
  [[nodiscard]] absl::StatusOr<Page<SetMesh>> ListMeshes(const std::string& set,
                                                         int page_size,
                                                         const std::string& token);
  [[nodiscard]] absl::StatusOr<Page<MeshSet>> ListSets(int page_size, const std::string& token);

  // Jobs.
  /// @return also kFailedPrecondition (BLOB_MISSING) if the spec's landmarks are not in the store.
  [[nodiscard]] absl::StatusOr<Job> CreateJob(const std::string& set,
                                              const JobSpec& spec,
                                              const std::string& request_id);
  [[nodiscard]] absl::StatusOr<Job> GetJob(const JobId& id);
  [[nodiscard]] absl::StatusOr<Page<Job>> ListJobs(int page_size, const std::string& token);
  /// Cancels; a job that has ended stays as it is.
  [[nodiscard]] absl::StatusOr<Job> CancelJob(const JobId& id);

  // Results.
  [[nodiscard]] absl::StatusOr<std::vector<JobMesh>> GetJobMeshes(const JobId& id);
  /// @return kFailedPrecondition (JOB_NOT_FINISHED) unless the job has succeeded.
  [[nodiscard]] absl::StatusOr<JobOutputs> GetOutputs(const JobId& id);
  /// Hands out the directed values of one metric block by block, until `consume` returns false.
  /// @return as GetOutputs and ForEachMatrixBlock.
  [[nodiscard]] absl::Status GetMatrix(const JobId& id,
                                       Metric metric,
                                       const std::function<bool(const MatrixBlock&)>& consume);
  /// Hands out the preview block by block, until `consume` returns false; also of a job that goes
  /// on.
  /// @return kFailedPrecondition if the job makes none (JOB_HAS_NO_PREVIEW) or has not come to it
  ///         (JOB_NOT_FINISHED); as ForEachPreviewBlock.
  [[nodiscard]] absl::Status GetPreview(const JobId& id,
                                        const std::function<bool(const PreviewBlock&)>& consume);

  // Workers.
  /// @param is_cancelled  asked while waiting and before granting: the caller has gone.
  /// @return kFailedPrecondition (BUILD_MISMATCH) for a worker of another build.
  [[nodiscard]] absl::StatusOr<WorkerOrders> Synchronize(const WorkerReport& report,
                                                         const std::function<bool()>& is_cancelled);
  /// True: the result was taken. False: done already or not wanted any more.
  /// @return kFailedPrecondition (BLOB_MISSING) if an output is not in the store.
  [[nodiscard]] absl::StatusOr<bool> CompleteTask(const WorkerId& worker,
                                                  const Lease& lease,
                                                  const TaskResult& result);
  [[nodiscard]] absl::Status ReleaseTask(const WorkerId& worker, const Lease& lease);
  [[nodiscard]] absl::Status FailTask(const WorkerId& worker,
                                      const Lease& lease,
                                      const absl::Status& failure);

  /// Ends all waiting Synchronize calls at once and refuses to grant from then on.
  void Stop();

  [[nodiscard]] BlobStore& Store() { return store_; }

 private:
  Coordinator(const CoordinatorOptions& options,
              Catalog& catalog,
              BlobStore& store,
              const Clock& clock);

  absl::Status Recover();
  absl::Status RecoverJob(const Job& job) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Schedules what the plan has made ready; ends the job if nothing is left.
  absl::Status Advance(ActiveJob& active) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Ingest of files that are known already needs no worker.
  absl::StatusOr<bool> FinishFromKnown(ActiveJob& active, const Task& task)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status EndJob(ActiveJob& active, JobState state, const std::string& error)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status GiveUpTasks(const std::vector<TaskId>& tasks) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// What the worker's free slots take; for its spare ones only while there is plenty.
  absl::StatusOr<std::vector<GrantedTask>> GrantTasks(const WorkerReport& report)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status CheckOutputs(const TaskResult& result);
  absl::StatusOr<JobOutputs> OutputsSoFar(const JobId& id) ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status CheckLandmarks(const JobSpec& spec);
  void Touch(ActiveJob& active) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Drops ended jobs and returns what observers are to hear.
  std::vector<Job> TakeChanges() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Notify(const std::vector<Job>& changes);
  [[nodiscard]] int64_t WallMs() const;
  /// The plan's progress; the times of the stages are the job's own.
  static void SetProgress(Progress progress, Job& job);
  /// A task of the stage was handed out or done.
  void NoteStage(const std::string& stage, Job& job) const;

  const CoordinatorOptions options_;
  Catalog& catalog_;
  BlobStore& store_;
  const Clock& clock_;
  JobObserver* observer_ = nullptr;

  Mutex mutex_;
  CondVar work_;  ///< Tasks may have become ready, or the server stops.
  Scheduler scheduler_ ABSL_GUARDED_BY(mutex_);
  std::map<JobId, ActiveJob> active_ ABSL_GUARDED_BY(mutex_);
  std::vector<Job> changes_ ABSL_GUARDED_BY(mutex_);
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace cohort
