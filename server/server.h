#pragma once

#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include <absl/status/statusor.h>

#include "common/base/clock.h"
#include "common/metrics/metrics_endpoint.h"
#include "common/store/directory_blob_store.h"
#include "server/catalog/catalog.h"
#include "server/catalog/file_lock.h"
#include "server/core/coordinator.h"
#include "server/periodic_task.h"
#include "server/server_options.h"

namespace cohort {

/// The server process's parts, put together: catalog, store, coordinator, gRPC listeners.
class Server {
 public:
  /// Opens the data folder, takes up unfinished jobs and listens.
  /// @return naming the folder or the address and the reason.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<Server>> Start(const ServerOptions& options);
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// As clients can use them: "127.0.0.1:40123", "unix:/run/cohort.sock".
  [[nodiscard]] const std::vector<std::string>& Addresses() const { return addresses_; }

  /// Where http://ADDRESS/metrics is; empty: nowhere.
  [[nodiscard]] std::string MetricsAddress() const {
    return metrics_ == nullptr ? "" : metrics_->Address();
  }

  /// Refuses new calls, lets those under way end (5 s), closes. Called by the destructor if needed.
  void Stop();

 private:
  struct Services;
  Server() = default;
  absl::Status Listen(const ServerOptions& options);
  absl::Status ServeMetrics(const std::string& address);
  void TickUntil(const std::stop_token& stop);

  SystemClock clock_;
  std::unique_ptr<Catalog> catalog_;
  std::optional<FileLock> blobs_lock_;  ///< The catalog keeps others out of itself only.
  std::unique_ptr<DirectoryBlobStore> store_;
  std::unique_ptr<Coordinator> coordinator_;
  std::unique_ptr<Services> services_;
  std::vector<std::string> addresses_;
  std::unique_ptr<PeriodicTask> collecting_;  ///< Garbage.
  std::unique_ptr<MetricsEndpoint> metrics_;
  std::jthread ticking_;  ///< Calls Coordinator::Tick.
};

}  // namespace cohort
