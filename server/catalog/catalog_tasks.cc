// Tasks, what they tell, and what is remembered of them.

#include <algorithm>
#include <optional>
#include <utility>

#include "common/base/status_macros.h"
#include "server/catalog/catalog.h"
#include "server/catalog/database.h"
#include "server/catalog/ingested_rows.h"
#include "server/catalog/job_rows.h"
#include "server/catalog/row_json.h"

namespace cohort {
namespace {

constexpr size_t kKeysPerQuery = 500;
constexpr int64_t kTasksPerPage = 1000;

class TaskWriter {
 public:
  explicit TaskWriter(soci::session& sql)
      : upsert_((sql.prepare << "INSERT INTO task (job, number, epoch, failures, losses, worker, "
                                "result, last_error, given_up) VALUES (:job, :number, :epoch, "
                                ":failures, :losses, :worker, :result, :last_error, :given_up) "
                                "ON CONFLICT (job, number) DO UPDATE SET epoch = excluded.epoch, "
                                "failures = excluded.failures, losses = excluded.losses, "
                                "worker = excluded.worker, result = excluded.result, "
                                "last_error = excluded.last_error, "
                                "given_up = excluded.given_up",
                 soci::use(job_),
                 soci::use(task_.number),
                 soci::use(task_.epoch),
                 soci::use(task_.failures),
                 soci::use(task_.losses),
                 soci::use(task_.worker),
                 soci::use(result_),
                 soci::use(task_.last_error),
                 soci::use(given_up_))) {}

  void Write(int64_t job, const TaskRecord& task, const std::string& result) {
    job_ = job;
    task_.number = task.number;
    task_.epoch = task.epoch;
    task_.failures = task.failures;
    task_.losses = task.losses;
    task_.worker = task.worker;
    result_ = result;
    task_.last_error = task.last_error;
    given_up_ = task.given_up ? 1 : 0;
    upsert_.execute(true);
  }

 private:
  int64_t job_ = 0;
  TaskRecord task_;  ///< Without its result.
  std::string result_;
  int64_t given_up_ = 0;
  soci::statement upsert_;
};

class ActionWriter {
 public:
  explicit ActionWriter(soci::session& sql)
      : upsert_((sql.prepare << "INSERT INTO action (action_key, result, created_unix_ms) "
                                "VALUES (:action_key, :result, :now) "
                                "ON CONFLICT (action_key) DO UPDATE SET result = excluded.result, "
                                "created_unix_ms = excluded.created_unix_ms",
                 soci::use(key_),
                 soci::use(result_),
                 soci::use(now_unix_ms_))) {}

  void Write(const std::string& key, const std::string& result, int64_t now_unix_ms) {
    key_ = key;
    result_ = result;
    now_unix_ms_ = now_unix_ms;
    upsert_.execute(true);
  }

 private:
  std::string key_;
  std::string result_;
  int64_t now_unix_ms_ = 0;
  soci::statement upsert_;
};

/// The next tasks after number `after`, a page of them. @return how many there were.
absl::StatusOr<int64_t> SelectPage(soci::session& sql,
                                   int64_t job,
                                   int64_t after,
                                   const std::function<absl::Status(const TaskRecord&)>& visit) {
  TaskRecord task;
  std::string result;
  int64_t given_up = 0;
  soci::statement select =
      (sql.prepare << "SELECT number, epoch, failures, losses, worker, result, last_error, "
                      "given_up FROM task WHERE job = :job AND number > :after ORDER BY number "
                      "LIMIT :limit",
       soci::use(job), soci::use(after), soci::use(kTasksPerPage), soci::into(task.number),
       soci::into(task.epoch), soci::into(task.failures), soci::into(task.losses),
       soci::into(task.worker), soci::into(result), soci::into(task.last_error),
       soci::into(given_up));
  select.execute();
  int64_t rows = 0;
  while (select.fetch()) {
    ++rows;
    task.result.reset();
    if (!result.empty()) {
      COHORT_ASSIGN_OR_RETURN(task.result, ResultFromText(result));
    }
    task.given_up = given_up != 0;
    COHORT_RETURN_IF_ERROR(visit(task));
  }
  return rows;
}

/// Page by page: libpq has all rows of a query in memory before it gives the first.
absl::Status SelectTasks(soci::session& sql,
                         int64_t job,
                         const std::function<absl::Status(const TaskRecord&)>& visit) {
  int64_t last = -1;
  int64_t rows = kTasksPerPage;
  while (rows == kTasksPerPage) {
    COHORT_ASSIGN_OR_RETURN(rows, SelectPage(sql, job, last, [&](const TaskRecord& task) {
                              last = task.number;
                              return visit(task);
                            }));
  }
  return absl::OkStatus();
}

absl::Status SelectActions(soci::session& sql,
                           std::span<const std::string> keys,
                           int64_t created_after_unix_ms,
                           std::map<std::string, TaskResult>& found) {
  std::string list;
  for (size_t i = 0; i < keys.size(); ++i) {
    list += (i == 0 ? ":k" : ", :k") + std::to_string(i);
  }
  std::string key;
  std::string result;
  soci::statement select(sql);
  select.alloc();
  select.prepare("SELECT action_key, result FROM action WHERE action_key IN (" + list +
                 ") AND created_unix_ms > :after");
  select.exchange(soci::into(key));
  select.exchange(soci::into(result));
  for (const std::string& wanted : keys) {
    select.exchange(soci::use(wanted));
  }
  select.exchange(soci::use(created_after_unix_ms));
  select.define_and_bind();
  select.execute();
  while (select.fetch()) {
    COHORT_ASSIGN_OR_RETURN(found[key], ResultFromText(result));
  }
  return absl::OkStatus();
}

absl::Status UpsertTasks(CatalogSession& sql,
                         std::span<const JobTask> tasks,
                         std::span<const Job> jobs) {
  for (const Job& job : jobs) {
    COHORT_RETURN_IF_ERROR(UpdateJobRow(sql, job));
  }
  auto& writer = sql.Kept<TaskWriter>();
  std::map<std::string, int64_t> numbers;  // Of the jobs that are there.
  for (const JobTask& task : tasks) {
    const auto [number, is_new] = numbers.try_emplace(task.job.value);
    if (is_new) {
      COHORT_ASSIGN_OR_RETURN(number->second, RequireJob(sql, task.job));
    }
    const std::optional<TaskResult>& result = task.task.result;
    writer.Write(number->second, task.task, result ? ResultToText(*result) : std::string());
  }
  return absl::OkStatus();
}

absl::Status InsertCompletions(CatalogSession& sql,
                               std::span<const Completion> completions,
                               int64_t now_unix_ms) {
  std::map<std::string, const Job*> jobs;
  for (const Completion& completion : completions) {
    jobs[completion.job.id.value] = &completion.job;  // The last one of each.
  }
  for (const auto& [id, job] : jobs) {
    COHORT_RETURN_IF_ERROR(UpdateJobRow(sql, *job));
  }
  auto& tasks = sql.Kept<TaskWriter>();
  auto& ingested = sql.Kept<IngestedWriter>();
  auto& actions = sql.Kept<ActionWriter>();
  for (const Completion& completion : completions) {
    COHORT_ASSIGN_OR_RETURN(const int64_t job, NumberOf(completion.job.id));
    const std::optional<TaskResult>& result = completion.task.result;
    const std::string text = result ? ResultToText(*result) : std::string();
    tasks.Write(job, completion.task, text);
    for (const auto& [raw, mesh] : completion.ingested) {
      ingested.Write(raw, completion.job.spec.position_bits, mesh);
    }
    if (!completion.action_key.empty() && result) {
      actions.Write(completion.action_key, text, now_unix_ms);
    }
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status Catalog::SaveTasks(std::span<const JobTask> tasks, std::span<const Job> jobs) {
  return database_->Write([&](CatalogSession& sql) { return UpsertTasks(sql, tasks, jobs); });
}

absl::Status Catalog::SaveGrants(std::span<const JobTask> tasks, std::span<const Job> jobs) {
  return database_->Write([&](CatalogSession& sql) { return UpsertTasks(sql, tasks, jobs); },
                          CommitSync::kLater);
}

absl::Status Catalog::VisitTasks(const JobId& job,
                                 const std::function<absl::Status(const TaskRecord&)>& visit) {
  return database_->Read([&](CatalogSession& sql) -> absl::Status {
    COHORT_ASSIGN_OR_RETURN(const int64_t number, RequireJob(sql, job));
    return SelectTasks(sql, number, visit);
  });
}

absl::Status Catalog::SaveCompletions(std::span<const Completion> completions,
                                      int64_t now_unix_ms,
                                      std::span<const JobTask> grants,
                                      std::span<const Job> jobs) {
  return database_->Write([&](CatalogSession& sql) {
    COHORT_RETURN_IF_ERROR(InsertCompletions(sql, completions, now_unix_ms));
    return UpsertTasks(sql, grants, jobs);
  });
}

absl::StatusOr<std::map<std::string, TaskResult>> Catalog::FindActions(
    const std::vector<std::string>& keys, int64_t created_after_unix_ms) {
  std::map<std::string, TaskResult> found;
  for (size_t begin = 0; begin < keys.size(); begin += kKeysPerQuery) {
    const size_t count = std::min(kKeysPerQuery, keys.size() - begin);
    COHORT_RETURN_IF_ERROR(database_->Read([&](soci::session& sql) {
      return SelectActions(sql, std::span(keys).subspan(begin, count), created_after_unix_ms,
                           found);
    }));
  }
  return found;
}

}  // namespace cohort
