#pragma once

#include <memory>
#include <string>

#include <absl/status/statusor.h>
#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>

namespace cohort {

/// Largest message either side takes; bulk travels in pieces of kChunkBytes.
inline constexpr int kMaxMessageBytes = 16 << 20;
inline constexpr int64_t kChunkBytes = 1 << 20;
inline constexpr double kUnaryDeadlineSeconds = 30;

/// Address as gRPC wants it: "HOST:PORT" and "unix:PATH" stay; a plain path ("/run/x.sock",
/// "./x.sock") becomes "unix:PATH".
/// @return kInvalidArgument if it is none of them.
[[nodiscard]] absl::StatusOr<std::string> NormalizeAddress(const std::string& address);

/// Channel with keepalive and message limits; connects when first used.
[[nodiscard]] std::shared_ptr<grpc::Channel> OpenChannel(const std::string& normalized_address);

/// Keeps gRPC's global state until the process ends. Otherwise the last channel or server to go
/// tears it down and waits for its poller, up to 10 s in 1.51.
void KeepGrpcRunning();

/// Whether the address is a socket file. gRPC's probes of the bandwidth (GRPC_ARG_HTTP2_BDP_PROBE)
/// would only cost there: a ping with every message.
[[nodiscard]] bool IsLocalSocket(const std::string& normalized_address);

/// Every call has a deadline.
void SetDeadline(grpc::ClientContext& context, double seconds);

}  // namespace cohort
