#include "server/server.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <utility>

#include <grpcpp/ext/proto_server_reflection_plugin.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/health_check_service_interface.h>
#include <spdlog/spdlog.h>

#include "common/base/status_macros.h"
#include "common/jobs/worker_build.h"
#include "common/rpc/channel.h"
#include "server/metrics/server_metrics.h"
#include "server/services/admin_service.h"
#include "server/services/blob_service.h"
#include "server/services/job_service.h"
#include "server/services/mesh_service.h"
#include "server/services/result_service.h"
#include "server/services/worker_service.h"

namespace cohort {
namespace {

constexpr std::chrono::seconds kDrainTime(5);
constexpr std::chrono::seconds kTickTime(1);
constexpr std::chrono::minutes kFirstCollection(10);
constexpr std::chrono::hours kCollectionTime(24);
constexpr double kOldUploadSeconds = 24 * 3600;

void SetUp(grpc::ServerBuilder& builder) {
  builder.SetMaxReceiveMessageSize(kMaxMessageBytes);
  builder.SetMaxSendMessageSize(kMaxMessageBytes);
  // Two servers on one port would share its connections at random.
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIME_MS, 30'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 10'000);
  builder.AddChannelArgument(GRPC_ARG_HTTP2_MIN_RECV_PING_INTERVAL_WITHOUT_DATA_MS, 10'000);
  builder.AddChannelArgument(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
}

/// "HOST:0" with the port that was found.
std::string BoundAddress(const std::string& address, int port) {
  if (address.rfind("unix:", 0) == 0) {
    return address;
  }
  return address.substr(0, address.rfind(':') + 1) + std::to_string(port);
}

absl::Status WritePortFile(const std::string& path, const std::vector<std::string>& addresses) {
  // Written aside and renamed: a reader never sees half a file.
  const std::string aside = path + ".new";
  std::ofstream file(aside);
  for (const std::string& address : addresses) {
    file << address << '\n';
  }
  file.close();
  std::error_code error;
  if (file) {
    std::filesystem::rename(aside, path, error);
  }
  if (!file || error) {
    return absl::UnavailableError("--port-file " + path + " cannot be written");
  }
  return absl::OkStatus();
}

}  // namespace

struct Server::Services {
  explicit Services(Coordinator& coordinator)
      : mesh(coordinator),
        job(coordinator, hub),
        result(coordinator),
        blob(coordinator),
        worker(coordinator),
        admin(coordinator) {
    coordinator.SetObserver(&hub);
  }
  JobWatchHub hub;
  MeshServiceSkin mesh;
  JobServiceSkin job;
  ResultServiceSkin result;
  BlobServiceSkin blob;
  WorkerServiceSkin worker;
  AdminServiceSkin admin;
  std::unique_ptr<grpc::Server> grpc_server;
};

absl::Status ServerOptions::Validate() const {
  if (listen.empty()) {
    return absl::InvalidArgumentError("--listen: at least one address is needed");
  }
  for (const std::string& address : listen) {
    COHORT_RETURN_IF_ERROR(NormalizeAddress(address).status());
  }
  if (!std::isfinite(lease_seconds) || lease_seconds < 1 || lease_seconds > 3600) {
    return absl::InvalidArgumentError("--lease-seconds " + std::to_string(lease_seconds) +
                                      ": expected 1 to 3600");
  }
  if (!(gc_age_hours >= 1) || !(gc_age_hours <= 24 * 365)) {
    return absl::InvalidArgumentError("--gc-age-hours " + std::to_string(gc_age_hours) +
                                      ": expected 1 to 8760");
  }
  if (!(gc_remember_days >= 0) || !(gc_remember_days <= 36500)) {
    return absl::InvalidArgumentError("--gc-remember-days " + std::to_string(gc_remember_days) +
                                      ": expected 0 to 36500");
  }
  if (!(min_free_gb >= 0) || !(min_free_gb <= 1e6)) {
    return absl::InvalidArgumentError("--min-free-gb " + std::to_string(min_free_gb) +
                                      ": expected 0 to 1000000");
  }
  if (!(min_free_percent >= 0) || !(min_free_percent <= 90)) {
    return absl::InvalidArgumentError("--min-free-percent " + std::to_string(min_free_percent) +
                                      ": expected 0 to 90");
  }
  return metrics_listen.empty() ? absl::OkStatus() : MetricsEndpoint::CheckAddress(metrics_listen);
}

absl::StatusOr<std::unique_ptr<Server>> Server::Start(const ServerOptions& options) {
  COHORT_RETURN_IF_ERROR(options.Validate());
  std::error_code error;
  std::filesystem::create_directories(options.data_dir, error);
  if (error) {
    return absl::UnavailableError("data folder " + options.data_dir +
                                  " cannot be created: " + error.message());
  }
  std::unique_ptr<Server> server(new Server());
  const std::filesystem::path data = options.data_dir;
  COHORT_ASSIGN_OR_RETURN(server->catalog_, Catalog::Open(options.CatalogLocation()));
  COHORT_ASSIGN_OR_RETURN(FileLock lock, FileLock::Acquire(data / "blobs"));
  server->blobs_lock_.emplace(std::move(lock));
  COHORT_ASSIGN_OR_RETURN(server->store_, DirectoryBlobStore::Create(data / "blobs"));
  COHORT_RETURN_IF_ERROR(server->store_->SweepIncoming(kOldUploadSeconds));
  CoordinatorOptions core;
  core.scheduler.lease_seconds = options.lease_seconds;
  core.build = WorkerBuild();
  core.garbage = {.age_seconds = options.gc_age_hours * 3600,
                  .remember_seconds = options.gc_remember_days * 24 * 3600};
  core.reserve = {.bytes = static_cast<int64_t>(options.min_free_gb * 1e9),
                  .share = options.min_free_percent / 100};
  COHORT_ASSIGN_OR_RETURN(
      server->coordinator_,
      Coordinator::Create(core, *server->catalog_, *server->store_, server->clock_));
  server->services_ = std::make_unique<Services>(*server->coordinator_);
  COHORT_RETURN_IF_ERROR(server->Listen(options));
  if (!options.metrics_listen.empty()) {
    COHORT_RETURN_IF_ERROR(server->ServeMetrics(options.metrics_listen));
  }
  server->ticking_ =
      std::jthread([raw = server.get()](const std::stop_token& stop) { raw->TickUntil(stop); });
  server->collecting_ = std::make_unique<PeriodicTask>(
      kFirstCollection, kCollectionTime, [raw = server.get()](const std::stop_token& stop) {
        const auto collected =
            raw->coordinator_->CollectGarbage(raw->coordinator_->Options().garbage, stop);
        if (!collected.ok()) {
          spdlog::error("event=garbage_not_collected error=\"{}\"",
                        std::string(collected.status().message()));
        }
      });
  return server;
}

absl::Status Server::Listen(const ServerOptions& options) {
  KeepGrpcRunning();
  grpc::EnableDefaultHealthCheckService(true);
  grpc::reflection::InitProtoReflectionServerBuilderPlugin();
  grpc::ServerBuilder builder;
  SetUp(builder);
  std::vector<int> ports(options.listen.size(), 0);
  std::vector<std::string> normalized;
  for (size_t i = 0; i < options.listen.size(); ++i) {
    COHORT_ASSIGN_OR_RETURN(const std::string address, NormalizeAddress(options.listen[i]));
    builder.AddListeningPort(address, grpc::InsecureServerCredentials(), &ports[i]);
    normalized.push_back(address);
  }
  if (std::all_of(normalized.begin(), normalized.end(), IsLocalSocket)) {
    builder.AddChannelArgument(GRPC_ARG_HTTP2_BDP_PROBE, 0);
  }
  builder.RegisterService(&services_->mesh);
  builder.RegisterService(&services_->job);
  builder.RegisterService(&services_->result);
  builder.RegisterService(&services_->blob);
  builder.RegisterService(&services_->worker);
  builder.RegisterService(&services_->admin);
  services_->grpc_server = builder.BuildAndStart();
  for (size_t i = 0; i < ports.size(); ++i) {
    if (services_->grpc_server == nullptr || ports[i] == 0) {
      return absl::UnavailableError("cannot listen on " + normalized[i] +
                                    ": is another server using it?");
    }
    addresses_.push_back(BoundAddress(normalized[i], ports[i]));
    spdlog::info("event=listening address={}", addresses_.back());
  }
  return options.port_file.empty() ? absl::OkStatus()
                                   : WritePortFile(options.port_file, addresses_);
}

absl::Status Server::ServeMetrics(const std::string& address) {
  const double start = std::chrono::duration<double>(clock_.WallNow().time_since_epoch()).count();
  const auto read = [this, start] {
    ServerState state{.start_unix_seconds = start, .store_free_bytes = std::nullopt};
    if (const absl::StatusOr<StoreSpace> space = store_->Space(); space.ok()) {
      state.store_free_bytes = space->free_bytes;
    }
    return MakeServerPage(coordinator_->Figures(), state);
  };
  COHORT_ASSIGN_OR_RETURN(metrics_, MetricsEndpoint::Listen(address, read));
  spdlog::info("event=metrics address=http://{}/metrics", metrics_->Address());
  return absl::OkStatus();
}

void Server::TickUntil(const std::stop_token& stop) {
  Mutex mutex;
  CondVar stopped;
  const std::stop_callback wake(stop, [&] {
    const MutexLock lock(mutex);
    stopped.NotifyAll();
  });
  while (!stop.stop_requested()) {
    const absl::Status status = coordinator_->Tick();
    if (!status.ok()) {
      spdlog::error("event=tick_failed error=\"{}\"", std::string(status.message()));
    }
    const MutexLock lock(mutex);
    if (!stop.stop_requested()) {
      stopped.WaitUntil(mutex, std::chrono::steady_clock::now() + kTickTime);
    }
  }
}

void Server::Stop() {
  metrics_.reset();
  collecting_.reset();
  ticking_.request_stop();
  if (ticking_.joinable()) {
    ticking_.join();
  }
  if (services_ == nullptr || services_->grpc_server == nullptr) {
    return;
  }
  services_->grpc_server->GetHealthCheckService()->SetServingStatus(false);
  coordinator_->Stop();
  services_->hub.Close();
  services_->grpc_server->Shutdown(std::chrono::system_clock::now() + kDrainTime);
  services_->grpc_server->Wait();
  services_->grpc_server.reset();
  spdlog::info("event=stopped");
}

Server::~Server() {
  Stop();
}

}  // namespace cohort
