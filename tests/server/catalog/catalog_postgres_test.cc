// What the catalog does about its PostgreSQL server: locks, lost connections, set-up, damage.

#include <sys/mount.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/catalog/catalog.h"
#include "server/catalog/schema.h"
#include "tests/server/catalog/catalog_fixture.h"

namespace cohort {
namespace {

namespace fs = std::filesystem;

using testing::IsOk;
using testing::PostgresCluster;
using testing::SmallDisk;
using testing::SomeMesh;
using testing::StatusIs;

class PostgreSQLTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!cluster_.Missing().empty()) {
      GTEST_SKIP() << cluster_.Missing();
    }
    location_ = cluster_.CreateDatabase();
    catalog_ = Catalog::Open(location_).value();
  }
  /// Ends every connection to the database as an administrator or a broken network does.
  void CutConnections() const {
    cluster_.Run("SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE datname = '" +
                 DatabaseOf(location_) + "'");
  }
  static std::string DatabaseOf(const std::string& location) {
    return location.substr(location.rfind('=') + 1);
  }

  PostgresCluster& cluster_ = PostgresCluster::Shared();
  std::string location_;
  std::unique_ptr<Catalog> catalog_;
};

TEST_F(PostgreSQLTest, IsRefusedToASecondServer) {
  EXPECT_THAT(
      Catalog::Open(location_),
      StatusIs(absl::StatusCode::kFailedPrecondition,
               "another cohort-server uses PostgreSQL database '" + DatabaseOf(location_) + "'"));

  catalog_.reset();
  EXPECT_THAT(Catalog::Open(location_), IsOk());
}

TEST_F(PostgreSQLTest, IsRefusedToASecondProcess) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::_exit(absl::IsFailedPrecondition(Catalog::Open(location_).status()) ? 0 : 1);
  }
  int exit_status = -1;
  ASSERT_EQ(::waitpid(child, &exit_status, 0), child);

  EXPECT_EQ(exit_status, 0);
}

TEST_F(PostgreSQLTest, FailsTheCallThatLosesTheConnectionAndConnectsForTheNext) {
  ASSERT_THAT(catalog_->AddMesh("s", SomeMesh("a")), IsOk());
  CutConnections();

  EXPECT_THAT(catalog_->AddMesh("s", SomeMesh("b")),
              StatusIs(absl::StatusCode::kUnavailable, DatabaseOf(location_)));

  EXPECT_THAT(catalog_->AddMesh("s", SomeMesh("c")), IsOk());
  EXPECT_EQ(catalog_->ListMeshes("s", 9, "")->items.size(), 2u);
  EXPECT_THAT(Catalog::Open(location_),
              StatusIs(absl::StatusCode::kFailedPrecondition, "another cohort-server"));
}

TEST_F(PostgreSQLTest, GoesOnWhenItsServerWasAway) {
  ASSERT_THAT(catalog_->AddMesh("s", SomeMesh("a")), IsOk());
  cluster_.Stop(SIGQUIT);
  EXPECT_THAT(catalog_->AddMesh("s", SomeMesh("b")), StatusIs(absl::StatusCode::kUnavailable, ""));
  EXPECT_THAT(catalog_->AddMesh("s", SomeMesh("b")), StatusIs(absl::StatusCode::kUnavailable, ""));
  cluster_.Start();

  EXPECT_THAT(catalog_->AddMesh("s", SomeMesh("b")), IsOk());
  EXPECT_EQ(catalog_->ListMeshes("s", 9, "")->items.size(), 2u);
}

TEST_F(PostgreSQLTest, IsLostForGoodToAServerThatAnotherOneReplaced) {
  CutConnections();
  {
    const auto other = Catalog::Open(location_);
    ASSERT_THAT(other, IsOk());
    ASSERT_THAT((*other)->AddMesh("s", SomeMesh("of the other")), IsOk());
    EXPECT_THAT(catalog_->AddMesh("s", SomeMesh("a")),
                StatusIs(absl::StatusCode::kUnavailable, ""));  // Learns that it was cut off.
    EXPECT_THAT(catalog_->AddMesh("s", SomeMesh("a")),
                StatusIs(absl::StatusCode::kFailedPrecondition, "another cohort-server uses"));
  }

  // The other one is gone, but what it did is not known here.
  EXPECT_THAT(catalog_->AddMesh("s", SomeMesh("a")),
              StatusIs(absl::StatusCode::kFailedPrecondition, "this one must end"));
  EXPECT_THAT(catalog_->ListSets(9, ""),
              StatusIs(absl::StatusCode::kFailedPrecondition, "this one must end"));
  catalog_.reset();
  EXPECT_EQ(Catalog::Open(location_).value()->ListMeshes("s", 9, "")->items.size(), 1u);
}

TEST_F(PostgreSQLTest, RefusesANewerVersionUnchanged) {
  catalog_.reset();
  cluster_.Run("UPDATE cohort_meta SET value = '1000' WHERE name = 'version'", location_);
  const std::string owner =
      cluster_.Ask("SELECT value FROM cohort_meta WHERE name = 'owner'", location_);

  EXPECT_THAT(Catalog::Open(location_),
              StatusIs(absl::StatusCode::kFailedPrecondition, "has version 1000"));

  EXPECT_EQ(cluster_.Ask("SELECT value FROM cohort_meta WHERE name = 'owner'", location_), owner);
}

TEST_F(PostgreSQLTest, TakesAnOlderVersionFurther) {
  ASSERT_THAT(catalog_->AddMesh("s", SomeMesh("a")), IsOk());
  catalog_.reset();
  // What the migrations since version 1 made.
  cluster_.Run(
      "DROP TABLE action; ALTER TABLE task DROP COLUMN given_up; "
      "ALTER TABLE job DROP COLUMN plan_version, DROP COLUMN results_version",
      location_);
  cluster_.Run("UPDATE cohort_meta SET value = '1' WHERE name = 'version'", location_);

  catalog_ = Catalog::Open(location_).value();

  EXPECT_THAT(catalog_->FindActions({"k"}), IsOk());
  EXPECT_EQ(catalog_->ListMeshes("s", 9, "")->items.size(), 1u);
  EXPECT_EQ(cluster_.Ask("SELECT value FROM cohort_meta WHERE name = 'version'", location_),
            std::to_string(SchemaMigrations().size()));
}

TEST_F(PostgreSQLTest, RefusesADatabaseOfAnotherProgram) {
  const std::string other = cluster_.CreateDatabase();
  cluster_.Run("CREATE TABLE invoices (number INT)", other);

  EXPECT_THAT(Catalog::Open(other), StatusIs(absl::StatusCode::kDataLoss, "not a catalog"));

  EXPECT_EQ(cluster_.Ask("SELECT COUNT(*) FROM pg_tables WHERE schemaname = 'public'", other), "1");
}

TEST_F(PostgreSQLTest, RefusesAnEncodingThatCannotHoldAllNames) {
  const std::string latin = cluster_.CreateDatabase(
      "TEMPLATE template0 ENCODING 'LATIN1' LOCALE 'C' "
      "LOCALE_PROVIDER libc");

  EXPECT_THAT(Catalog::Open(latin),
              StatusIs(absl::StatusCode::kFailedPrecondition, "encoding is LATIN1"));
}

TEST_F(PostgreSQLTest, SaysWhyALocationCannotBeUsed) {
  EXPECT_THAT(Catalog::Open("postgresql:dbnam=x"),
              StatusIs(absl::StatusCode::kInvalidArgument, "dbnam"));
  EXPECT_THAT(Catalog::Open("postgresql://u:secret@[::1/x"),
              StatusIs(absl::StatusCode::kInvalidArgument, "catalog location of PostgreSQL"));
  const absl::Status refused =
      Catalog::Open("postgresql://u:secret@localhost:1/x?connect_timeout=2").status();
  EXPECT_THAT(refused,
              StatusIs(absl::StatusCode::kUnavailable, "PostgreSQL database 'x' on 'localhost'"));
  EXPECT_THAT(refused, StatusIs(absl::StatusCode::kUnavailable, "refused"));
  EXPECT_EQ(std::string(refused.message()).find("secret"), std::string::npos);
  EXPECT_THAT(Catalog::Open(location_ + "x"),
              StatusIs(absl::StatusCode::kUnavailable, "not exist"));
}

TEST_F(PostgreSQLTest, TakesAUriToo) {
  const std::string folder = cluster_.Data().parent_path();
  std::string uri = "postgresql://cohort@/" + DatabaseOf(location_) + "?host=" + folder;
  catalog_.reset();

  EXPECT_THAT(Catalog::Open(uri), IsOk());
  EXPECT_THAT(Catalog::Open("postgres" + uri.substr(uri.find(':'))), IsOk());
}

TEST_F(PostgreSQLTest, SaysWhenItsDiskIsFullAndGoesOnWhenThereIsSpace) {
  const SmallDisk disk("12m");  // A new database has 8 MB of its own.
  if (!disk.Mounted()) {
    GTEST_SKIP() << "cannot mount a small disk: not root";
  }
  const fs::path folder = disk.Path() / "space";
  fs::create_directory(folder);
  cluster_.GiveAway(folder);
  cluster_.Run("CREATE TABLESPACE small LOCATION '" + folder.string() + "'");
  const std::string location = cluster_.CreateDatabase("TABLESPACE small");
  {
    const std::unique_ptr<Catalog> catalog = Catalog::Open(location).value();
    int added = 0;
    absl::Status status;
    while (status.ok() && added < 10'000) {
      SetMesh mesh = SomeMesh(std::to_string(added));
      for (int i = 0; i < 100; ++i) {
        mesh.labels["note"] += Sha256::Of(std::to_string(added * 100 + i)).Hex();
      }
      status = catalog->AddMesh("s", mesh);
      added += status.ok() ? 1 : 0;
    }
    EXPECT_THAT(status, StatusIs(absl::StatusCode::kResourceExhausted, DatabaseOf(location)));
    EXPECT_THAT(status, StatusIs(absl::StatusCode::kResourceExhausted, "No space left"));
    // To read now may fail, too: PostgreSQL makes room in memory by writing.

    ASSERT_EQ(::mount("tmpfs", disk.Path().c_str(), "tmpfs", MS_REMOUNT, "size=64m"), 0);
    EXPECT_THAT(catalog->AddMesh("s", SomeMesh("one more")), IsOk());
    EXPECT_EQ(catalog->ListSets(1, "")->items[0].meshes, added + 1);
  }
  cluster_.Run("DROP DATABASE " + DatabaseOf(location));
  cluster_.Run("DROP TABLESPACE small");
}

TEST_F(PostgreSQLTest, TellsAFlippedBitInATable) {
  ASSERT_THAT(catalog_->AddMesh("s", SomeMesh("findme")), IsOk());
  catalog_.reset();
  const fs::path table =
      cluster_.Data() / cluster_.Ask("SELECT pg_relation_filepath('mesh')", location_);
  cluster_.Stop(SIGINT);  // In order, with a checkpoint.
  std::ifstream stream(table, std::ios::binary);
  std::ostringstream content;
  content << stream.rdbuf();
  const size_t at = content.str().find("findme");
  ASSERT_NE(at, std::string::npos);
  std::fstream file(table, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(static_cast<int64_t>(at));
  file.put('F');
  file.close();
  cluster_.Start();

  catalog_ = Catalog::Open(location_).value();

  EXPECT_THAT(catalog_->ListMeshes("s", 9, ""),
              StatusIs(absl::StatusCode::kDataLoss, "invalid page"));
}

}  // namespace
}  // namespace cohort
