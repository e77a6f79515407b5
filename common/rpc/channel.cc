#include "common/rpc/channel.h"

#include <chrono>
#include <cstdlib>
#include <limits>

#include <absl/synchronization/mutex.h>
#include <grpc/grpc.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/security/credentials.h>
#include <grpcpp/support/channel_arguments.h>

namespace cohort {

absl::StatusOr<std::string> NormalizeAddress(const std::string& address) {
  if (address.rfind("unix:", 0) == 0 && address.size() > 5) {
    return address;
  }
  if (!address.empty() && (address[0] == '/' || address[0] == '.')) {
    return "unix:" + address;
  }
  const size_t colon = address.rfind(':');
  const bool has_port = colon != std::string::npos && colon > 0 && colon + 1 < address.size() &&
                        address.find_first_not_of("0123456789", colon + 1) == std::string::npos;
  if (!has_port || address.size() - colon > 6 || std::stoi(address.substr(colon + 1)) > 65535) {
    return absl::InvalidArgumentError("'" + address +
                                      "' is not an address: expected HOST:PORT or unix:PATH");
  }
  return address;
}

bool IsLocalSocket(const std::string& normalized_address) {
  return normalized_address.rfind("unix:", 0) == 0;
}

void KeepGrpcRunning() {
  static const bool started = [] {
    // A call that fails because the server is away leaves nobody who waits for the next connection:
    // gRPC looks after it only this often. Its own 5 s would cost a worker the leases that a
    // restarted server holds for it.
    setenv("GRPC_CLIENT_CHANNEL_BACKUP_POLL_INTERVAL_MS", "200", 0);
    // Debian's libabsl is a debug build: it would look for deadlocks among gRPC's mutexes, behind
    // one lock for all threads, each time that one is taken.
    absl::SetMutexDeadlockDetectionMode(absl::OnDeadlockCycle::kIgnore);
    grpc_init();
    return true;
  }();
  (void)started;
}

std::shared_ptr<grpc::Channel> OpenChannel(const std::string& normalized_address) {
  KeepGrpcRunning();
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, 30'000);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, 10'000);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_PERMIT_WITHOUT_CALLS, 1);
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  // Also how long one attempt to connect may take: a busy machine needs seconds.
  arguments.SetInt(GRPC_ARG_MIN_RECONNECT_BACKOFF_MS, 10'000);
  arguments.SetInt(GRPC_ARG_INITIAL_RECONNECT_BACKOFF_MS, 200);
  arguments.SetInt(GRPC_ARG_MAX_RECONNECT_BACKOFF_MS, 2'000);
  arguments.SetInt(GRPC_ARG_HTTP2_BDP_PROBE, IsLocalSocket(normalized_address) ? 0 : 1);
  arguments.SetMaxReceiveMessageSize(kMaxMessageBytes);
  arguments.SetMaxSendMessageSize(kMaxMessageBytes);
  // Proxy settings of the environment are for web pages, not for a cluster's own servers.
  arguments.SetInt(GRPC_ARG_ENABLE_HTTP_PROXY, 0);
  return grpc::CreateCustomChannel(normalized_address, grpc::InsecureChannelCredentials(),
                                   arguments);
}

void SetDeadline(grpc::ClientContext& context, double seconds) {
  context.set_deadline(std::chrono::system_clock::now() +
                       std::chrono::milliseconds(static_cast<int64_t>(seconds * 1000)));
}

}  // namespace cohort
