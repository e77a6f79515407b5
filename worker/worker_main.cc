#include "worker/worker_main.h"

#include <malloc.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <memory>
#include <optional>
#include <random>
#include <thread>

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <CLI/CLI.hpp>

#include "common/base/clock.h"
#include "common/base/process.h"
#include "common/base/status_macros.h"
#include "common/base/version.h"
#include "common/geometry/nearest/instruction_set.h"
#include "common/jobs/worker_build.h"
#include "common/metrics/metrics_endpoint.h"
#include "common/rpc/channel.h"
#include "common/rpc/rpc_blob_store.h"
#include "common/store/caching_blob_store.h"
#include "common/store/directory_blob_store.h"
#include "common/store/retrying_blob_store.h"
#include "common/store/shared_folder.h"
#include "worker/grpc_coordinator_link.h"
#include "worker/worker_loop.h"
#include "worker/worker_metrics.h"

namespace cohort {
namespace {

constexpr int kWedgedExitCode = 75;  // EX_TEMPFAIL: to be started again.
constexpr int kKeptArrayBytes = 64 << 20;
constexpr int kKeptBytes = 256 << 20;

/// A task needs arrays as large as the one before it: they are not given back to the kernel in
/// between, which would have to clear them again.
void KeepFreedMemory() {
  ::mallopt(M_MMAP_THRESHOLD, kKeptArrayBytes);  // Where not kept, a task is slower; no more.
  ::mallopt(M_TRIM_THRESHOLD, kKeptBytes);
}

/// Unique in practice: host, process, and a random part for reused process numbers.
std::string MakeWorkerName() {
  std::array<char, 256> host{};
  gethostname(host.data(), host.size() - 1);
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::random_device random;
  std::string suffix;
  for (int i = 0; i < 6; ++i) {
    suffix.push_back(kDigits[random() % kDigits.size()]);
  }
  return std::string(host.data()) + "-" + std::to_string(getpid()) + "-" + suffix;
}

absl::StatusOr<std::unique_ptr<BlobStore>> OpenStore(const WorkerOptions& options,
                                                     const std::shared_ptr<grpc::Channel>& channel,
                                                     const std::string& address,
                                                     const std::stop_token& stop) {
  if (options.store.empty()) {
    auto rpc = std::make_unique<RetryingBlobStore>(std::make_unique<RpcBlobStore>(channel, address),
                                                   Patience(), stop);
    if (options.cache_dir.empty()) {
      return rpc;
    }
    COHORT_ASSIGN_OR_RETURN(std::unique_ptr<CachingBlobStore> cache,
                            CachingBlobStore::Create(std::move(rpc), options.cache_dir,
                                                     options.cache_disk_mb * 1'000'000));
    return cache;
  }
  COHORT_ASSIGN_OR_RETURN(std::unique_ptr<DirectoryBlobStore> store,
                          DirectoryBlobStore::Create(options.store));
  return store;
}

CLI::App* AddOptions(CLI::App& app, WorkerOptions& options) {
  app.set_version_flag("--version", std::string(BuildVersion()));
  app.add_option("--server", options.server, "address of cohort-server: HOST:PORT or unix:PATH")
      ->capture_default_str();
  app.add_option("--threads", options.threads, "tasks run at once; 0: one per processor")
      ->capture_default_str();
  app.add_option("--store", options.store,
                 "the server's blob folder (DATA/blobs), if this machine sees it; saves the way "
                 "over the network");
  app.add_option("--cache-mb", options.cache_mb, "decoded meshes kept in memory")
      ->capture_default_str();
  app.add_option("--cache-dir", options.cache_dir,
                 "keep blobs fetched from the server in this folder, also for the next worker; "
                 "several workers may share it");
  app.add_option("--cache-disk-mb", options.cache_disk_mb,
                 "how much of them; the least recently read go first")
      ->capture_default_str();
  app.add_option(
      "--share-dir", options.share_dir,
      "share meshes that are ready to be compared with the other workers of this machine "
      "in this folder; best in memory (/dev/shm)");
  app.add_option("--share-mb", options.share_mb,
                 "how much of them; the least recently used go first")
      ->capture_default_str();
  app.add_option("--name", options.name, "name in logs; must be unique");
  app.add_option("--drain-seconds", options.drain_seconds,
                 "how long running tasks may go on after SIGTERM")
      ->capture_default_str();
  app.add_option("--metrics-listen", options.metrics_listen,
                 "serve http://HOST:PORT/metrics to Prometheus (port 0: a free one, printed); "
                 "without authentication [off]");
  app.add_option("--log-level", options.log_level, "debug, info, warn, error or off")
      ->check(CLI::IsMember({"debug", "info", "warn", "error", "off"}))
      ->capture_default_str();
  app.add_option("--exit-with-parent", options.exit_with_parent,
                 "end when this process (the parent) ends")
      ->group("");
  return &app;
}

}  // namespace

absl::Status WorkerOptions::Validate() const {
  if (threads < 0 || threads > 1024) {
    return absl::InvalidArgumentError("--threads " + std::to_string(threads) +
                                      ": expected 0 to 1024");
  }
  if (cache_mb < 0) {
    return absl::InvalidArgumentError("--cache-mb must not be negative");
  }
  if (!cache_dir.empty() && !store.empty()) {
    return absl::InvalidArgumentError(
        "--cache-dir: of no use with --store, which is read directly");
  }
  if (cache_disk_mb < 1 || cache_disk_mb > 1'000'000'000) {
    return absl::InvalidArgumentError("--cache-disk-mb " + std::to_string(cache_disk_mb) +
                                      ": expected 1 to 1000000000");
  }
  if (share_mb < 1 || share_mb > 1'000'000'000) {
    return absl::InvalidArgumentError("--share-mb " + std::to_string(share_mb) +
                                      ": expected 1 to 1000000000");
  }
  if (!(drain_seconds >= 0 && drain_seconds <= 86400)) {
    return absl::InvalidArgumentError("--drain-seconds: expected 0 to 86400");
  }
  if (!metrics_listen.empty()) {
    COHORT_RETURN_IF_ERROR(MetricsEndpoint::CheckAddress(metrics_listen));
  }
  return NormalizeAddress(server).status();
}

absl::Status RunWorker(const WorkerOptions& options) {
  COHORT_RETURN_IF_ERROR(options.Validate());
  COHORT_ASSIGN_OR_RETURN(const InstructionSet instruction_set, ChooseInstructionSet());
  COHORT_ASSIGN_OR_RETURN(const std::string address, NormalizeAddress(options.server));
  const std::shared_ptr<grpc::Channel> channel = OpenChannel(address);
  std::stop_source stop;
  COHORT_ASSIGN_OR_RETURN(const std::unique_ptr<BlobStore> store,
                          OpenStore(options, channel, address, stop.get_token()));
  std::unique_ptr<SharedFolder> folder;
  std::optional<SharedMeshes> shared;
  if (!options.share_dir.empty()) {
    COHORT_ASSIGN_OR_RETURN(folder,
                            SharedFolder::Create(options.share_dir, options.share_mb * 1'000'000));
    shared.emplace(*folder);
  }
  MeshCache meshes(*store, options.cache_mb << 20, shared ? &*shared : nullptr);
  GrpcCoordinatorLink link(channel, address);
  WorkerLoopOptions loop_options;
  loop_options.worker = WorkerId{options.name.empty() ? MakeWorkerName() : options.name};
  loop_options.build = WorkerBuild();
  const int processors = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  loop_options.slots = options.threads > 0 ? options.threads : processors;
  loop_options.instruction_set = InstructionSetName(instruction_set);
  loop_options.drain_seconds = options.drain_seconds;
  TaskRunner runner(*store, meshes, loop_options.slots);
  spdlog::info("event=worker_started worker={} server={} slots={} store={} isa={}",
               loop_options.worker.value, address, loop_options.slots,
               options.store.empty() ? "rpc" : options.store, InstructionSetName(instruction_set));
  WorkerLoop loop(loop_options, link, runner);
  std::unique_ptr<MetricsEndpoint> metrics;
  if (!options.metrics_listen.empty()) {
    const double start =
        std::chrono::duration<double>(SystemClock().WallNow().time_since_epoch()).count();
    COHORT_ASSIGN_OR_RETURN(
        metrics, MetricsEndpoint::Listen(options.metrics_listen, [&loop, &meshes, start] {
          return MakeWorkerPage(loop.Figures(), meshes.Bytes(), start);
        }));
    std::cout << "metrics on http://" << metrics->Address() << "/metrics" << std::endl;
  }
  std::atomic<bool> ended = false;
  absl::Status status;
  std::thread working([&] {
    status = loop.Run(stop.get_token());
    if (absl::IsAborted(status)) {
      // A thread of ours cannot be stopped: not even destructors may wait for it.
      spdlog::critical("event=worker_wedged worker={} error=\"{}\"", loop_options.worker.value,
                       std::string(status.message()));
      spdlog::shutdown();
      std::_Exit(kWedgedExitCode);
    }
    ended = true;
  });
  const int signal = WaitForStopSignal(&ended, options.exit_with_parent);
  spdlog::info("event=worker_stopping worker={} signal={}", loop_options.worker.value, signal);
  stop.request_stop();
  working.join();
  return status;
}

int WorkerMain(int argc, char** argv) {
  try {
    CLI::App app(
        "cohort-worker: does the tasks of a cohort-server.\n\n"
        "Example: cohort-worker --server coordinator:7450 --threads 16");
    WorkerOptions options;
    AddOptions(app, options);
    try {
      app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      return app.exit(error) == 0 ? 0 : 2;
    }
    spdlog::set_default_logger(spdlog::stderr_color_mt("cohort-worker"));
    spdlog::set_level(spdlog::level::from_str(options.log_level));
    BlockStopSignals();
    KeepFreedMemory();
    const absl::Status status = RunWorker(options);
    if (!status.ok()) {
      std::cerr << "cohort-worker: " << status.message() << "\n";
      return status.code() == absl::StatusCode::kInvalidArgument ? 2 : 1;
    }
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "cohort-worker: " << error.what() << "\n";
    return 1;
  }
}

}  // namespace cohort
