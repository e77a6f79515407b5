#pragma once

#include <string>
#include <string_view>

#include <absl/status/status.h>
#include <absl/strings/cord.h>

namespace cohort {

inline constexpr char kErrorReasonUrl[] = "cohort/reason";

/// Marks an error with a constant for programs, in UPPER_SNAKE_CASE, e.g. "JOB_NOT_FOUND"; it
/// reaches clients as ErrorInfo.reason.
[[nodiscard]] inline absl::Status WithReason(absl::Status status, std::string_view reason) {
  status.SetPayload(kErrorReasonUrl, absl::Cord(std::string(reason)));
  return status;
}

/// The mark, or the name of the status code.
[[nodiscard]] inline std::string ErrorReason(const absl::Status& status) {
  if (const auto payload = status.GetPayload(kErrorReasonUrl)) {
    return std::string(*payload);
  }
  return absl::StatusCodeToString(status.code());
}

}  // namespace cohort
