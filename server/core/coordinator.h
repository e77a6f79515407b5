#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include <absl/status/statusor.h>

#include "common/base/call_times.h"
#include "common/base/clock.h"
#include "common/base/mutex.h"
#include "common/jobs/action_key.h"
#include "common/jobs/estimate.h"
#include "common/jobs/job_state.h"
#include "common/jobs/lease.h"
#include "common/jobs/task.h"
#include "common/jobs/worker_protocol.h"
#include "common/jobs/worker_status.h"
#include "common/store/managed_blob_store.h"
#include "server/catalog/catalog.h"
#include "server/core/active_job.h"
#include "server/core/coordinator_figures.h"
#include "server/core/garbage.h"
#include "server/core/reference_frame.h"
#include "server/core/store_reserve.h"
#include "server/core/task_rates.h"
#include "server/results/matrix_builder.h"
#include "server/scheduling/scheduler.h"

namespace cohort {

struct CoordinatorOptions {
  SchedulerOptions scheduler;
  std::string build;                      ///< Workers of another build are refused.
  int plan_version = kPlanVersion;        ///< Unfinished jobs of others are started over,
  int results_version = kResultsVersion;  ///< finished ones are not added to.
  int most_waiting = 64;  ///< Workers that may wait for a task inside a call; others call again.
  StoreReserve reserve = {};
  GarbageOptions garbage = {};  ///< Where nobody asks for others.
};

/// What a result that carries the worker's next report is answered.
struct CompletionAnswer {
  bool taken = false;                  ///< As Coordinator::CompleteTask without a report.
  std::optional<WorkerOrders> orders;  ///< None: Synchronize tells the worker why.
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
/// one lock, so that memory never runs ahead of the disk; calls that wait for the lock are written
/// together by the first of them that gets it (group commit). Thread-safe.
class Coordinator {
 public:
  /// Takes up the unfinished jobs of the catalog; their workers have one lease time to report in.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<Coordinator>> Create(
      const CoordinatorOptions& options,
      Catalog& catalog,
      ManagedBlobStore& store,
      const Clock& clock);

  /// Set before the first call, or null.
  void SetObserver(JobObserver* observer) { observer_ = observer; }

  // Sets and meshes.
  /// @return kInvalidArgument for a bad name; kFailedPrecondition (BLOB_MISSING) if the bytes are
  ///         not in the store; kAlreadyExists if the set has other bytes under that name.
  [[nodiscard]] absl::StatusOr<SetMesh> AddMesh(const std::string& set, const SetMesh& mesh);
  /// What is there stays for a day at least, also if no mesh is made of it.
  [[nodiscard]] absl::StatusOr<std::vector<Digest>> FindMissing(const std::vector<Digest>& digests);
  [[nodiscard]] absl::StatusOr<Page<SetMesh>> ListMeshes(const std::string& set,
                                                         int page_size,
                                                         const std::string& token);
  [[nodiscard]] absl::StatusOr<Page<MeshSet>> ListSets(int page_size, const std::string& token);
  /// Takes a mesh out of a set; jobs keep their snapshots. @return kNotFound.
  [[nodiscard]] absl::Status RemoveMesh(const std::string& set, const std::string& name);
  /// @return kNotFound.
  [[nodiscard]] absl::Status DeleteSet(const std::string& set);

  // Jobs.
  /// @return also kFailedPrecondition (BLOB_MISSING) if the spec's landmarks are not in the store;
  ///         as CheckSpace.
  [[nodiscard]] absl::StatusOr<Job> CreateJob(const std::string& set,
                                              const JobSpec& spec,
                                              const std::string& request_id);
  /// What a job would take, before anything is spent.
  /// @return as CreateJob for a job that cannot be planned; not for one that does not fit.
  [[nodiscard]] absl::StatusOr<Estimate> EstimateJob(const std::string& set, const JobSpec& spec);
  [[nodiscard]] absl::StatusOr<Job> GetJob(const JobId& id);
  [[nodiscard]] absl::StatusOr<Page<Job>> ListJobs(int page_size, const std::string& token);
  /// Cancels; a job that has ended stays as it is.
  [[nodiscard]] absl::StatusOr<Job> CancelJob(const JobId& id);
  /// No new tasks from now on. @return kFailedPrecondition (JOB_FINISHED) for one that has ended.
  [[nodiscard]] absl::StatusOr<Job> PauseJob(const JobId& id);
  /// @return as PauseJob; a job that is not paused stays as it is.
  [[nodiscard]] absl::StatusOr<Job> ResumeJob(const JobId& id);
  /// Goes on with a job that failed or was cancelled: what is done stays done, tasks that were
  /// given up are tried again. Or with one that has succeeded and whose results have been damaged
  /// since: it makes again what is lost.
  /// @return kFailedPrecondition (JOB_NOT_FAILED) for any other job.
  [[nodiscard]] absl::StatusOr<Job> RetryJob(const JobId& id);
  /// Removes a job that has ended; its blobs go with the next garbage collection.
  /// @return kFailedPrecondition (JOB_NOT_FINISHED).
  [[nodiscard]] absl::Status DeleteJob(const JobId& id);

  // Results. A blob that cannot be read ends in kDataLoss (BLOB_DAMAGED), which names it and says
  // what to do; it is moved aside, so that the job submitted again makes it again.
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
  /// Both in one: CompleteTask, then Synchronize without a wait. What is granted is written with
  /// the result if it does not depend on it.
  [[nodiscard]] absl::StatusOr<CompletionAnswer> CompleteTask(
      const WorkerId& worker,
      const Lease& lease,
      const TaskResult& result,
      const WorkerReport& next,
      const std::function<bool()>& is_cancelled);
  [[nodiscard]] absl::Status ReleaseTask(const WorkerId& worker, const Lease& lease);
  /// A task that fails too often is given up; the job goes on with the others and fails once
  /// nothing is left that could be done. Two failures are not the task's and do not count: the
  /// store is full, or it has lost a blob that the task reads (UnreadableBlob of `failure`; the
  /// store is asked). Then the job goes back to where the blob is made.
  [[nodiscard]] absl::Status FailTask(const WorkerId& worker,
                                      const Lease& lease,
                                      const absl::Status& failure);

  /// Workers heard of lately, by name.
  [[nodiscard]] std::vector<WorkerStatus> ListWorkers();

  /// What goes on now and has happened since the start, for those who watch over the server.
  [[nodiscard]] CoordinatorFigures Figures();

  /// To be called about once a second: takes back what silent workers had, and goes on with jobs
  /// that a missed notification would have left standing.
  [[nodiscard]] absl::Status Tick();

  /// Ends all waiting Synchronize calls at once and refuses to grant from then on.
  void Stop();

  // The store.
  /// @return kResourceExhausted (STORE_FULL), naming the numbers, if the store has less free space
  ///         than its reserve: nothing new is taken in or begun until it has.
  [[nodiscard]] absl::Status CheckSpace();
  /// @return as garbage.h.
  [[nodiscard]] absl::StatusOr<GarbageCount> CollectGarbage(const GarbageOptions& options,
                                                            const std::stop_token& stop = {});
  [[nodiscard]] const CoordinatorOptions& Options() const { return options_; }
  [[nodiscard]] ManagedBlobStore& Store() { return store_; }

 private:
  /// What was asked for when a job was created.
  struct JobRequest {
    const std::string& set;
    const JobSpec& spec;
    const std::string& request_id;
  };
  /// A worker's call that waits for the lock.
  struct QueuedReport {
    const WorkerReport& report;
    const std::function<bool()>& is_cancelled;
    MonotonicTime arrived;
    WorkerOrders orders;
    absl::Status status;
    bool is_answered = false;
  };
  /// A result that waits for the lock, with those of other calls.
  struct QueuedCompletion {
    const WorkerId& worker;
    const Lease& lease;
    const TaskResult& result;
    QueuedReport* next = nullptr;  ///< Answered too, if that can be done at once.
    std::optional<absl::StatusOr<bool>> outcome = std::nullopt;
  };
  /// What granted tasks change in the catalog.
  struct GrantWrite {
    std::vector<JobTask> tasks;
    std::set<JobId> jobs;
  };

  Coordinator(const CoordinatorOptions& options,
              Catalog& catalog,
              ManagedBlobStore& store,
              const Clock& clock);

  // Jobs.
  absl::Status Recover();
  absl::Status RecoverJob(const Job& job) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Of a job begun by another build: none of its results is under its number in our plan.
  absl::Status StartOver(ActiveJob& active) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Schedules what the plan has made ready; ends the job if nothing is left.
  absl::Status Advance(ActiveJob& active) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Keeps `ready_since_` true. To be called after every grant, and from Tick.
  void NoteReady(MonotonicTime now, int64_t granted) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Counts and logs what the scheduler has taken back from workers.
  void NoteLost() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Looks the next ready tasks up among known results, finishes those and schedules the others.
  absl::Status LookUp(ActiveJob& active) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// The results of tasks as they are remembered, if their blobs are still there.
  absl::StatusOr<std::map<int64_t, TaskResult>> FindKnown(const ActiveJob& active,
                                                          const std::vector<Task>& tasks)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Ingest is known by file, so that a file in any set is read once.
  absl::StatusOr<std::optional<TaskResult>> FindIngested(const Task& task);
  /// The job's end if no task of it can be done any more.
  absl::Status EndIfStuck(ActiveJob& active) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status EndJob(ActiveJob& active, JobState state, const std::string& error)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Results that the plan cannot take yet, because one before them was lost: they are to be found
  /// again by action key, when it is known that the task is the same.
  absl::Status PutBack(ActiveJob& active, const std::vector<TaskRecord>& records)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::StatusOr<Job> SetPaused(const JobId& id, JobState state);
  void ServeJob(const ActiveJob& active) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::StatusOr<JobOutputs> OutputsSoFar(const JobId& id) ABSL_LOCKS_EXCLUDED(mutex_);
  absl::Status CheckLandmarks(const JobSpec& spec);
  absl::StatusOr<std::vector<SetMesh>> AllMeshes(const std::string& set);
  /// With what ingest knows of the meshes.
  absl::StatusOr<JobForecast> ForecastJob(const JobSpec& spec,
                                          const std::vector<SetMesh>& meshes,
                                          const JobOutputs& kept);
  absl::StatusOr<Estimate> EstimateOver(const JobSpec& spec, const std::vector<SetMesh>& meshes);
  /// Whether the store can hold what a new job writes.
  /// @param rough  its forecast, for jobs so small that it need not be right.
  /// @return kResourceExhausted (STORE_TOO_SMALL) with the numbers.
  absl::Status CheckRoom(const JobRequest& request,
                         const std::vector<SetMesh>& meshes,
                         const JobOutputs& kept,
                         const JobForecast& rough);
  /// True if the request has a job already, or its results are there from another.
  absl::StatusOr<bool> WritesNothingNew(const JobRequest& request);
  absl::StatusOr<ReferenceFrame> FrameFor(const JobSpec& spec, const std::vector<SetMesh>& meshes);
  void Touch(ActiveJob& active) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Drops ended jobs and returns what observers are to hear.
  std::vector<Job> TakeChanges() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Notify(const std::vector<Job>& changes);
  [[nodiscard]] int64_t WallMs() const;
  /// The plan's progress; the times of the stages are the job's own.
  static void UpdateProgress(const ActiveJob& active, Job& job);
  /// A task of the stage was handed out or done.
  void NoteStage(const std::string& stage, Job& job) const;

  // Workers.
  /// Answers `besides` and every report in the queue: renews, grants, writes all grants together.
  void AnswerReports(std::span<QueuedReport* const> besides) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void NoteWorker(const WorkerReport& report, MonotonicTime now)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// What the worker's free slots take; for its spare ones only while there is plenty.
  /// @param ending  tasks that are out and whose results are being taken in.
  std::vector<Lease> GrantTasks(const WorkerReport& report, int64_t ending, MonotonicTime now)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Renews what the worker holds, and takes what it says of itself.
  void TakeReport(QueuedReport& queued, MonotonicTime now, std::vector<TaskId>& given_up)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Takes back what was granted to a call that fails.
  void WithdrawGrants(const QueuedReport& queued, MonotonicTime now)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Puts a lease that was granted into the worker's orders.
  void AddGrant(const Lease& lease, QueuedReport& queued, GrantWrite& write)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  [[nodiscard]] std::vector<Job> JobsOf(const GrantWrite& write) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// When the worker is to call again.
  [[nodiscard]] double NextSyncSeconds(const QueuedReport& queued) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::StatusOr<bool> QueueCompletion(QueuedCompletion& queued);
  /// Takes in every result in the queue, as one transaction.
  void TakeCompletions() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Keeps those of `batch` that are to be taken, and answers the others.
  /// @return what the catalog is to write of them, in their order.
  std::vector<Completion> WhatIsWanted(std::vector<QueuedCompletion*>& batch)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Results that have been written, with what GrantWithResults has granted.
  void TakeIn(std::span<QueuedCompletion* const> results, MonotonicTime now)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Grants tasks to those who bring `results`, before these are taken in.
  GrantWrite GrantWithResults(std::span<QueuedCompletion* const> results, MonotonicTime now)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// After results were taken in: answers the workers that brought them, as far as
  /// GrantWithResults has not, and those who wait.
  void AnswerAfter(std::span<QueuedCompletion* const> results)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// The caller no longer waits for the answer.
  [[nodiscard]] static bool HasGone(const QueuedReport& queued, MonotonicTime now);
  /// There is something to tell the worker.
  [[nodiscard]] static bool MustReturn(const QueuedReport& queued);
  /// There is nothing to tell the worker yet, and it may wait here for a task.
  [[nodiscard]] bool MayWait(const QueuedReport& queued) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  [[nodiscard]] bool MayHaveTasks(const QueuedReport& queued) const
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// The rest of the answer to a report that GrantWithResults has granted tasks to.
  void AnswerNext(QueuedReport& queued, MonotonicTime now) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// What the catalog is to write of the result of an open task, but for the job's row.
  /// @return kInvalidArgument if it does not fit the task.
  absl::StatusOr<Completion> CompletionOf(const QueuedCompletion& queued)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// After it is on disk.
  void Apply(const QueuedCompletion& queued) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Records tasks that will not be tried again.
  absl::Status GiveUp(const std::vector<TaskId>& tasks, const std::string& why)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status CheckOutputs(const TaskResult& result);

  // The store; coordinator_damage.cc, coordinator_store.cc.
  /// A worker could not read an input of its task.
  /// @return true: it has been seen to. False: the store has the blob; the task has failed.
  absl::StatusOr<bool> HandleDamagedBlob(const Lease& lease, const Digest& blob);
  /// Puts the job back to where the blob is made; false if none of its tasks makes it.
  absl::StatusOr<bool> MakeAgain(ActiveJob& active, const Digest& blob)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Drops what is in memory of a job and recovers it from the catalog; if that fails, Tick tries
  /// again.
  void TakeUpAgain(const Job& job) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  absl::Status TakeUpStanding() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Of a job that has succeeded; empty if it has lost nothing.
  absl::StatusOr<std::optional<Job>> MakeLostResults(const Job& job) ABSL_LOCKS_EXCLUDED(mutex_);
  /// Takes back what tasks have found out that is in one of these blobs.
  absl::StatusOr<std::vector<JobTask>> ForgetResultsIn(const JobId& id,
                                                       const std::vector<Digest>& lost)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// The job that made a blob of a job's results: itself, or one whose pairs it keeps.
  absl::StatusOr<JobId> MakerOf(const JobId& id, const Digest& blob);
  /// Of a read of results: what people are to know and do if a blob is lost.
  absl::Status ExplainDamage(const JobId& id, const absl::Status& read);
  /// Tells active jobs that they wait for space, or no longer do.
  void NoteSpace(const absl::Status& space) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// A running job's, if the task is one of its current step and not done.
  ActiveJob* FindOpen(const TaskId& task) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const CoordinatorOptions options_;
  Catalog& catalog_;
  ManagedBlobStore& store_;
  const Clock& clock_;
  JobObserver* observer_ = nullptr;

  Mutex mutex_;
  CondVar work_;  ///< Tasks may have become ready, or the server stops.
  Scheduler scheduler_ ABSL_GUARDED_BY(mutex_);
  std::map<JobId, ActiveJob> active_ ABSL_GUARDED_BY(mutex_);
  std::vector<Job> changes_ ABSL_GUARDED_BY(mutex_);
  bool stopping_ ABSL_GUARDED_BY(mutex_) = false;
  std::vector<QueuedReport*> waiting_ ABSL_GUARDED_BY(mutex_);  ///< Calls that wait for `work_`.
  std::string no_space_ ABSL_GUARDED_BY(mutex_);      ///< Why nothing is handed out; empty: it is.
  std::set<JobId> standing_ ABSL_GUARDED_BY(mutex_);  ///< Not final, and not in `active_` either.
  std::map<Digest, int> times_damaged_ ABSL_GUARDED_BY(mutex_);
  std::map<WorkerId, WorkerStatus> workers_ ABSL_GUARDED_BY(mutex_);
  std::map<WorkerId, MonotonicTime> last_seen_ ABSL_GUARDED_BY(mutex_);
  EventTotals totals_ ABSL_GUARDED_BY(mutex_);
  TaskRates rates_ ABSL_GUARDED_BY(mutex_);
  ActionKeys action_keys_ ABSL_GUARDED_BY(mutex_);
  /// Since when tasks have been ready and none was handed out; nothing: none is ready.
  std::optional<MonotonicTime> ready_since_ ABSL_GUARDED_BY(mutex_);
  CallTimer synchronize_timer_;
  CallTimer complete_timer_;

  Mutex queue_mutex_;  ///< Taken after `mutex_`, or alone.
  std::vector<QueuedCompletion*> completions_ ABSL_GUARDED_BY(queue_mutex_);
  std::vector<QueuedReport*> reports_ ABSL_GUARDED_BY(queue_mutex_);
};

}  // namespace cohort
