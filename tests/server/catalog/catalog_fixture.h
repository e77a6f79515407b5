#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "server/catalog/catalog.h"
#include "server/catalog/checksum_vfs.h"
#include "tests/common/store/scratch_folder.h"
#include "tests/testing/postgres_cluster.h"
#include "tests/testing/status_matchers.h"

namespace cohort::testing {

/// A mesh with made-up bytes and labels.
inline SetMesh SomeMesh(const std::string& name) {
  return {.name = name,
          .raw = Sha256::Of(name),
          .size_bytes = 5'000'000'000,
          .labels = {{"person", "p \"1\""}, {"věk", "33"}}};
}

inline IngestedMesh SomeIngested(const std::string& name) {
  IngestedMesh mesh;
  mesh.blob = Sha256::Of("canonical " + name);
  mesh.vertices = 5120;
  mesh.faces = 10'000;
  mesh.centroid = {1.0 / 3, -2e-300, 4};
  mesh.health.vertices = 5121;
  mesh.health.boundary_share = 0.1;
  mesh.health.warnings = {"4 components; the largest has 97 % of faces"};
  return mesh;
}

inline Job SomeJob(const std::string& set) {
  Job job;
  job.set = set;
  job.spec.rounds = 7;
  job.spec.base = "b.ply";
  job.plan_version = 5;
  job.results_version = 6;
  return job;
}

inline TaskRecord SomeTask(int64_t number) {
  TaskRecord task;
  task.number = number;
  task.epoch = 3'000'000'000;
  task.failures = 1;
  task.losses = 2;
  task.worker = "host-12-ab";
  task.last_error = "mesh 'x': no\nfaces";
  task.given_up = number % 2 == 1;
  return task;
}

inline TaskResult SomeResult() {
  TaskResult result;
  result.output = Sha256::Of("output");
  result.ingested = {SomeIngested("a"), SomeIngested("b")};
  result.ingested[1].index = 1;
  result.rejections = {{2, "NaN"}};
  result.counters.align.lookups = 123'456'789'012;
  result.seconds = 0.1;
  return result;
}

inline absl::Status SaveTasks(Catalog& catalog,
                              const JobId& job,
                              const std::vector<TaskRecord>& records) {
  std::vector<JobTask> tasks;
  tasks.reserve(records.size());
  for (const TaskRecord& record : records) {
    tasks.push_back({.job = job, .task = record});
  }
  return catalog.SaveTasks(tasks, {});
}

inline absl::StatusOr<std::vector<TaskRecord>> LoadTasks(Catalog& catalog, const JobId& job) {
  std::vector<TaskRecord> records;
  const absl::Status status = catalog.VisitTasks(job, [&](const TaskRecord& record) {
    records.push_back(record);
    return absl::OkStatus();
  });
  if (!status.ok()) {
    return status;
  }
  return records;
}

/// Runs SQL on a file of SQLite, without a catalog.
/// @param vfs  SQLite's default leaves the pages that it writes without checksums.
inline void RunSql(const std::string& file, const std::string& sql, const char* vfs = "unix") {
  sqlite3* database = nullptr;
  ASSERT_EQ(
      sqlite3_open_v2(file.c_str(), &database, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, vfs),
      SQLITE_OK);
  EXPECT_EQ(sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK)
      << sqlite3_errmsg(database);
  sqlite3_close(database);
}

/// Makes `file` a catalog of version 1, without checksums, as the first build wrote it.
inline void MakeFirstCatalog(const std::string& file) {
  std::ifstream stream(COHORT_SOURCE_DIR "/tests/server/catalog/first_catalog.sql");
  std::ostringstream sql;
  sql << stream.rdbuf();
  ASSERT_GT(sql.str().size(), 1'000u);
  RunSql(file, sql.str());
}

/// A catalog in a file in a folder of its own.
class FileCatalogTest : public ::testing::Test {
 protected:
  [[nodiscard]] std::filesystem::path File() const { return folder_.Path() / "catalog.db"; }
  void Reopen() {
    catalog_.reset();
    catalog_ = Catalog::Open(File()).value();
  }
  /// Runs SQL on the closed catalog behind its back.
  void Tamper(const std::string& sql) const { RunSql(File(), sql, kChecksumVfs); }

  ScratchFolder folder_;
  std::unique_ptr<Catalog> catalog_ = Catalog::Open(File()).value();
};

enum class DatabaseKind { kSqlite, kPostgres };

/// An empty catalog in each database that we support. Skipped where there is no PostgreSQL.
class CatalogTest : public ::testing::TestWithParam<DatabaseKind> {
 protected:
  void SetUp() override {
    if (GetParam() == DatabaseKind::kSqlite) {
      location_ = folder_.Path() / "catalog.db";
    } else if (PostgresCluster& cluster = PostgresCluster::Shared(); cluster.Missing().empty()) {
      location_ = cluster.CreateSchema();
    } else {
      GTEST_SKIP() << cluster.Missing();
    }
    catalog_ = Catalog::Open(location_).value();
  }
  void Reopen() {
    catalog_.reset();
    catalog_ = Catalog::Open(location_).value();
  }

  ScratchFolder folder_;
  std::string location_;
  std::unique_ptr<Catalog> catalog_;
};

/// For INSTANTIATE_TEST_SUITE_P: "On/<suite>.<test>/SQLite" and ".../PostgreSQL".
inline auto EachDatabase() {
  return ::testing::Values(DatabaseKind::kSqlite, DatabaseKind::kPostgres);
}
inline std::string DatabaseName(const ::testing::TestParamInfo<DatabaseKind>& kind) {
  return kind.param == DatabaseKind::kSqlite ? "SQLite" : "PostgreSQL";
}

}  // namespace cohort::testing
