#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <absl/status/statusor.h>

#include "common/base/call_times.h"
#include "common/jobs/job_state.h"
#include "common/jobs/task.h"

namespace cohort {

class Database;

/// A named set of meshes.
struct MeshSet {
  std::string name;
  int64_t meshes = 0;
  int64_t size_bytes = 0;
};

/// One page of a listing; `next_token` is empty on the last.
template <typename T>
struct Page {
  std::vector<T> items;
  std::string next_token;
};

/// A task as it outlives the server.
struct TaskRecord {
  int64_t number = 0;
  int64_t epoch = 0;
  int failures = 0;
  int losses = 0;
  std::string worker;                ///< Empty: not leased.
  std::optional<TaskResult> result;  ///< Set when done.
  std::string last_error;
  bool given_up = false;  ///< Failed too often; only a retry of its job tries it again.
};

/// A task of some job.
struct JobTask {
  JobId job;
  TaskRecord task;
};

/// A task that is done and what it changes.
struct Completion {
  Job job;
  TaskRecord task;                                        ///< With its result.
  std::vector<std::pair<Digest, IngestedMesh>> ingested;  ///< By digest of the raw file.
  std::string action_key;  ///< Remembers the result under it; empty: not remembered.
};

/// All that the server must not lose, in SQL: a file of SQLite or a database of PostgreSQL. What a
/// call acknowledged survives a crash and, but for SaveGrants, a power failure (SQLite: WAL,
/// synchronous=FULL). Every error names the
/// database and its reason: kResourceExhausted when the disk is full, kDataLoss when it is damaged
/// (each page has a checksum, verified when it is read), else kUnavailable; after that the next
/// call connects again. An error of a call that writes means that nothing was written, except that
/// one during the commit itself may leave all of it written.
/// Texts are UTF-8 without NUL: PostgreSQL keeps no others.
/// Thread-safe: calls take turns.
class Catalog {
 public:
  /// Opens or creates the catalog, brings it to our version and keeps other servers out.
  /// @param location  a file (taken with the lock file beside it), "postgresql://USER@HOST/NAME",
  ///                  or "postgresql:" and libpq's keywords ("postgresql:dbname=NAME host=...").
  /// @return kFailedPrecondition if another server has it, its version is newer than ours, or
  ///         PostgreSQL is not set up to keep it (encoding, checksums, fsync); kDataLoss if it is
  ///         damaged or not ours; kInvalidArgument if the location cannot be understood.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<Catalog>> Open(const std::string& location);
  ~Catalog();
  Catalog(const Catalog&) = delete;
  Catalog& operator=(const Catalog&) = delete;

  /// Adds a mesh, or changes its labels if the same bytes are there under that name.
  /// @return kAlreadyExists if the set has other bytes under that name.
  [[nodiscard]] absl::Status AddMesh(const std::string& set, const SetMesh& mesh);
  /// Sets by name. @param page_size >= 1; `token` as returned, or empty.
  [[nodiscard]] absl::StatusOr<Page<MeshSet>> ListSets(int page_size, const std::string& token);
  /// Meshes by name, bytewise. @return kNotFound naming the set.
  [[nodiscard]] absl::StatusOr<Page<SetMesh>> ListMeshes(const std::string& set,
                                                         int page_size,
                                                         const std::string& token);

  /// What ingest made of raw files, by digest and quantisation (indices are not set).
  [[nodiscard]] absl::StatusOr<std::optional<IngestedMesh>> FindIngested(const Digest& raw,
                                                                         int position_bits);
  [[nodiscard]] absl::Status RecordIngested(const Digest& raw,
                                            int position_bits,
                                            const IngestedMesh& mesh);

  /// Creates a job over a snapshot of `meshes`, in that order; fills in id and times of `job`.
  /// A job of the same non-empty `request_id` exists: returns that one instead.
  /// @param now_unix_ms  creation time.
  /// @param kept  what it keeps of a reference job: its outputs until it has its own.
  [[nodiscard]] absl::StatusOr<Job> CreateJob(const Job& job,
                                              const std::vector<SetMesh>& meshes,
                                              const std::string& request_id,
                                              int64_t now_unix_ms,
                                              const JobOutputs& kept = {});
  /// The job that was created with a non-empty request id, if there is one.
  [[nodiscard]] absl::StatusOr<std::optional<Job>> FindJobOfRequest(const std::string& request_id);
  /// Writes everything of the job that can change (state, error, version, times, progress,
  /// counters, rejected count).
  [[nodiscard]] absl::Status UpdateJob(const Job& job);
  /// UpdateJob with the versions too, of a job whose tasks have other numbers or results from now
  /// on: forgets what became of its tasks, all but their epochs, so that no earlier lease is taken
  /// for a new one.
  [[nodiscard]] absl::Status StartOver(const Job& job);
  /// With `outputs` and the fate of each mesh, once a job has ended.
  [[nodiscard]] absl::Status FinishJob(const Job& job,
                                       const JobOutputs& outputs,
                                       const std::vector<JobMesh>& meshes);
  /// @return kNotFound naming the job.
  [[nodiscard]] absl::StatusOr<Job> GetJob(const JobId& id);
  [[nodiscard]] absl::StatusOr<JobOutputs> GetOutputs(const JobId& id);
  /// In the job's order. @return kNotFound naming the job.
  [[nodiscard]] absl::StatusOr<std::vector<JobMesh>> GetJobMeshes(const JobId& id);
  /// Newest first.
  [[nodiscard]] absl::StatusOr<Page<Job>> ListJobs(int page_size, const std::string& token);
  /// Jobs not in a final state, oldest first: what a restarted server goes on with.
  [[nodiscard]] absl::StatusOr<std::vector<Job>> UnfinishedJobs();

  /// Writes what became of tasks, and the rows of jobs that they change, all or none.
  [[nodiscard]] absl::Status SaveTasks(std::span<const JobTask> tasks, std::span<const Job> jobs);
  /// SaveTasks of leases. A crash of the server forgets none, but a power failure may forget those
  /// after the last call of another kind: such a task is granted again, and no result is lost.
  [[nodiscard]] absl::Status SaveGrants(std::span<const JobTask> tasks, std::span<const Job> jobs);
  /// Hands out the tasks of a job by number, one at a time: a million of them need no memory.
  /// @param visit  called under the catalog's lock: no calls back; its error ends the walk and is
  ///               returned.
  [[nodiscard]] absl::Status VisitTasks(
      const JobId& job, const std::function<absl::Status(const TaskRecord&)>& visit);
  /// Tasks done, of any jobs: one transaction for all (group commit), so all are durable or none
  /// is. Of several completions of one job, the last tells the job's row; a result replaces what
  /// was remembered under its action key.
  /// @param now_unix_ms  when the results were made, for ForgetActions.
  /// @param grants, jobs  as SaveGrants, of other tasks and other jobs; in the same transaction.
  /// @return kNotFound naming the job that is missing.
  [[nodiscard]] absl::Status SaveCompletions(std::span<const Completion> completions,
                                             int64_t now_unix_ms,
                                             std::span<const JobTask> grants = {},
                                             std::span<const Job> jobs = {});
  static constexpr int64_t kAnyTime = -1;
  /// Results remembered under any of `keys`; keys that are not known are left out.
  /// @param created_after_unix_ms  only results made later than that.
  [[nodiscard]] absl::StatusOr<std::map<std::string, TaskResult>> FindActions(
      const std::vector<std::string>& keys, int64_t created_after_unix_ms = kAnyTime);

  /// Removes a job with its meshes and tasks; what others share (ingested meshes, remembered
  /// results) stays. Its id is never given out again.
  /// @return kNotFound naming the job; kFailedPrecondition, reason JOB_NOT_FINISHED.
  [[nodiscard]] absl::Status DeleteJob(const JobId& id);
  /// Removes a mesh from a set; jobs keep their snapshots. A set without meshes is no more.
  /// @return kNotFound naming the set or the mesh.
  [[nodiscard]] absl::Status RemoveMesh(const std::string& set, const std::string& name);
  /// @return kNotFound naming the set.
  [[nodiscard]] absl::Status DeleteSet(const std::string& set);
  /// Forgets results remembered before that time. @return how many.
  [[nodiscard]] absl::StatusOr<int64_t> ForgetActions(int64_t created_before_unix_ms);
  /// Forgets what ingest made of files that no set and no job has any more. @return how many.
  [[nodiscard]] absl::StatusOr<int64_t> ForgetUnusedIngested();

  /// Tells each blob that any row refers to: what a garbage collector must leave alone. A blob may
  /// be told several times. Goes page by page, in bounded memory, while other calls go on: a row
  /// that comes meanwhile may be missed, so the collector must leave young blobs alone, too.
  /// @param visit  called without any lock held; its error ends the walk and is returned.
  [[nodiscard]] absl::Status VisitBlobs(const std::function<absl::Status(const Digest&)>& visit);

  /// How long the transactions of calls that write took, since it was opened.
  [[nodiscard]] CallTimes WriteTimes() const;

 private:
  explicit Catalog(std::unique_ptr<Database> database);
  std::unique_ptr<Database> database_;
};

}  // namespace cohort
