#pragma once

#include <absl/status/status.h>

namespace cohort {

// What the program's exit code says; in README and `cohort --help`.
inline constexpr int kExitOk = 0;
inline constexpr int kExitFailed = 1;         ///< Input, output or the server failed.
inline constexpr int kExitUsage = 2;          ///< Wrong command line or parameter.
inline constexpr int kExitRejected = 3;       ///< Finished, but meshes were rejected.
inline constexpr int kExitJobFailed = 4;      ///< The job ended with an error.
inline constexpr int kExitCancelled = 5;      ///< The job was cancelled.
inline constexpr int kExitUnreachable = 6;    ///< No server at the address.
inline constexpr int kExitNotFound = 7;       ///< Unknown job, set or file.
inline constexpr int kExitInterrupted = 130;  ///< Ctrl-C.

/// The exit code for an error of a command.
[[nodiscard]] inline int ExitCodeOf(const absl::Status& status) {
  switch (status.code()) {
    case absl::StatusCode::kOk:
      return kExitOk;
    case absl::StatusCode::kInvalidArgument:
      return kExitUsage;
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kDeadlineExceeded:
      return kExitUnreachable;
    case absl::StatusCode::kNotFound:
      return kExitNotFound;
    case absl::StatusCode::kCancelled:
      return kExitInterrupted;
    default:
      return kExitFailed;
  }
}

}  // namespace cohort
