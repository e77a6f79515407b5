#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace cohort::testing {

/// A private PostgreSQL server in a temporary folder: reached by a Unix socket only, with data
/// checksums, sorting as English does (so that what must be bytewise shows it is). Runs as the user
/// postgres when the tests run as root. Ends with this object, or with the process however it dies.
class PostgresCluster {
 public:
  PostgresCluster();
  ~PostgresCluster();
  PostgresCluster(const PostgresCluster&) = delete;
  PostgresCluster& operator=(const PostgresCluster&) = delete;

  /// One for all tests of a process, started when it is first asked for.
  [[nodiscard]] static PostgresCluster& Shared();

  /// Why there is none, for GTEST_SKIP; empty if it runs.
  [[nodiscard]] const std::string& Missing() const { return missing_; }

  /// Creates an empty database. @param options  of CREATE DATABASE, e.g. "TABLESPACE small".
  /// @return its location as Catalog::Open takes it.
  std::string CreateDatabase(const std::string& options = "");
  /// Creates an empty schema, much faster, in a database that all of them share. A server's lock is
  /// on the database: only one such catalog can be open at a time.
  std::string CreateSchema();
  /// Runs SQL in a database by its location, or in "postgres" if that is empty; aborts if it fails.
  void Run(const std::string& sql, const std::string& location = "") const;
  /// The same. @return the first column of the first row; empty if there is none.
  [[nodiscard]] std::string Ask(const std::string& sql, const std::string& location = "") const;

  /// Kills the server as a crash would, and starts it again.
  void Crash();
  void Stop(int signal);
  void Start();

  /// Where the server keeps its files.
  [[nodiscard]] std::filesystem::path Data() const { return folder_ / "data"; }
  /// A folder for the server to write in: gives it to the server's user.
  void GiveAway(const std::filesystem::path& folder) const;
  /// Starts one of PostgreSQL's programs as the server's user.
  [[nodiscard]] pid_t Spawn(const std::vector<std::string>& arguments) const;

 private:
  [[nodiscard]] std::string Connection(const std::string& database) const;
  [[nodiscard]] bool FindPrograms();

  std::filesystem::path folder_;
  std::filesystem::path programs_;
  std::string missing_;
  uid_t user_;
  gid_t group_;
  pid_t server_ = -1;
  int databases_ = 0;
  int schemas_ = 0;
};

}  // namespace cohort::testing
