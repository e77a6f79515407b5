#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <absl/status/statusor.h>

#include "common/base/call_times.h"
#include "common/base/mutex.h"
#include "common/base/status_macros.h"
#include "server/catalog/catalog_session.h"
#include "server/catalog/database_backend.h"

namespace cohort {

/// The open database and its one session: transactions, the schema's version, lost connections. The
/// only place that catches what SOCI throws. Thread-safe: bodies take turns.
class Database {
 public:
  /// @return as Catalog::Open.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<Database>> Open(const std::string& location);

  /// Statements of one call; what they throw becomes a status that names the database.
  using Body = std::function<absl::Status(CatalogSession&)>;
  /// Runs a body that changes nothing.
  [[nodiscard]] absl::Status Read(const Body& body);
  /// Read of a body that finds a value.
  template <typename T>
  [[nodiscard]] absl::StatusOr<T> ReadValue(
      const std::function<absl::StatusOr<T>(CatalogSession&)>& body) {
    std::optional<T> value;
    COHORT_RETURN_IF_ERROR(Read([&](CatalogSession& sql) -> absl::Status {
      COHORT_ASSIGN_OR_RETURN(value, body(sql));
      return absl::OkStatus();
    }));
    return *std::move(value);
  }
  /// Runs a body in a transaction: all that it changed is durable, as `sync` says, if this is OK.
  /// Else nothing is changed; but if the connection broke or the disk failed during the commit
  /// itself, a restart may find all of it changed.
  [[nodiscard]] absl::Status Write(const Body& body, CommitSync sync = CommitSync::kNow);
  /// Of Write, without the wait for others.
  [[nodiscard]] CallTimes WriteTimes() const { return write_timer_.Times(); }

 private:
  explicit Database(std::unique_ptr<DatabaseBackend> backend) : backend_(std::move(backend)) {}

  /// Opens the session if it is not, and brings the schema to our version.
  [[nodiscard]] absl::Status Connect() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  [[nodiscard]] absl::Status OpenSession() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  [[nodiscard]] absl::Status Migrate() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  [[nodiscard]] absl::Status Transact(const Body& body, CommitSync sync)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void CloseSession() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  /// Closes a session that is broken, so that the next call opens another.
  void DropIfLost() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  [[nodiscard]] absl::Status Catch(const std::function<absl::Status()>& statements) const;

  std::unique_ptr<DatabaseBackend> backend_;  ///< First: its lock is given back after the session.
  CallTimer write_timer_;
  Mutex mutex_;
  CatalogSession session_ ABSL_GUARDED_BY(mutex_);
  bool is_open_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace cohort
