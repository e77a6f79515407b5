#include "server/server_main.h"

#include <exception>
#include <iostream>

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include "common/base/process.h"
#include "common/base/version.h"
#include "server/catalog/backup.h"
#include "server/server.h"

namespace cohort {
namespace {

int Serve(const ServerOptions& options) {
  // Logs go to stderr; stdout is for the addresses.
  spdlog::set_default_logger(spdlog::stderr_color_mt("cohort-server"));
  spdlog::set_level(spdlog::level::from_str(options.log_level));
  BlockStopSignals();
  const absl::StatusOr<std::unique_ptr<Server>> server = Server::Start(options);
  if (!server.ok()) {
    std::cerr << "cohort-server: " << server.status().message() << "\n";
    return server.status().code() == absl::StatusCode::kInvalidArgument ? 2 : 1;
  }
  for (const std::string& address : (*server)->Addresses()) {
    std::cout << "listening on " << address << std::endl;
  }
  if (!(*server)->MetricsAddress().empty()) {
    std::cout << "metrics on http://" << (*server)->MetricsAddress() << "/metrics" << std::endl;
  }
  const int signal = WaitForStopSignal(nullptr, options.exit_with_parent);
  spdlog::info("event=stopping signal={}", signal);
  (*server)->Stop();
  return 0;
}

int BackUp(const ServerOptions& options, const std::string& to) {
  const absl::Status status = BackUpCatalog(options.CatalogLocation(), to);
  if (!status.ok()) {
    std::cerr << "cohort-server backup: " << status.message() << "\n";
    return absl::IsInvalidArgument(status) ? 2 : 1;
  }
  std::cout << "catalog " << options.CatalogLocation() << " is in " << to << "\n";
  return 0;
}

/// What both the server and its backup need to find the catalog.
void AddCatalogOptions(CLI::App& app, ServerOptions& options) {
  app.add_option("--data", options.data_dir, "folder of catalog and blobs")->capture_default_str();
  app.add_option("--catalog", options.catalog,
                 "the catalog, if not DATA/catalog.db: a file on a local disk, or "
                 "postgresql://USER@HOST/DATABASE (password: PGPASSWORD or ~/.pgpass), or "
                 "\"postgresql:dbname=... host=...\"");
}

/// How the blobs are kept.
void AddStoreOptions(CLI::App& app, ServerOptions& options) {
  app.add_option("--gc-age-hours", options.gc_age_hours,
                 "once a day blobs that nothing needs are removed if they are at least that old")
      ->capture_default_str();
  app.add_option("--gc-remember-days", options.gc_remember_days,
                 "for so long, results of tasks are kept for jobs to come, even of deleted jobs")
      ->capture_default_str();
  app.add_option("--min-free-gb", options.min_free_gb,
                 "with less free space for blobs, uploads and new jobs are refused and no task is "
                 "handed out")
      ->capture_default_str();
  app.add_option("--min-free-percent", options.min_free_percent,
                 "the same in percent of the disk; the larger counts")
      ->capture_default_str();
}

}  // namespace

int ServerMain(int argc, char** argv) {
  try {
    CLI::App app(
        "cohort-server: coordinates the alignment and comparison of meshes.\n\n"
        "Example: cohort-server --data /var/lib/cohort --listen 0.0.0.0:7450");
    ServerOptions options;
    app.set_version_flag("--version", std::string(BuildVersion()));
    AddCatalogOptions(app, options);
    app.add_option("--listen", options.listen,
                   "address: HOST:PORT (port 0: a free one) or unix:PATH; may be repeated")
        ->capture_default_str();
    app.add_option("--lease-seconds", options.lease_seconds,
                   "a worker silent for this long loses its tasks")
        ->capture_default_str();
    AddStoreOptions(app, options);
    app.add_option("--port-file", options.port_file, "write the addresses there, one a line");
    app.add_option("--metrics-listen", options.metrics_listen,
                   "serve http://HOST:PORT/metrics to Prometheus (port 0: a free one, printed); "
                   "without authentication [off]");
    app.add_option("--log-level", options.log_level, "debug, info, warn, error or off")
        ->check(CLI::IsMember({"debug", "info", "warn", "error", "off"}))
        ->capture_default_str();
    app.add_option("--exit-with-parent", options.exit_with_parent,
                   "end when this process (the parent) ends")
        ->group("");
    std::string backup_file;
    CLI::App* backup = app.add_subcommand(
        "backup",
        "copies the catalog into a new file, also while a server uses it; then copy DATA/blobs");
    AddCatalogOptions(*backup, options);
    backup->add_option("--to", backup_file, "the new file; never overwritten")->required();
    try {
      app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      return app.exit(error) == 0 ? 0 : 2;
    }
    return backup->parsed() ? BackUp(options, backup_file) : Serve(options);
  } catch (const std::exception& error) {
    std::cerr << "cohort-server: " << error.what() << "\n";
    return 1;
  }
}

}  // namespace cohort
