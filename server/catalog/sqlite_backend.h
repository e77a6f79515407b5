#pragma once

#include <memory>
#include <string>
#include <utility>

#include <absl/status/statusor.h>

#include "server/catalog/database_backend.h"
#include "server/catalog/file_lock.h"

namespace cohort {

inline constexpr int64_t kSqliteApplicationId = 0x434F4854;  ///< "COHT", shown by file(1).

/// "<file>: <reason>" with the code that a result of SQLite asks for; tells which page is damaged.
[[nodiscard]] absl::Status SqliteStatus(const std::string& file,
                                        int result,
                                        const std::string& reason);

/// A file: SQLite with a write-ahead log, synchronous=FULL, and a checksum in each page
/// (checksum_vfs.h). Held by one server: a lock file beside it.
class SqliteBackend : public DatabaseBackend {
 public:
  /// @return as Catalog::Open.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<SqliteBackend>> Create(
      const std::string& file);

  [[nodiscard]] const std::string& Name() const override { return file_; }
  [[nodiscard]] absl::Status Open(soci::session& session) override;
  [[nodiscard]] int64_t Version(soci::session& session) const override;
  [[nodiscard]] absl::Status Configure(soci::session& session) override;
  void SetVersion(soci::session& session, int64_t version) override;
  [[nodiscard]] std::string Ddl(std::string_view statement) const override;
  void BeginWrite(soci::session& session, CommitSync sync) override;
  [[nodiscard]] absl::Status ToStatus(const soci::soci_error& error) const override;
  [[nodiscard]] bool IsLost(soci::session& /*session*/) const override { return false; }

 private:
  SqliteBackend(std::string file, FileLock lock) : lock_(std::move(lock)), file_(std::move(file)) {}
  void Connect(soci::session& session) const;
  void SetSync(soci::session& session, CommitSync sync);
  /// Refuses what is damaged or not ours.
  [[nodiscard]] absl::Status CheckFile(soci::session& session) const;
  /// Rewrites a catalog of a build that did not know checksums.
  [[nodiscard]] absl::Status AddChecksums(soci::session& session) const;

  FileLock lock_;
  std::string file_;
  CommitSync sync_ = CommitSync::kNow;  ///< As the session has it.
};

}  // namespace cohort
