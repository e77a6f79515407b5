// What is taken out of the catalog.

#include "common/base/error_reason.h"
#include "common/base/status_macros.h"
#include "server/catalog/catalog.h"
#include "server/catalog/database.h"
#include "server/catalog/job_rows.h"

namespace cohort {

absl::Status Catalog::DeleteJob(const JobId& id) {
  return database_->Write([&](soci::session& sql) -> absl::Status {
    COHORT_ASSIGN_OR_RETURN(const Job job, SelectJob(sql, id));
    if (!IsFinal(job.state)) {
      return WithReason(absl::FailedPreconditionError("job " + id.value + " is " +
                                                      std::string(JobStateName(job.state)) +
                                                      ": cancel it before it is deleted"),
                        "JOB_NOT_FINISHED");
    }
    COHORT_ASSIGN_OR_RETURN(const int64_t number, NumberOf(id));
    for (const char* rows : {"task WHERE job", "job_mesh WHERE job", "job WHERE number"}) {
      sql << "DELETE FROM " + std::string(rows) + " = :number", soci::use(number);
    }
    return absl::OkStatus();
  });
}

absl::Status Catalog::RemoveMesh(const std::string& set, const std::string& name) {
  return database_->Write([&](soci::session& sql) -> absl::Status {
    soci::statement remove =
        (sql.prepare << "DELETE FROM mesh WHERE set_name = :set_name AND name = :name",
         soci::use(set), soci::use(name));
    remove.execute(true);
    if (remove.get_affected_rows() == 0) {
      return absl::NotFoundError("set '" + set + "' has no mesh '" + name + "'");
    }
    return absl::OkStatus();
  });
}

absl::Status Catalog::DeleteSet(const std::string& set) {
  return database_->Write([&](soci::session& sql) -> absl::Status {
    soci::statement remove =
        (sql.prepare << "DELETE FROM mesh WHERE set_name = :set_name", soci::use(set));
    remove.execute(true);
    if (remove.get_affected_rows() == 0) {
      return absl::NotFoundError("there is no set '" + set + "'");
    }
    return absl::OkStatus();
  });
}

absl::StatusOr<int64_t> Catalog::ForgetActions(int64_t created_before_unix_ms) {
  int64_t forgotten = 0;
  COHORT_RETURN_IF_ERROR(database_->Write([&](soci::session& sql) {
    soci::statement remove = (sql.prepare << "DELETE FROM action WHERE created_unix_ms < :before",
                              soci::use(created_before_unix_ms));
    remove.execute(true);
    forgotten = remove.get_affected_rows();
    return absl::OkStatus();
  }));
  return forgotten;
}

absl::StatusOr<int64_t> Catalog::ForgetUnusedIngested() {
  int64_t forgotten = 0;
  COHORT_RETURN_IF_ERROR(database_->Write([&](soci::session& sql) {
    soci::statement remove =
        (sql.prepare << "DELETE FROM ingested WHERE raw NOT IN "
                        "(SELECT raw FROM mesh UNION SELECT raw FROM job_mesh)");
    remove.execute(true);
    forgotten = remove.get_affected_rows();
    return absl::OkStatus();
  }));
  return forgotten;
}

}  // namespace cohort
