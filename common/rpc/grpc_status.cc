#include "common/rpc/grpc_status.h"

#include <string>

#include "cohort/v1/errors.pb.h"
#include "common/base/error_reason.h"

namespace cohort {
namespace {

constexpr char kErrorInfoUrl[] = "type.googleapis.com/google.rpc.ErrorInfo";
constexpr char kDomain[] = "cohort";

/// The reason in the details of one of our errors; empty if there is none.
std::string ReasonIn(const std::string& details) {
  v1::ErrorStatus wire;
  if (!wire.ParseFromString(details)) {
    return "";
  }
  for (const auto& detail : wire.details()) {
    v1::ErrorInfo error;
    if (detail.type_url() == kErrorInfoUrl && error.ParseFromString(detail.value())) {
      return error.reason();
    }
  }
  return "";
}

}  // namespace

grpc::Status ToGrpcStatus(const absl::Status& status) {
  if (status.ok()) {
    return grpc::Status::OK;
  }
  v1::ErrorInfo error;
  error.set_reason(ErrorReason(status));
  error.set_domain(kDomain);
  v1::ErrorStatus wire;
  wire.set_code(static_cast<int>(status.code()));
  wire.set_message(std::string(status.message()));
  auto* detail = wire.add_details();
  detail->set_type_url(kErrorInfoUrl);
  detail->set_value(error.SerializeAsString());
  return {static_cast<grpc::StatusCode>(status.code()), wire.message(), wire.SerializeAsString()};
}

absl::Status FromGrpcStatus(const grpc::Status& status, const std::string& peer) {
  if (status.ok()) {
    return absl::OkStatus();
  }
  const auto code = static_cast<absl::StatusCode>(status.error_code());
  const std::string reason = ReasonIn(status.error_details());
  if (!reason.empty()) {
    return WithReason(absl::Status(code, status.error_message()), reason);
  }
  if (code == absl::StatusCode::kUnavailable) {
    return absl::UnavailableError("cannot reach the server at " + peer + " (" +
                                  status.error_message() + "); is cohort-server running there?");
  }
  if (code == absl::StatusCode::kDeadlineExceeded) {
    return absl::DeadlineExceededError("the server at " + peer + " did not answer in time");
  }
  return {code, status.error_message() + " (server " + peer + ")"};
}

}  // namespace cohort
