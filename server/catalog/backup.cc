#include "server/catalog/backup.h"

#include <sqlite3.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <memory>
#include <system_error>

#include "common/base/status_macros.h"
#include "server/catalog/checksum_vfs.h"
#include "server/catalog/postgres_backend.h"
#include "server/catalog/publish_file.h"
#include "server/catalog/sqlite_backend.h"

namespace cohort {
namespace {

using Connection = std::unique_ptr<sqlite3, decltype(&sqlite3_close)>;
using Statement = std::unique_ptr<sqlite3_stmt, decltype(&sqlite3_finalize)>;

/// Without SOCI, which would create a file that is not there.
absl::StatusOr<Connection> Open(const std::string& file) {
  RegisterChecksumVfs();
  sqlite3* opened = nullptr;
  const int result = sqlite3_open_v2(file.c_str(), &opened, SQLITE_OPEN_READWRITE, kChecksumVfs);
  Connection connection(opened, &sqlite3_close);
  if (result != SQLITE_OK) {
    return SqliteStatus(file, result, sqlite3_errmsg(opened));
  }
  sqlite3_busy_timeout(opened, 5000);
  return connection;
}

/// Runs one statement. @return the first column of its first row; empty if there is none.
absl::StatusOr<std::string> Run(sqlite3* connection,
                                const std::string& file,
                                const std::string& sql,
                                const std::string& parameter = "") {
  sqlite3_stmt* prepared = nullptr;
  int result = sqlite3_prepare_v2(connection, sql.c_str(), -1, &prepared, nullptr);
  const Statement statement(prepared, &sqlite3_finalize);
  if (result == SQLITE_OK && sqlite3_bind_parameter_count(prepared) == 1) {
    result = sqlite3_bind_text(prepared, 1, parameter.c_str(), -1, SQLITE_TRANSIENT);
  }
  if (result == SQLITE_OK) {
    result = sqlite3_step(prepared);
  }
  if (result == SQLITE_ROW) {
    const unsigned char* text = sqlite3_column_text(prepared, 0);
    return std::string(text == nullptr ? "" : reinterpret_cast<const char*>(text));
  }
  if (result != SQLITE_DONE) {
    return SqliteStatus(file, result, sqlite3_errmsg(connection));
  }
  return std::string();
}

/// Reads every page and so verifies its checksum.
absl::Status CheckCatalog(sqlite3* connection, const std::string& file) {
  COHORT_ASSIGN_OR_RETURN(const std::string application_id,
                          Run(connection, file, "PRAGMA application_id"));
  if (application_id != std::to_string(kSqliteApplicationId)) {
    return absl::DataLossError(file + ": not a catalog of Cohort");
  }
  COHORT_ASSIGN_OR_RETURN(const std::string problem,
                          Run(connection, file, "PRAGMA quick_check(1)"));
  return problem == "ok" ? absl::OkStatus()
                         : SqliteStatus(file, SQLITE_CORRUPT, "damaged: " + problem);
}

absl::Status CopyInto(const std::string& file, const std::string& aside) {
  COHORT_ASSIGN_OR_RETURN(const Connection source, Open(file));
  COHORT_RETURN_IF_ERROR(CheckCatalog(source.get(), file));
  int bytes = kChecksumBytes;
  sqlite3_file_control(source.get(), "main", SQLITE_FCNTL_RESERVE_BYTES, &bytes);
  COHORT_RETURN_IF_ERROR(Run(source.get(), file, "VACUUM INTO ?", aside).status());
  COHORT_ASSIGN_OR_RETURN(const Connection copy, Open(aside));
  return CheckCatalog(copy.get(), aside);
}

}  // namespace

absl::Status BackUpCatalog(const std::string& location, const std::filesystem::path& to) {
  if (PostgresBackend::IsLocation(location)) {
    return absl::InvalidArgumentError(
        "backup: the catalog is in PostgreSQL, whose own tools back it up while it is in use: "
        "pg_dump --format=custom --file=" +
        to.string() + " (restore: pg_restore) or pg_basebackup");
  }
  std::error_code error;
  if (!std::filesystem::exists(location, error)) {
    return absl::NotFoundError("there is no catalog " + location);
  }
  if (std::filesystem::exists(to, error)) {
    return absl::AlreadyExistsError(to.string() + ": is there already, not overwritten");
  }
  // Of this process alone: SQLite takes an empty file for one that is not there.
  std::string aside = to.string() + ".XXXXXX";
  const int created = ::mkstemp(aside.data());
  if (created < 0) {
    return absl::ErrnoToStatus(errno, to.string() + ": cannot create");
  }
  ::close(created);
  absl::Status status = CopyInto(location, aside);
  if (status.ok()) {
    status = PublishFile(aside, to, ExistingFile::kRefuse);
  }
  if (!status.ok()) {
    ::unlink(aside.c_str());
  }
  return status;
}

}  // namespace cohort
