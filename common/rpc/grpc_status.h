#pragma once

#include <absl/status/status.h>
#include <grpcpp/support/status.h>

namespace cohort {

/// Same code and message, with one ErrorInfo (AIP-193) that carries the error's reason.
[[nodiscard]] grpc::Status ToGrpcStatus(const absl::Status& status);

/// Inverse; the reason comes back too. Transport failures get a message that says what to check.
/// @param peer  address for the message, e.g. "unix:/run/cohort.sock".
[[nodiscard]] absl::Status FromGrpcStatus(const grpc::Status& status, const std::string& peer);

}  // namespace cohort
