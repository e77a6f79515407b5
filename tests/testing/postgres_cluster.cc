#include "tests/testing/postgres_cluster.h"

#include <fcntl.h>
#include <grp.h>
#include <libpq-fe.h>
#include <pwd.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <thread>

namespace cohort::testing {
namespace {

namespace fs = std::filesystem;

constexpr int kStartSeconds = 60;

using Connected = std::unique_ptr<PGconn, decltype(&PQfinish)>;

[[noreturn]] void Fail(const std::string& what) {
  std::fprintf(stderr, "PostgresCluster: %s\n", what.c_str());
  std::abort();
}

}  // namespace

PostgresCluster& PostgresCluster::Shared() {
  static PostgresCluster shared;
  return shared;
}

PostgresCluster::PostgresCluster() : user_(::geteuid()), group_(::getegid()) {
  if (!FindPrograms()) {
    return;
  }
  if (user_ == 0) {
    const passwd* postgres = ::getpwnam("postgres");
    if (postgres == nullptr) {
      missing_ = "no user 'postgres', whom PostgreSQL could run as";
      return;
    }
    user_ = postgres->pw_uid;
    group_ = postgres->pw_gid;
  }
  std::string name = (fs::temp_directory_path() / "cohort-pg-XXXXXX").string();
  folder_ = ::mkdtemp(name.data());
  GiveAway(folder_);
  const pid_t initdb =
      Spawn({"initdb", "-D", Data(), "-A", "trust", "-U", "cohort", "-E", "UTF8", "--no-sync",
             "--data-checksums", "--locale=C.UTF-8", "--locale-provider=icu", "--icu-locale=en"});
  int exit_status = -1;
  ::waitpid(initdb, &exit_status, 0);
  if (exit_status != 0) {
    Fail("initdb failed, see " + (folder_ / "log").string());
  }
  Start();
}

PostgresCluster::~PostgresCluster() {
  if (server_ > 0) {
    Stop(SIGQUIT);
  }
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

bool PostgresCluster::FindPrograms() {
  std::error_code error;
  for (const fs::directory_entry& version : fs::directory_iterator("/usr/lib/postgresql", error)) {
    if (fs::exists(version.path() / "bin" / "initdb")) {
      programs_ = std::max(programs_, version.path() / "bin");
    }
  }
  if (programs_.empty()) {
    missing_ = "PostgreSQL is not installed (deploy/install-dependencies.sh --tests does)";
  }
  return !programs_.empty();
}

void PostgresCluster::GiveAway(const fs::path& folder) const {
  if (::chown(folder.c_str(), user_, group_) != 0) {
    Fail("cannot give " + folder.string() + " away");
  }
}

pid_t PostgresCluster::Spawn(const std::vector<std::string>& arguments) const {
  std::vector<std::string> words = arguments;
  words[0] = programs_ / words[0];
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& word : words) {
    argv.push_back(word.data());
  }
  argv.push_back(nullptr);
  const std::string log = folder_ / "log";
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child != 0) {
    return child;
  }
  const bool became_user = ::geteuid() == user_ || (::setgroups(0, nullptr) == 0 &&
                                                    ::setgid(group_) == 0 && ::setuid(user_) == 0);
  // After the change of user, which would undo it.
  ::prctl(PR_SET_PDEATHSIG, SIGQUIT);
  const int fd = ::open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644);
  if (!became_user || ::getppid() != parent || fd < 0 || ::chdir("/") != 0) {
    ::_exit(126);
  }
  ::dup2(fd, STDOUT_FILENO);
  ::dup2(fd, STDERR_FILENO);
  ::execv(argv[0], argv.data());
  ::_exit(127);
}

void PostgresCluster::Start() {
  server_ = Spawn({"postgres", "-D", Data(), "-k", folder_, "-c", "listen_addresses=", "-c",
                   "shared_buffers=16MB", "-c", "max_connections=20", "-c", "autovacuum=off", "-c",
                   "recovery_init_sync_method=syncfs"});
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(kStartSeconds);
  while (PQping(Connection("postgres").c_str()) != PQPING_OK) {
    if (std::chrono::steady_clock::now() > deadline) {
      Fail("the server does not start, see " + (folder_ / "log").string());
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

void PostgresCluster::Stop(int signal) {
  ::kill(server_, signal);
  ::waitpid(server_, nullptr, 0);
  server_ = -1;
}

void PostgresCluster::Crash() {
  Stop(SIGQUIT);
  Start();
}

std::string PostgresCluster::Connection(const std::string& database) const {
  return "host=" + folder_.string() + " user=cohort dbname=" + database;
}

std::string PostgresCluster::CreateDatabase(const std::string& options) {
  std::string name("t");
  name += std::to_string(++databases_);
  Run("CREATE DATABASE " + name + " " + options);
  return "postgresql:" + Connection(name);
}

std::string PostgresCluster::CreateSchema() {
  std::string name("s");
  name += std::to_string(++schemas_);
  Run("CREATE SCHEMA " + name);
  return "postgresql:" + Connection("postgres") + " options=-csearch_path=" + name;
}

void PostgresCluster::Run(const std::string& sql, const std::string& location) const {
  static_cast<void>(Ask(sql, location));
}

std::string PostgresCluster::Ask(const std::string& sql, const std::string& location) const {
  const std::string where =
      location.empty() ? Connection("postgres") : location.substr(location.find(':') + 1);
  const Connected connection(PQconnectdb(where.c_str()), &PQfinish);
  const std::unique_ptr<PGresult, decltype(&PQclear)> result(PQexec(connection.get(), sql.c_str()),
                                                             &PQclear);
  const ExecStatusType status = PQresultStatus(result.get());
  if (status != PGRES_COMMAND_OK && status != PGRES_TUPLES_OK) {
    Fail(sql + ": " + PQerrorMessage(connection.get()));
  }
  return PQntuples(result.get()) > 0 ? PQgetvalue(result.get(), 0, 0) : "";
}

}  // namespace cohort::testing
