#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include <absl/status/statusor.h>

#include "server/catalog/database_backend.h"

namespace cohort {

/// A database of a PostgreSQL server (13 or newer; tested with 15), in the first schema of the
/// search path. Held by one server: a session-level advisory lock, which PostgreSQL gives back when
/// the session ends, so the connection must reach the server itself or a proxy that keeps sessions
/// (pgbouncer: pool_mode=session). After a lost connection the lock is taken anew; a mark that each
/// server leaves when it opens the catalog tells whether another one was there meanwhile.
class PostgresBackend : public DatabaseBackend {
 public:
  /// Whether a location is of PostgreSQL: begins with "postgresql:" or "postgres:".
  [[nodiscard]] static bool IsLocation(std::string_view location);

  /// @param location  "postgresql://USER@HOST/DATABASE?..." or "postgresql:" and libpq's keywords,
  ///                  "postgresql:dbname=... host=...".
  /// @return kInvalidArgument with libpq's reason if it cannot be understood.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<PostgresBackend>> Create(
      const std::string& location);

  [[nodiscard]] const std::string& Name() const override { return name_; }
  [[nodiscard]] absl::Status Open(soci::session& session) override;
  [[nodiscard]] int64_t Version(soci::session& session) const override;
  [[nodiscard]] absl::Status Configure(soci::session& session) override;
  void SetVersion(soci::session& session, int64_t version) override;
  [[nodiscard]] std::string Ddl(std::string_view statement) const override;
  void BeginWrite(soci::session& session, CommitSync sync) override;
  [[nodiscard]] absl::Status ToStatus(const soci::soci_error& error) const override;
  [[nodiscard]] bool IsLost(soci::session& session) const override;

 private:
  PostgresBackend(std::string connection, std::string name)
      : connection_(std::move(connection)), name_(std::move(name)) {}
  [[nodiscard]] absl::Status CheckServer(soci::session& session) const;
  [[nodiscard]] absl::Status TakeLock(soci::session& session) const;
  /// Whether the mark is there and not ours.
  [[nodiscard]] bool AnotherServerWasHere(soci::session& session) const;

  std::string connection_;  ///< libpq's keywords and values. May hold a password.
  std::string name_;
  std::string mark_;  ///< Ours in the table cohort_meta; empty before the first Configure.
};

}  // namespace cohort
