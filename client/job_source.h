#pragma once

#include <memory>
#include <string>

#include <absl/status/statusor.h>
#include <CLI/CLI.hpp>

#include "client/commands/command.h"
#include "client/local_cluster.h"
#include "client/session.h"

namespace cohort {

/// A job that a command reads, and the connection to its server.
struct OpenedJob {
  std::unique_ptr<LocalCluster> cluster;  ///< Only of a folder: its server, without workers.
  std::unique_ptr<Session> session;
  std::unique_ptr<BlobStore> store;  ///< Only of a folder: its blobs, read without the server.
  JobId id;

  [[nodiscard]] BlobStore& Blobs() const { return store ? *store : session->Blobs(); }
};

/// Where a command finds the job it is about: on a server, or in the folder of a `cohort run
/// --keep-data`, on whose data a server is started for as long as the command runs.
struct JobSource {
  ServerFlags server;
  std::string job;  ///< Job id or folder of results.

  /// Adds the argument "job" and ServerFlags.
  void AddTo(CLI::App& command);
  /// @return kFailedPrecondition naming the folder if it has no data; as LocalCluster::Start and
  ///         Session::Open.
  [[nodiscard]] absl::StatusOr<OpenedJob> Open() const;
};

}  // namespace cohort
