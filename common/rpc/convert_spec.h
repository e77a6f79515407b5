#pragma once

#include <string>

#include <absl/status/statusor.h>

#include "cohort/v1/types.pb.h"
#include "common/base/sha256.h"
#include "common/jobs/job_spec.h"

namespace cohort {

// Parts of a job spec <-> wire; see convert.h.

[[nodiscard]] v1::IcpOptions ToProto(const IcpOptions& icp);
[[nodiscard]] v1::Undersampling ToProto(const UndersamplingOptions& undersampling);
[[nodiscard]] v1::CompareOptions ToProto(const CompareOptions& compare);

[[nodiscard]] absl::StatusOr<IcpOptions> FromProto(const v1::IcpOptions& wire);
[[nodiscard]] absl::StatusOr<UndersamplingOptions> FromProto(const v1::Undersampling& wire);
[[nodiscard]] absl::StatusOr<CompareOptions> FromProto(const v1::CompareOptions& wire);

/// The empty string is the empty digest.
[[nodiscard]] absl::StatusOr<Digest> OptionalDigest(const std::string& hex);

}  // namespace cohort
