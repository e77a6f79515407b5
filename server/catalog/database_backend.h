#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include <absl/status/status.h>

#include "server/catalog/soci_session.h"

namespace cohort {

/// When what a transaction wrote is on the disk. The end of the server's process loses nothing that
/// is committed, in either case.
enum class CommitSync : uint8_t {
  kNow,    ///< Before the call returns.
  kLater,  ///< With the next kNow; till then a power failure may undo it.
};

/// What is different from one database to another; everything else is SQL that all understand.
/// Only for Database: but for ToStatus, throws what SOCI throws. Not thread-safe.
class DatabaseBackend {
 public:
  virtual ~DatabaseBackend() = default;

  /// How messages name the database: its file, or its name and host (never a password).
  [[nodiscard]] virtual const std::string& Name() const = 0;

  /// Opens `session` as the only one that uses the catalog. Changes nothing.
  /// @return as Catalog::Open.
  [[nodiscard]] virtual absl::Status Open(soci::session& session) = 0;
  /// Version of the schema that is there; 0: none yet.
  [[nodiscard]] virtual int64_t Version(soci::session& session) const = 0;
  /// Makes the open session durable and ours, before the first migration. May write, and may open
  /// the session anew.
  [[nodiscard]] virtual absl::Status Configure(soci::session& session) = 0;
  /// Notes the version, in a transaction.
  virtual void SetVersion(soci::session& session, int64_t version) = 0;

  /// A statement of the schema in this database's words.
  [[nodiscard]] virtual std::string Ddl(std::string_view statement) const = 0;
  /// Begins a transaction that will write.
  virtual void BeginWrite(soci::session& session, CommitSync sync) = 0;
  /// "<name>: <reason>" with the code that the error asks for, as Catalog promises.
  [[nodiscard]] virtual absl::Status ToStatus(const soci::soci_error& error) const = 0;
  /// Whether the session is broken and must be opened again.
  [[nodiscard]] virtual bool IsLost(soci::session& session) const = 0;
};

}  // namespace cohort
