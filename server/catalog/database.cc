#include "server/catalog/database.h"

#include <cstdint>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "common/base/status_macros.h"
#include "server/catalog/schema.h"

namespace cohort {
namespace {

constexpr int64_t kApplicationId = 0x434F4854;  // "COHT", shown by file(1)
constexpr char kBeginWrite[] = "BEGIN IMMEDIATE";

/// "<file>: <reason>" with the code that SQLite's result asks for. SOCI begins its messages with
/// the function that failed, which says nothing to people.
absl::Status SqliteStatus(const std::string& file, const soci::sqlite3_soci_error& error) {
  std::string reason = error.get_error_message();
  if (const size_t end = reason.find(": "); reason.starts_with("sqlite3_") && end != reason.npos) {
    reason.erase(0, end + 2);
  }
  const std::string message = file + ": " + reason;
  switch (error.result() & 0xff) {  // The low byte is the code, the others say more of it.
    case SQLITE_FULL:
      return absl::ResourceExhaustedError(message);
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return absl::DataLossError(message);
    default:
      return absl::UnavailableError(message);
  }
}

int64_t SelectNumber(soci::session& sql, const std::string& query) {
  int64_t number = 0;
  sql << query, soci::into(number);
  return number;
}

std::string SelectText(soci::session& sql, const std::string& query) {
  std::string text;
  sql << query, soci::into(text);
  return text;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Database>> Database::Open(const std::filesystem::path& file) {
  std::error_code error;
  const std::filesystem::path path = std::filesystem::absolute(file, error);
  if (error) {
    return absl::UnavailableError(file.string() + ": " + error.message());
  }
  // SOCI takes the name inside quotes and knows no escape.
  if (path.string().find('"') != std::string::npos) {
    return absl::InvalidArgumentError(path.string() + ": a catalog's name must not hold quotes");
  }
  COHORT_ASSIGN_OR_RETURN(FileLock lock, FileLock::Acquire(path));
  std::unique_ptr<Database> database(new Database(path.string(), std::move(lock)));
  COHORT_RETURN_IF_ERROR(database->Connect());
  return database;
}

absl::Status Database::Read(const Body& body) {
  MutexLock lock(mutex_);
  return Catch([&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return body(session_); });
}

absl::Status Database::Write(const Body& body) {
  MutexLock lock(mutex_);
  return Transact(body);
}

absl::Status Database::Connect() {
  MutexLock lock(mutex_);
  return Catch([&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) -> absl::Status {
    session_.open(soci::sqlite3, "db=\"" + file_ + "\" timeout=5");
    COHORT_RETURN_IF_ERROR(CheckFile());
    COHORT_RETURN_IF_ERROR(Configure());
    return Migrate();
  });
}

absl::Status Database::CheckFile() {
  const int64_t application_id = SelectNumber(session_, "PRAGMA application_id");
  const int64_t version = SelectNumber(session_, "PRAGMA user_version");
  const int64_t objects = SelectNumber(session_, "SELECT COUNT(*) FROM sqlite_master");
  const bool is_new = application_id == 0 && version == 0 && objects == 0;
  if (!is_new && application_id != kApplicationId) {
    return absl::DataLossError(file_ + ": a database, but not a catalog of Cohort");
  }
  const int64_t newest = static_cast<int64_t>(SchemaMigrations().size());
  if (version > newest) {
    return absl::FailedPreconditionError(file_ + ": has version " + std::to_string(version) +
                                         ", this cohort-server knows up to " +
                                         std::to_string(newest) + "; use a newer one");
  }
  // SQLite opens a file that it may not write without a word: found here, not by the first job.
  const auto& backend = static_cast<const soci::sqlite3_session_backend&>(*session_.get_backend());
  if (sqlite_api::sqlite3_db_readonly(backend.conn_, "main") == 1) {
    return absl::UnavailableError(file_ + ": is read-only");
  }
  const std::string problem = SelectText(session_, "PRAGMA quick_check(1)");
  if (problem != "ok") {
    return absl::DataLossError(file_ + ": damaged: " + problem);
  }
  return absl::OkStatus();
}

absl::Status Database::Configure() {
  const std::string mode = SelectText(session_, "PRAGMA journal_mode = WAL");
  if (mode != "wal") {
    return absl::UnavailableError(file_ + ": cannot keep a write-ahead log here (mode " + mode +
                                  ")");
  }
  session_ << "PRAGMA synchronous = FULL";
  session_ << "PRAGMA foreign_keys = ON";
  session_ << "PRAGMA busy_timeout = 5000";
  session_ << "PRAGMA journal_size_limit = 67108864";
  return absl::OkStatus();
}

absl::Status Database::Migrate() {
  const std::span<const Migration> migrations = SchemaMigrations();
  const int64_t version = SelectNumber(session_, "PRAGMA user_version");
  for (size_t next = static_cast<size_t>(version); next < migrations.size(); ++next) {
    COHORT_RETURN_IF_ERROR(Transact([&](soci::session& sql) {
      for (const std::string_view statement : migrations[next]) {
        sql << std::string(statement);
      }
      sql << "PRAGMA application_id = " + std::to_string(kApplicationId);
      sql << "PRAGMA user_version = " + std::to_string(next + 1);
      return absl::OkStatus();
    }));
  }
  return absl::OkStatus();
}

absl::Status Database::Transact(const Body& body) {
  absl::Status status = Catch([&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) -> absl::Status {
    session_ << kBeginWrite;
    COHORT_RETURN_IF_ERROR(body(session_));
    session_.commit();
    return absl::OkStatus();
  });
  if (!status.ok()) {
    // Fails where SQLite has rolled back by itself (disk full) or could not begin: nothing is
    // changed then either, and the first error is the one to report.
    Catch([&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      session_.rollback();
      return absl::OkStatus();
    }).IgnoreError();
  }
  return status;
}

absl::Status Database::Catch(const std::function<absl::Status()>& statements) const {
  try {
    absl::Status status = statements();
    if (absl::IsDataLoss(status) &&
        std::string(status.message()).find(file_) == std::string::npos) {
      return absl::DataLossError(file_ + ": " + std::string(status.message()));
    }
    return status;
  } catch (const soci::sqlite3_soci_error& error) {
    return SqliteStatus(file_, error);
  } catch (const soci::soci_error& error) {
    return absl::UnavailableError(file_ + ": " + error.get_error_message());
  } catch (const nlohmann::json::exception& error) {
    return absl::InvalidArgumentError(file_ +
                                      ": cannot keep a text that is not UTF-8: " + error.what());
  }
}

}  // namespace cohort
