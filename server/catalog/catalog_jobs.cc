// Jobs and their meshes.

#include <limits>
#include <utility>

#include "common/base/status_macros.h"
#include "server/catalog/catalog.h"
#include "server/catalog/database.h"
#include "server/catalog/job_rows.h"
#include "server/catalog/page_token.h"
#include "server/catalog/row_json.h"

namespace cohort {
namespace {

int64_t NextJobNumber(soci::session& sql) {
  sql << "INSERT INTO counter (name, value) VALUES ('job', 1) "
         "ON CONFLICT (name) DO UPDATE SET value = counter.value + 1";
  int64_t number = 0;
  sql << "SELECT value FROM counter WHERE name = 'job'", soci::into(number);
  return number;
}

void InsertJobMeshes(soci::session& sql, int64_t job, const std::vector<SetMesh>& meshes) {
  int64_t index = 0;
  SetMesh mesh;
  std::string raw;
  std::string labels;
  soci::statement insert =
      (sql.prepare << "INSERT INTO job_mesh (job, idx, name, raw, size_bytes, labels, ingested, "
                      "rejection) VALUES (:job, :idx, :name, :raw, :size_bytes, :labels, '', '')",
       soci::use(job), soci::use(index), soci::use(mesh.name), soci::use(raw),
       soci::use(mesh.size_bytes), soci::use(labels));
  for (const SetMesh& next : meshes) {
    mesh = next;
    raw = mesh.raw.Hex();
    labels = LabelsToText(mesh.labels);
    insert.execute(true);
    ++index;
  }
}

absl::Status UpdateJobMeshes(soci::session& sql,
                             const JobId& id,
                             int64_t job,
                             const std::vector<JobMesh>& meshes) {
  int64_t index = 0;
  std::string ingested;
  std::string rejection;
  soci::statement update =
      (sql.prepare << "UPDATE job_mesh SET ingested = :ingested, rejection = :rejection "
                      "WHERE job = :job AND idx = :idx",
       soci::use(ingested), soci::use(rejection), soci::use(job), soci::use(index));
  for (const JobMesh& mesh : meshes) {
    ingested = OutcomeToText(mesh);
    rejection = mesh.rejection;
    update.execute(true);
    if (update.get_affected_rows() != 1) {
      return absl::InvalidArgumentError("job " + id.value + " has no mesh " +
                                        std::to_string(index));
    }
    ++index;
  }
  return absl::OkStatus();
}

absl::StatusOr<std::vector<JobMesh>> SelectJobMeshes(soci::session& sql, int64_t job) {
  JobMesh mesh;
  std::string raw;
  std::string labels;
  std::string ingested;
  soci::statement select =
      (sql.prepare << "SELECT name, raw, size_bytes, labels, ingested, rejection FROM job_mesh "
                      "WHERE job = :job ORDER BY idx",
       soci::use(job), soci::into(mesh.mesh.name), soci::into(raw),
       soci::into(mesh.mesh.size_bytes), soci::into(labels), soci::into(ingested),
       soci::into(mesh.rejection));
  select.execute();
  std::vector<JobMesh> meshes;
  while (select.fetch()) {
    COHORT_ASSIGN_OR_RETURN(mesh.mesh.raw, DigestFromText(raw));
    COHORT_ASSIGN_OR_RETURN(mesh.mesh.labels, LabelsFromText(labels));
    COHORT_RETURN_IF_ERROR(OutcomeFromText(ingested, static_cast<int32_t>(meshes.size()), mesh));
    meshes.push_back(mesh);
  }
  return meshes;
}

}  // namespace

absl::StatusOr<Job> Catalog::CreateJob(const Job& job,
                                       const std::vector<SetMesh>& meshes,
                                       const std::string& request_id,
                                       int64_t now_unix_ms,
                                       const JobOutputs& kept) {
  Job created = job;
  const absl::Status status = database_->Write([&](soci::session& sql) -> absl::Status {
    COHORT_ASSIGN_OR_RETURN(
        std::vector<Job> existing,
        SelectJobs(sql, "WHERE request_id = :request_id AND request_id <> ''",
                   [&](soci::statement& select) { select.exchange(soci::use(request_id)); }));
    if (!existing.empty()) {
      created = std::move(existing[0]);
      return absl::OkStatus();
    }
    const int64_t number = NextJobNumber(sql);
    created.id = JobIdOf(number);
    created.created_unix_ms = now_unix_ms;
    created.meshes = static_cast<int64_t>(meshes.size());
    COHORT_RETURN_IF_ERROR(InsertJob(sql, created, request_id, kept));
    InsertJobMeshes(sql, number, meshes);
    return absl::OkStatus();
  });
  COHORT_RETURN_IF_ERROR(status);
  return created;
}

absl::StatusOr<std::optional<Job>> Catalog::FindJobOfRequest(const std::string& request_id) {
  return database_->ReadValue<std::optional<Job>>(
      [&](soci::session& sql) -> absl::StatusOr<std::optional<Job>> {
        COHORT_ASSIGN_OR_RETURN(
            std::vector<Job> existing,
            SelectJobs(sql, "WHERE request_id = :request_id AND request_id <> ''",
                       [&](soci::statement& select) { select.exchange(soci::use(request_id)); }));
        return existing.empty() ? std::nullopt : std::optional<Job>(std::move(existing[0]));
      });
}

absl::Status Catalog::UpdateJob(const Job& job) {
  return database_->Write([&](CatalogSession& sql) { return UpdateJobRow(sql, job); });
}

absl::Status Catalog::StartOver(const Job& job) {
  return database_->Write([&](CatalogSession& sql) -> absl::Status {
    COHORT_RETURN_IF_ERROR(UpdateJobRow(sql, job));
    COHORT_ASSIGN_OR_RETURN(const int64_t number, NumberOf(job.id));
    sql << "UPDATE job SET plan_version = :plan, results_version = :results WHERE number = :number",
        soci::use(job.plan_version), soci::use(job.results_version), soci::use(number);
    sql << "UPDATE task SET failures = 0, losses = 0, worker = '', result = '', last_error = '', "
           "given_up = 0 WHERE job = :job",
        soci::use(number);
    return absl::OkStatus();
  });
}

absl::Status Catalog::FinishJob(const Job& job,
                                const JobOutputs& outputs,
                                const std::vector<JobMesh>& meshes) {
  return database_->Write([&](CatalogSession& sql) -> absl::Status {
    COHORT_RETURN_IF_ERROR(UpdateJobRow(sql, job));
    COHORT_ASSIGN_OR_RETURN(const int64_t number, NumberOf(job.id));
    const std::string text = OutputsToText(outputs);
    sql << "UPDATE job SET outputs = :outputs WHERE number = :number", soci::use(text),
        soci::use(number);
    return UpdateJobMeshes(sql, job.id, number, meshes);
  });
}

absl::StatusOr<Job> Catalog::GetJob(const JobId& id) {
  return database_->ReadValue<Job>([&](soci::session& sql) { return SelectJob(sql, id); });
}

absl::StatusOr<JobOutputs> Catalog::GetOutputs(const JobId& id) {
  COHORT_ASSIGN_OR_RETURN(const int64_t number, NumberOf(id));
  return database_->ReadValue<JobOutputs>([&](soci::session& sql) -> absl::StatusOr<JobOutputs> {
    std::string text;
    sql << "SELECT outputs FROM job WHERE number = :number", soci::use(number), soci::into(text);
    if (!sql.got_data()) {
      return NoSuchJob(id);
    }
    return OutputsFromText(text);
  });
}

absl::StatusOr<std::vector<JobMesh>> Catalog::GetJobMeshes(const JobId& id) {
  return database_->ReadValue<std::vector<JobMesh>>(
      [&](CatalogSession& sql) -> absl::StatusOr<std::vector<JobMesh>> {
        COHORT_ASSIGN_OR_RETURN(const int64_t number, RequireJob(sql, id));
        return SelectJobMeshes(sql, number);
      });
}

absl::StatusOr<Page<Job>> Catalog::ListJobs(int page_size, const std::string& token) {
  COHORT_RETURN_IF_ERROR(CheckPageSize(page_size));
  COHORT_ASSIGN_OR_RETURN(const std::string key, ReadPageToken(Listing::kJobs, token));
  int64_t before = std::numeric_limits<int64_t>::max();
  if (!key.empty()) {
    const absl::StatusOr<int64_t> number = NumberOf(JobId{key});
    if (!number.ok()) {
      return absl::InvalidArgumentError("page token of jobs: there cannot be a job '" + key + "'");
    }
    before = *number;
  }
  const int64_t limit = int64_t{page_size} + 1;
  Page<Job> page;
  COHORT_ASSIGN_OR_RETURN(
      page.items, database_->ReadValue<std::vector<Job>>([&](soci::session& sql) {
        return SelectJobs(sql, "WHERE number < :before ORDER BY number DESC LIMIT :limit",
                          [&](soci::statement& select) {
                            select.exchange(soci::use(before));
                            select.exchange(soci::use(limit));
                          });
      }));
  if (page.items.size() > static_cast<size_t>(page_size)) {
    page.items.pop_back();
    page.next_token = MakePageToken(Listing::kJobs, page.items.back().id.value);
  }
  return page;
}

absl::StatusOr<std::vector<Job>> Catalog::UnfinishedJobs() {
  const std::string queued(JobStateName(JobState::kQueued));
  const std::string running(JobStateName(JobState::kRunning));
  const std::string paused(JobStateName(JobState::kPaused));
  return database_->ReadValue<std::vector<Job>>([&](soci::session& sql) {
    return SelectJobs(sql, "WHERE state IN (:queued, :running, :paused) ORDER BY number",
                      [&](soci::statement& select) {
                        select.exchange(soci::use(queued));
                        select.exchange(soci::use(running));
                        select.exchange(soci::use(paused));
                      });
  });
}

}  // namespace cohort
