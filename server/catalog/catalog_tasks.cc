// Tasks and what they tell.

#include <utility>

#include "common/base/status_macros.h"
#include "server/catalog/catalog.h"
#include "server/catalog/database.h"
#include "server/catalog/ingested_rows.h"
#include "server/catalog/job_rows.h"
#include "server/catalog/row_json.h"

namespace cohort {
namespace {

void UpsertTasks(soci::session& sql, int64_t job, const std::vector<TaskRecord>& tasks) {
  TaskRecord task;
  std::string result;
  soci::statement upsert =
      (sql.prepare << "INSERT INTO task (job, number, epoch, failures, losses, worker, result, "
                      "last_error) VALUES (:job, :number, :epoch, :failures, :losses, :worker, "
                      ":result, :last_error) "
                      "ON CONFLICT (job, number) DO UPDATE SET epoch = excluded.epoch, "
                      "failures = excluded.failures, losses = excluded.losses, "
                      "worker = excluded.worker, result = excluded.result, "
                      "last_error = excluded.last_error",
       soci::use(job), soci::use(task.number), soci::use(task.epoch), soci::use(task.failures),
       soci::use(task.losses), soci::use(task.worker), soci::use(result),
       soci::use(task.last_error));
  for (const TaskRecord& record : tasks) {
    task = record;
    result = record.result.has_value() ? ResultToText(*record.result) : std::string();
    upsert.execute(true);
  }
}

absl::StatusOr<std::vector<TaskRecord>> SelectTasks(soci::session& sql, int64_t job) {
  TaskRecord task;
  std::string result;
  soci::statement select =
      (sql.prepare << "SELECT number, epoch, failures, losses, worker, result, last_error "
                      "FROM task WHERE job = :job ORDER BY number",
       soci::use(job), soci::into(task.number), soci::into(task.epoch), soci::into(task.failures),
       soci::into(task.losses), soci::into(task.worker), soci::into(result),
       soci::into(task.last_error));
  select.execute();
  std::vector<TaskRecord> tasks;
  while (select.fetch()) {
    task.result.reset();
    if (!result.empty()) {
      COHORT_ASSIGN_OR_RETURN(task.result, ResultFromText(result));
    }
    tasks.push_back(task);
  }
  return tasks;
}

}  // namespace

absl::Status Catalog::SaveTasks(const JobId& job, const std::vector<TaskRecord>& tasks) {
  return database_->Write([&](soci::session& sql) -> absl::Status {
    COHORT_ASSIGN_OR_RETURN(const int64_t number, RequireJob(sql, job));
    UpsertTasks(sql, number, tasks);
    return absl::OkStatus();
  });
}

absl::StatusOr<std::vector<TaskRecord>> Catalog::LoadTasks(const JobId& job) {
  return database_->ReadValue<std::vector<TaskRecord>>(
      [&](soci::session& sql) -> absl::StatusOr<std::vector<TaskRecord>> {
        COHORT_ASSIGN_OR_RETURN(const int64_t number, RequireJob(sql, job));
        return SelectTasks(sql, number);
      });
}

absl::Status Catalog::SaveCompletion(const Job& job,
                                     const TaskRecord& task,
                                     const std::vector<std::pair<Digest, IngestedMesh>>& ingested) {
  return database_->Write([&](soci::session& sql) -> absl::Status {
    COHORT_RETURN_IF_ERROR(UpdateJobRow(sql, job));
    COHORT_ASSIGN_OR_RETURN(const int64_t number, NumberOf(job.id));
    UpsertTasks(sql, number, {task});
    UpsertIngested(sql, job.spec.position_bits, ingested);
    return absl::OkStatus();
  });
}

}  // namespace cohort
