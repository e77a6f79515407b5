#include "server/catalog/postgres_backend.h"

#include <algorithm>
#include <array>
#include <map>

#include <absl/strings/str_replace.h>
#include <soci/postgresql/soci-postgresql.h>

#include "common/base/status_macros.h"

namespace cohort {
namespace {

constexpr std::array<std::string_view, 2> kPrefixes = {"postgresql:", "postgres:"};

constexpr int kLockAttempts = 40;  ///< 2 seconds.

/// What we ask of a connection unless the location says otherwise: nothing waits for ever on a
/// server that is gone.
const std::map<std::string, std::string>& ConnectionDefaults() {
  static const auto* const defaults =
      new std::map<std::string, std::string>{{"application_name", "cohort-server"},
                                             {"connect_timeout", "10"},
                                             {"keepalives_idle", "10"},
                                             {"keepalives_interval", "5"},
                                             {"keepalives_count", "3"},
                                             {"tcp_user_timeout", "30000"}};
  return *defaults;
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

bool HasMeta(soci::session& sql) {
  return SelectNumber(sql,
                      "SELECT COUNT(*) FROM pg_tables WHERE schemaname = current_schema() "
                      "AND tablename = 'cohort_meta'") > 0;
}

std::string MetaValue(soci::session& sql, const std::string& name) {
  std::string value;
  sql << "SELECT value FROM cohort_meta WHERE name = :name", soci::use(name), soci::into(value);
  return value;
}

void SetMetaValue(soci::session& sql, const std::string& name, const std::string& value) {
  sql << "INSERT INTO cohort_meta (name, value) VALUES (:name, :value) "
         "ON CONFLICT (name) DO UPDATE SET value = excluded.value",
      soci::use(name), soci::use(value);
}

/// Keywords and values in libpq's own writing.
std::string Joined(const std::map<std::string, std::string>& options) {
  std::string joined;
  for (const auto& [keyword, value] : options) {
    joined += keyword + "='" + absl::StrReplaceAll(value, {{"\\", "\\\\"}, {"'", "\\'"}}) + "' ";
  }
  return joined;
}

std::string NameOf(const std::map<std::string, std::string>& options) {
  const auto value_or = [&options](const char* keyword, const char* otherwise) {
    const auto found = options.find(keyword);
    return found == options.end() ? std::string(otherwise) : found->second;
  };
  return "PostgreSQL database '" + value_or("dbname", "(default)") + "' on '" +
         value_or("host", "(default)") + "'";
}

}  // namespace

bool PostgresBackend::IsLocation(std::string_view location) {
  return std::any_of(kPrefixes.begin(), kPrefixes.end(),
                     [location](std::string_view prefix) { return location.starts_with(prefix); });
}

absl::StatusOr<std::unique_ptr<PostgresBackend>> PostgresBackend::Create(
    const std::string& location) {
  const size_t after_scheme = location.find(':') + 1;
  const bool is_uri = location.compare(after_scheme, 2, "//") == 0;
  const std::string text = is_uri ? location : location.substr(after_scheme);
  char* reason = nullptr;
  PQconninfoOption* const parsed = PQconninfoParse(text.c_str(), &reason);
  if (parsed == nullptr) {
    const std::string message = reason == nullptr ? "out of memory" : reason;
    PQfreemem(reason);
    return absl::InvalidArgumentError("catalog location of PostgreSQL: " +
                                      message.substr(0, message.find('\n')));
  }
  std::map<std::string, std::string> options = ConnectionDefaults();
  for (const PQconninfoOption* option = parsed; option->keyword != nullptr; ++option) {
    if (option->val != nullptr) {
      options[option->keyword] = option->val;
    }
  }
  PQconninfoFree(parsed);
  options["client_encoding"] = "UTF8";
  return std::unique_ptr<PostgresBackend>(new PostgresBackend(Joined(options), NameOf(options)));
}

absl::Status PostgresBackend::Open(soci::session& session) {
  session.open(soci::postgresql, connection_);
  session << "SET client_min_messages = error";  // libpq would print warnings.
  COHORT_RETURN_IF_ERROR(CheckServer(session));
  COHORT_RETURN_IF_ERROR(TakeLock(session));
  const bool has_tables =
      SelectNumber(session, "SELECT COUNT(*) FROM pg_tables WHERE schemaname = current_schema()") >
      0;
  if (has_tables && !HasMeta(session)) {
    return absl::DataLossError(name_ +
                               ": has tables, but is not a catalog of Cohort; "
                               "give the catalog a database of its own");
  }
  return absl::OkStatus();
}

absl::Status PostgresBackend::CheckServer(soci::session& session) const {
  if (SelectNumber(session, "SELECT CAST(current_setting('server_version_num') AS BIGINT)") <
      130'000) {
    return absl::FailedPreconditionError(name_ + ": PostgreSQL 13 or newer is needed, this is " +
                                         SelectText(session, "SHOW server_version"));
  }
  if (SelectText(session, "SHOW server_encoding") != "UTF8") {
    return absl::FailedPreconditionError(name_ + ": its encoding is " +
                                         SelectText(session, "SHOW server_encoding") +
                                         ", create it with ENCODING 'UTF8'");
  }
  // Without them a flipped bit on disk would become a wrong value.
  if (SelectText(session, "SHOW data_checksums") != "on") {
    return absl::FailedPreconditionError(
        name_ +
        ": the PostgreSQL cluster has no data checksums; stop it, run "
        "pg_checksums --enable, start it");
  }
  if (SelectText(session, "SHOW fsync") != "on" ||
      SelectText(session, "SHOW full_page_writes") != "on") {
    return absl::FailedPreconditionError(
        name_ +
        ": the PostgreSQL cluster runs with fsync or full_page_writes off and would lose "
        "what it acknowledged");
  }
  return absl::OkStatus();
}

absl::Status PostgresBackend::TakeLock(soci::session& session) const {
  for (int attempt = 0; attempt < kLockAttempts; ++attempt) {
    // Advisory locks are a database's own, so a constant will do: 'COHT'.
    const int64_t locked = SelectNumber(
        session, "SELECT CASE WHEN pg_try_advisory_lock(1129269332, 1) THEN 1 ELSE 0 END");
    if (locked == 1) {
      return absl::OkStatus();
    }
    // The session of a server that was killed ends a moment after it.
    session << "SELECT pg_sleep(0.05)";
  }
  if (mark_.empty() || AnotherServerWasHere(session)) {
    return absl::FailedPreconditionError("another cohort-server uses " + name_);
  }
  // PostgreSQL has not noticed yet that our last connection is gone.
  return absl::UnavailableError(name_ + ": waits for the end of the connection that was lost");
}

bool PostgresBackend::AnotherServerWasHere(soci::session& session) const {
  return HasMeta(session) && MetaValue(session, "owner") != mark_;
}

int64_t PostgresBackend::Version(soci::session& session) const {
  if (!HasMeta(session)) {
    return 0;
  }
  int64_t version = 0;
  session << "SELECT CAST(value AS BIGINT) FROM cohort_meta WHERE name = 'version'",
      soci::into(version);
  return version;
}

absl::Status PostgresBackend::Configure(soci::session& session) {
  // What a server's configuration may say otherwise: an acknowledged commit is on disk, and no
  // time-out ends the one session, which holds the lock.
  if (SelectText(session, "SHOW synchronous_commit") == "off") {
    session << "SET synchronous_commit = on";
  }
  for (const char* timeout :
       {"statement_timeout", "lock_timeout", "idle_in_transaction_session_timeout"}) {
    session << "SET " + std::string(timeout) + " = 0";
  }
  if (!mark_.empty()) {
    return AnotherServerWasHere(session)
               ? absl::FailedPreconditionError(name_ +
                                               ": the connection was lost and another "
                                               "cohort-server took the catalog; this one must end")
               : absl::OkStatus();
  }
  const std::string mark = SelectText(session, "SELECT CAST(gen_random_uuid() AS TEXT)");
  session << "BEGIN";
  session << Ddl(
      "CREATE TABLE IF NOT EXISTS cohort_meta ("
      "name TEXT NOT NULL PRIMARY KEY, value TEXT NOT NULL)");
  SetMetaValue(session, "owner", mark);
  session.commit();
  mark_ = mark;
  return absl::OkStatus();
}

void PostgresBackend::SetVersion(soci::session& session, int64_t version) {
  SetMetaValue(session, "version", std::to_string(version));
}

void PostgresBackend::BeginWrite(soci::session& session, CommitSync sync) {
  session << "BEGIN";
  if (sync == CommitSync::kLater) {
    session << "SET LOCAL synchronous_commit = off";
  }
}

std::string PostgresBackend::Ddl(std::string_view statement) const {
  // Texts compare bytewise, whatever the locale of the database.
  return absl::StrReplaceAll(std::string(statement), {{" TEXT ", " TEXT COLLATE \"C\" "}});
}

absl::Status PostgresBackend::ToStatus(const soci::soci_error& error) const {
  // "Cannot execute query. Fatal error. ERROR:  <reason>\nDETAIL: ...": the reason is for people.
  std::string reason = error.get_error_message();
  for (const std::string_view before : {"ERROR:  ", "FATAL:  ", "PANIC:  "}) {
    if (const size_t begin = reason.find(before); begin != std::string::npos) {
      reason.erase(0, begin + before.size());
    }
  }
  std::replace(reason.begin(), reason.end(), '\n', ' ');
  const std::string message = name_ + ": " + reason.substr(0, reason.find_last_not_of(' ') + 1);
  const auto* postgres = dynamic_cast<const soci::postgresql_soci_error*>(&error);
  // PostgreSQL 15 manual, appendix A.
  const std::string state = postgres == nullptr ? std::string() : postgres->sqlstate();
  if (state == "53100") {  // disk_full
    return absl::ResourceExhaustedError(message);
  }
  if (state == "XX001" || state == "XX002") {  // data_corrupted, index_corrupted
    return absl::DataLossError(message);
  }
  if (state == "22021") {  // character_not_in_repertoire
    return absl::InvalidArgumentError(message);
  }
  return absl::UnavailableError(message);
}

bool PostgresBackend::IsLost(soci::session& session) const {
  const auto& backend =
      static_cast<const soci::postgresql_session_backend&>(*session.get_backend());
  return PQstatus(backend.conn_) != CONNECTION_OK;
}

}  // namespace cohort
