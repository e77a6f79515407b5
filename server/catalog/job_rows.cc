#include "server/catalog/job_rows.h"

#include <utility>

#include <absl/strings/numbers.h>

#include "common/base/status_macros.h"
#include "server/catalog/row_json.h"

namespace cohort {
namespace {

constexpr size_t kNumberDigits = 6;

/// Columns that are not fields of Job as they are.
struct JobRow {
  int64_t number = 0;
  std::string spec;
  std::string state;
  std::string progress;
  std::string counters;
  Job job;
};

absl::StatusOr<Job> ToJob(JobRow row) {
  row.job.id = JobIdOf(row.number);
  const std::optional<JobState> state = JobStateFromName(row.state);
  if (!state.has_value()) {
    return absl::DataLossError("job " + row.job.id.value + ": unknown state '" + row.state + "'");
  }
  row.job.state = *state;
  COHORT_ASSIGN_OR_RETURN(row.job.spec, SpecFromText(row.spec));
  COHORT_ASSIGN_OR_RETURN(row.job.progress, ProgressFromText(row.progress));
  COHORT_ASSIGN_OR_RETURN(row.job.counters, CountersFromText(row.counters));
  return std::move(row.job);
}

class JobUpdater {
 public:
  explicit JobUpdater(soci::session& sql)
      : update_((sql.prepare << "UPDATE job SET state = :state, error = :error, "
                                "version = :version, started_unix_ms = :started, "
                                "finished_unix_ms = :finished, rejected_meshes = :rejected, "
                                "progress = :progress, counters = :counters "
                                "WHERE number = :number",
                 soci::use(row_.state),
                 soci::use(row_.job.error),
                 soci::use(row_.job.version),
                 soci::use(row_.job.started_unix_ms),
                 soci::use(row_.job.finished_unix_ms),
                 soci::use(row_.job.rejected_meshes),
                 soci::use(row_.progress),
                 soci::use(row_.counters),
                 soci::use(row_.number))) {}

  /// @return whether there is such a job.
  [[nodiscard]] bool Update(int64_t number, const Job& job) {
    row_.number = number;
    row_.state = JobStateName(job.state);
    row_.progress = ProgressToText(job.progress);
    row_.counters = CountersToText(job.counters);
    row_.job.error = job.error;
    row_.job.version = job.version;
    row_.job.started_unix_ms = job.started_unix_ms;
    row_.job.finished_unix_ms = job.finished_unix_ms;
    row_.job.rejected_meshes = job.rejected_meshes;
    update_.execute(true);
    return update_.get_affected_rows() == 1;
  }

 private:
  JobRow row_;  ///< Only what is written.
  soci::statement update_;
};

class JobFinder {
 public:
  explicit JobFinder(soci::session& sql)
      : select_((sql.prepare << "SELECT number FROM job WHERE number = :number",
                 soci::use(number_),
                 soci::into(found_))) {}

  [[nodiscard]] bool Contains(int64_t number) {
    number_ = number;
    select_.execute();
    const bool contains = select_.fetch();
    while (select_.fetch()) {  // To its end: see CatalogSession::Kept.
    }
    return contains;
  }

 private:
  int64_t number_ = 0;
  int64_t found_ = 0;
  soci::statement select_;
};

}  // namespace

JobId JobIdOf(int64_t number) {
  std::string digits = std::to_string(number);
  if (digits.size() < kNumberDigits) {
    digits.insert(0, kNumberDigits - digits.size(), '0');
  }
  return JobId{"j-" + digits};
}

absl::StatusOr<int64_t> NumberOf(const JobId& id) {
  int64_t number = 0;
  const bool is_number =
      id.value.starts_with("j-") && absl::SimpleAtoi(id.value.substr(2), &number) && number > 0;
  // One spelling per job: "j-12" is not "j-000012".
  if (!is_number || JobIdOf(number) != id) {
    return NoSuchJob(id);
  }
  return number;
}

absl::Status NoSuchJob(const JobId& id) {
  return absl::NotFoundError("there is no job '" + id.value.substr(0, 80) + "'");
}

absl::StatusOr<std::vector<Job>> SelectJobs(soci::session& sql,
                                            const std::string& rest,
                                            const std::function<void(soci::statement&)>& bind) {
  JobRow row;
  soci::statement select(sql);
  select.alloc();
  select.prepare(
      "SELECT number, set_name, spec, state, error, version, created_unix_ms, started_unix_ms, "
      "finished_unix_ms, meshes, rejected_meshes, progress, counters, plan_version, "
      "results_version FROM job " +
      rest);
  select.exchange(soci::into(row.number));
  select.exchange(soci::into(row.job.set));
  select.exchange(soci::into(row.spec));
  select.exchange(soci::into(row.state));
  select.exchange(soci::into(row.job.error));
  select.exchange(soci::into(row.job.version));
  select.exchange(soci::into(row.job.created_unix_ms));
  select.exchange(soci::into(row.job.started_unix_ms));
  select.exchange(soci::into(row.job.finished_unix_ms));
  select.exchange(soci::into(row.job.meshes));
  select.exchange(soci::into(row.job.rejected_meshes));
  select.exchange(soci::into(row.progress));
  select.exchange(soci::into(row.counters));
  select.exchange(soci::into(row.job.plan_version));
  select.exchange(soci::into(row.job.results_version));
  bind(select);
  select.define_and_bind();
  select.execute();
  std::vector<Job> jobs;
  while (select.fetch()) {
    COHORT_ASSIGN_OR_RETURN(Job job, ToJob(row));
    jobs.push_back(std::move(job));
  }
  return jobs;
}

absl::StatusOr<Job> SelectJob(soci::session& sql, const JobId& id) {
  COHORT_ASSIGN_OR_RETURN(const int64_t number, NumberOf(id));
  COHORT_ASSIGN_OR_RETURN(std::vector<Job> jobs,
                          SelectJobs(sql, "WHERE number = :number", [&](soci::statement& select) {
                            select.exchange(soci::use(number));
                          }));
  if (jobs.empty()) {
    return NoSuchJob(id);
  }
  return std::move(jobs[0]);
}

absl::Status InsertJob(soci::session& sql,
                       const Job& job,
                       const std::string& request_id,
                       const JobOutputs& outputs_kept) {
  COHORT_ASSIGN_OR_RETURN(const int64_t number, NumberOf(job.id));
  const std::string spec = SpecToText(job.spec);
  const std::string state(JobStateName(job.state));
  const std::string progress = ProgressToText(job.progress);
  const std::string counters = CountersToText(job.counters);
  const std::string outputs = OutputsToText(outputs_kept);
  sql << "INSERT INTO job (number, request_id, set_name, spec, state, error, version, "
         "created_unix_ms, started_unix_ms, finished_unix_ms, meshes, rejected_meshes, progress, "
         "counters, outputs, plan_version, results_version) VALUES (:number, :request_id, "
         ":set_name, :spec, :state, :error, :version, :created, :started, :finished, :meshes, "
         ":rejected, :progress, :counters, :outputs, :plan_version, :results_version)",
      soci::use(number), soci::use(request_id), soci::use(job.set), soci::use(spec),
      soci::use(state), soci::use(job.error), soci::use(job.version),
      soci::use(job.created_unix_ms), soci::use(job.started_unix_ms),
      soci::use(job.finished_unix_ms), soci::use(job.meshes), soci::use(job.rejected_meshes),
      soci::use(progress), soci::use(counters), soci::use(outputs), soci::use(job.plan_version),
      soci::use(job.results_version);
  return absl::OkStatus();
}

absl::Status UpdateJobRow(CatalogSession& sql, const Job& job) {
  COHORT_ASSIGN_OR_RETURN(const int64_t number, NumberOf(job.id));
  const bool is_there = sql.Kept<JobUpdater>().Update(number, job);
  return is_there ? absl::OkStatus() : NoSuchJob(job.id);
}

absl::StatusOr<int64_t> RequireJob(CatalogSession& sql, const JobId& id) {
  COHORT_ASSIGN_OR_RETURN(const int64_t number, NumberOf(id));
  if (!sql.Kept<JobFinder>().Contains(number)) {
    return NoSuchJob(id);
  }
  return number;
}

}  // namespace cohort
