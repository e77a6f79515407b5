#include "server/catalog/sqlite_backend.h"

#include <algorithm>
#include <filesystem>
#include <system_error>

#include <soci/sqlite3/soci-sqlite3.h>

#include "common/base/status_macros.h"
#include "server/catalog/checksum_vfs.h"
#include "server/catalog/publish_file.h"

namespace cohort {
namespace {

/// From this version on, every catalog has checksums: the file was written by a build that adds
/// them, so one without has lost them.
constexpr int64_t kChecksumsSinceVersion = 2;

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

sqlite_api::sqlite3* Connection(soci::session& session) {
  return static_cast<soci::sqlite3_session_backend&>(*session.get_backend()).conn_;
}

/// Asks for room for checksums, in a file that is new or is rewritten.
/// @return the bytes that each page of the file as it is leaves free.
int ReserveChecksumBytes(soci::session& session) {
  int bytes = kChecksumBytes;
  sqlite_api::sqlite3_file_control(Connection(session), "main", SQLITE_FCNTL_RESERVE_BYTES, &bytes);
  return bytes;
}

}  // namespace

absl::StatusOr<std::unique_ptr<SqliteBackend>> SqliteBackend::Create(const std::string& file) {
  std::error_code error;
  const std::filesystem::path path = std::filesystem::absolute(file, error);
  if (error) {
    return absl::UnavailableError(file + ": " + error.message());
  }
  // SOCI takes the name inside quotes and knows no escape.
  if (path.string().find('"') != std::string::npos) {
    return absl::InvalidArgumentError(path.string() + ": a catalog's name must not hold quotes");
  }
  COHORT_ASSIGN_OR_RETURN(FileLock lock, FileLock::Acquire(path));
  return std::unique_ptr<SqliteBackend>(new SqliteBackend(path.string(), std::move(lock)));
}

void SqliteBackend::Connect(soci::session& session) const {
  RegisterChecksumVfs();
  session.open(soci::sqlite3, "db=\"" + file_ + "\" timeout=5 vfs=" + kChecksumVfs);
}

absl::Status SqliteBackend::Open(soci::session& session) {
  Connect(session);
  return CheckFile(session);
}

absl::Status SqliteBackend::CheckFile(soci::session& session) const {
  const int64_t application_id = SelectNumber(session, "PRAGMA application_id");
  const int64_t objects = SelectNumber(session, "SELECT COUNT(*) FROM sqlite_master");
  const bool is_new = application_id == 0 && Version(session) == 0 && objects == 0;
  if (!is_new && application_id != kSqliteApplicationId) {
    return absl::DataLossError(file_ + ": a database, but not a catalog of Cohort");
  }
  // SQLite opens a file that it may not write without a word: found here, not by the first job.
  if (sqlite_api::sqlite3_db_readonly(Connection(session), "main") == 1) {
    return absl::UnavailableError(file_ + ": is read-only");
  }
  // Reads every page that holds something, and so verifies its checksum.
  const std::string problem = SelectText(session, "PRAGMA quick_check(1)");
  if (problem != "ok") {
    return SqliteStatus(file_, SQLITE_CORRUPT, "damaged: " + problem);
  }
  return absl::OkStatus();
}

int64_t SqliteBackend::Version(soci::session& session) const {
  return SelectNumber(session, "PRAGMA user_version");
}

absl::Status SqliteBackend::Configure(soci::session& session) {
  if (ReserveChecksumBytes(session) != kChecksumBytes &&
      SelectNumber(session, "PRAGMA page_count") > 0) {
    if (Version(session) >= kChecksumsSinceVersion) {
      return absl::DataLossError(file_ + ": damaged: its pages have no checksums");
    }
    COHORT_RETURN_IF_ERROR(AddChecksums(session));
  }
  const std::string mode = SelectText(session, "PRAGMA journal_mode = WAL");
  if (mode != "wal") {
    return absl::UnavailableError(file_ + ": cannot keep a write-ahead log here (mode " + mode +
                                  ")");
  }
  SetSync(session, CommitSync::kNow);
  session << "PRAGMA foreign_keys = ON";
  session << "PRAGMA busy_timeout = 5000";
  session << "PRAGMA journal_size_limit = 67108864";
  return absl::OkStatus();
}

void SqliteBackend::SetSync(soci::session& session, CommitSync sync) {
  // A sync of the log is one of everything written to it before.
  session << (sync == CommitSync::kNow ? "PRAGMA synchronous = FULL"
                                       : "PRAGMA synchronous = NORMAL");
  sync_ = sync;
}

void SqliteBackend::BeginWrite(soci::session& session, CommitSync sync) {
  if (sync != sync_) {
    SetSync(session, sync);
  }
  session << "BEGIN IMMEDIATE";
}

absl::Status SqliteBackend::AddChecksums(soci::session& session) const {
  // Into a new file, which takes the old one's place when it is on disk. The log must be gone
  // before: it would be taken for the new file's.
  const std::string mode = SelectText(session, "PRAGMA journal_mode = DELETE");
  if (mode != "delete") {
    return absl::UnavailableError(file_ +
                                  ": cannot be brought to this version while another "
                                  "program has it open (mode " +
                                  mode + ")");
  }
  const std::string fresh = file_ + ".new";
  std::error_code ignored;  // What cannot be removed cannot be written either, which is told.
  std::filesystem::remove(fresh, ignored);
  session << "VACUUM INTO :file", soci::use(fresh);
  session.close();
  COHORT_RETURN_IF_ERROR(PublishFile(fresh, file_, ExistingFile::kReplace));
  Connect(session);
  return CheckFile(session);
}

void SqliteBackend::SetVersion(soci::session& session, int64_t version) {
  session << "PRAGMA application_id = " + std::to_string(kSqliteApplicationId);
  session << "PRAGMA user_version = " + std::to_string(version);
}

std::string SqliteBackend::Ddl(std::string_view statement) const {
  return std::string(statement);
}

absl::Status SqliteBackend::ToStatus(const soci::soci_error& error) const {
  // SOCI begins its messages with the function that failed, which says nothing to people.
  std::string reason = error.get_error_message();
  if (const size_t end = reason.find(": "); reason.starts_with("sqlite3_") && end != reason.npos) {
    reason.erase(0, end + 2);
  }
  const auto* sqlite = dynamic_cast<const soci::sqlite3_soci_error*>(&error);
  return SqliteStatus(file_, sqlite == nullptr ? SQLITE_ERROR : sqlite->result(), reason);
}

absl::Status SqliteStatus(const std::string& file, int result, const std::string& reason) {
  const std::string page = TakePageDamage();
  std::string message = file + ": " + reason + (page.empty() ? "" : "; " + page);
  std::replace(message.begin(), message.end(), '\n', ' ');
  switch (result & 0xff) {  // The other bytes say more of it.
    case SQLITE_FULL:
      return absl::ResourceExhaustedError(message);
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return absl::DataLossError(message);
    default:
      return absl::UnavailableError(message);
  }
}

}  // namespace cohort
