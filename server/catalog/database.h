#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <absl/status/statusor.h>

#include "common/base/mutex.h"
#include "common/base/status_macros.h"
#include "server/catalog/file_lock.h"
#include "server/catalog/soci_session.h"

#include <soci/sqlite3/soci-sqlite3.h>

namespace cohort {

/// The open database file: its lock and its one session. The only place that knows SQLite from
/// other databases, and the only one that catches what SOCI throws. Thread-safe: bodies take turns.
class Database {
 public:
  /// @return as Catalog::Open.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<Database>> Open(
      const std::filesystem::path& file);

  /// Statements of one call; what they throw becomes a status that names the file.
  using Body = std::function<absl::Status(soci::session&)>;
  /// Runs a body that changes nothing.
  [[nodiscard]] absl::Status Read(const Body& body);
  /// Read of a body that finds a value.
  template <typename T>
  [[nodiscard]] absl::StatusOr<T> ReadValue(
      const std::function<absl::StatusOr<T>(soci::session&)>& body) {
    std::optional<T> value;
    COHORT_RETURN_IF_ERROR(Read([&](soci::session& sql) -> absl::Status {
      COHORT_ASSIGN_OR_RETURN(value, body(sql));
      return absl::OkStatus();
    }));
    return *std::move(value);
  }
  /// Runs a body in a transaction: all that it changed is durable if this is OK, else nothing is
  /// changed.
  [[nodiscard]] absl::Status Write(const Body& body);

 private:
  Database(std::string file, FileLock lock) : lock_(std::move(lock)), file_(std::move(file)) {}

  /// Opens the session and brings the schema to our version.
  [[nodiscard]] absl::Status Connect();
  /// Refuses, unchanged, what is damaged, not ours or too new.
  [[nodiscard]] absl::Status CheckFile() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  [[nodiscard]] absl::Status Configure() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  [[nodiscard]] absl::Status Migrate() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  [[nodiscard]] absl::Status Transact(const Body& body) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  [[nodiscard]] absl::Status Catch(const std::function<absl::Status()>& statements) const;

  FileLock lock_;  ///< First: given back after the session is closed.
  std::string file_;
  Mutex mutex_;
  soci::session session_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace cohort
