#pragma once

#include <string>

#include <absl/status/status.h>

namespace cohort {

struct WorkerOptions {
  std::string server = "127.0.0.1:7450";  ///< HOST:PORT or unix:PATH.
  int threads = 0;                        ///< Tasks run at once; 0: one per processor.
  std::string store;       ///< The server's blob folder, if this machine sees it; empty: over gRPC.
  int64_t cache_mb = 256;  ///< Decoded meshes kept in memory.
  std::string cache_dir;   ///< Folder for blobs fetched from the server; empty: none are kept.
  int64_t cache_disk_mb = 4096;  ///< Its limit.
  std::string share_dir;         ///< Folder where workers share packed meshes; empty: they do not.
  int64_t share_mb = 2048;       ///< Its limit.
  std::string name;              ///< Shown in logs; empty: host, process and a random part.
  double drain_seconds = 10;
  std::string metrics_listen;  ///< HOST:PORT of http://HOST:PORT/metrics; empty: none.
  std::string log_level = "info";
  int exit_with_parent = 0;  ///< As in ServerOptions.

  /// @return kInvalidArgument naming the option.
  [[nodiscard]] absl::Status Validate() const;
};

/// Works until SIGINT, SIGTERM or the end of the parent, then drains.
/// @return as WorkerLoop::Run.
[[nodiscard]] absl::Status RunWorker(const WorkerOptions& options);

/// The program cohort-worker.
/// @return exit code: 0 stopped as asked, 1 failed, 2 wrong usage.
int WorkerMain(int argc, char** argv);

}  // namespace cohort
