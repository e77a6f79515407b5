#include "server/catalog/database.h"

#include <chrono>
#include <cstdint>
#include <utility>

#include <nlohmann/json.hpp>

#include "common/base/status_macros.h"
#include "server/catalog/postgres_backend.h"
#include "server/catalog/schema.h"
#include "server/catalog/sqlite_backend.h"

namespace cohort {
namespace {

absl::StatusOr<std::unique_ptr<DatabaseBackend>> MakeBackend(const std::string& location) {
  if (PostgresBackend::IsLocation(location)) {
    return PostgresBackend::Create(location);
  }
  return SqliteBackend::Create(location);
}

}  // namespace

absl::StatusOr<std::unique_ptr<Database>> Database::Open(const std::string& location) {
  COHORT_ASSIGN_OR_RETURN(std::unique_ptr<DatabaseBackend> backend, MakeBackend(location));
  std::unique_ptr<Database> database(new Database(std::move(backend)));
  MutexLock lock(database->mutex_);
  COHORT_RETURN_IF_ERROR(database->Connect());
  return database;
}

absl::Status Database::Read(const Body& body) {
  MutexLock lock(mutex_);
  COHORT_RETURN_IF_ERROR(Connect());
  absl::Status status =
      Catch([&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return body(session_); });
  if (!status.ok()) {
    session_.Forget();
  }
  DropIfLost();
  return status;
}

absl::Status Database::Write(const Body& body, CommitSync sync) {
  MutexLock lock(mutex_);
  const auto start = std::chrono::steady_clock::now();
  COHORT_RETURN_IF_ERROR(Connect());
  absl::Status status = Transact(body, sync);
  write_timer_.Add(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  DropIfLost();
  return status;
}

absl::Status Database::Connect() {
  if (is_open_) {
    return absl::OkStatus();
  }
  const auto open = [&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return OpenSession(); };
  absl::Status status = Catch(open);
  is_open_ = status.ok();
  if (!is_open_) {
    CloseSession();
  }
  return status;
}

absl::Status Database::OpenSession() {
  COHORT_RETURN_IF_ERROR(backend_->Open(session_));
  const int64_t version = backend_->Version(session_);
  const auto newest = static_cast<int64_t>(SchemaMigrations().size());
  if (version > newest) {
    return absl::FailedPreconditionError(
        backend_->Name() + ": has version " + std::to_string(version) +
        ", this cohort-server knows up to " + std::to_string(newest) + "; use a newer one");
  }
  COHORT_RETURN_IF_ERROR(backend_->Configure(session_));
  return Migrate();
}

absl::Status Database::Migrate() {
  const std::span<const Migration> migrations = SchemaMigrations();
  const int64_t version = backend_->Version(session_);
  for (size_t next = static_cast<size_t>(version); next < migrations.size(); ++next) {
    const auto migrate = [&](soci::session& sql) {
      for (const std::string_view statement : migrations[next]) {
        sql << backend_->Ddl(statement);
      }
      backend_->SetVersion(sql, static_cast<int64_t>(next) + 1);
      return absl::OkStatus();
    };
    COHORT_RETURN_IF_ERROR(Transact(migrate, CommitSync::kNow));
  }
  return absl::OkStatus();
}

absl::Status Database::Transact(const Body& body, CommitSync sync) {
  absl::Status status = Catch([&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) -> absl::Status {
    backend_->BeginWrite(session_, sync);
    COHORT_RETURN_IF_ERROR(body(session_));
    session_.commit();
    return absl::OkStatus();
  });
  if (!status.ok()) {
    // Fails where the database has rolled back by itself (disk full, connection lost) or could not
    // begin: nothing is changed then either, and the first error is the one to report.
    Catch([&]() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
      session_.rollback();
      return absl::OkStatus();
    }).IgnoreError();
    session_.Forget();
  }
  return status;
}

void Database::CloseSession() {
  session_.Forget();
  session_.close();
}

void Database::DropIfLost() {
  if (backend_->IsLost(session_)) {
    CloseSession();
    is_open_ = false;
  }
}

absl::Status Database::Catch(const std::function<absl::Status()>& statements) const {
  try {
    absl::Status status = statements();
    const std::string& name = backend_->Name();
    if (absl::IsDataLoss(status) && std::string(status.message()).find(name) == std::string::npos) {
      return absl::DataLossError(name + ": " + std::string(status.message()));
    }
    return status;
  } catch (const soci::soci_error& error) {
    return backend_->ToStatus(error);
  } catch (const nlohmann::json::exception& error) {
    return absl::InvalidArgumentError(backend_->Name() +
                                      ": cannot keep a text that is not UTF-8: " + error.what());
  }
}

}  // namespace cohort
