#include "common/jobs/fidentis_spec.h"

#include <cmath>
#include <string>
#include <string_view>

#include <absl/strings/str_cat.h>

#include "common/jobs/job_spec_names.h"

namespace cohort {
namespace {

absl::Status Refused(std::string_view field, std::string_view value, std::string_view expected) {
  return absl::InvalidArgumentError(absl::StrCat("job spec: ", std::string(field), " is ",
                                                 std::string(value), ", expected ",
                                                 std::string(expected), " in the preset fidentis"));
}

std::string Quoted(std::string_view name) {
  return absl::StrCat("\"", std::string(name), "\"");
}

absl::Status CheckStart(const JobSpec& spec) {
  if (spec.method == Method::kNone) {
    return Refused("method", "\"none\"", "average, one or each");
  }
  if (spec.base_rule != BaseRule::kGiven) {
    return Refused("base_rule", Quoted(BaseRuleName(spec.base_rule)), "a base given by name");
  }
  if (spec.mean_tolerance != 0) {
    return Refused("mean_tolerance", absl::StrCat(spec.mean_tolerance), "0");
  }
  if (spec.preview) {
    return Refused("preview", "true", "false");
  }
  if (spec.pose != PoseMode::kNone) {
    return Refused("pose", Quoted(PoseModeName(spec.pose)), "\"none\"");
  }
  if (spec.symmetric_copies) {
    return Refused("symmetric_copies", "true", "false");
  }
  if (spec.undersampling.method != UndersamplingMethod::kNone) {
    return Refused("undersampling.method", Quoted(UndersamplingName(spec.undersampling.method)),
                   "\"none\"");
  }
  if (spec.position_bits != 0) {
    return Refused("position_bits", absl::StrCat(spec.position_bits), "0 (as in the file)");
  }
  return absl::OkStatus();
}

absl::Status CheckIcp(const IcpOptions& icp) {
  if (icp.scale_mode != ScaleMode::kFromX && icp.scale_mode != ScaleMode::kOff) {
    return Refused("icp.scale", Quoted(ScaleModeName(icp.scale_mode)),
                   "\"from-x\" (on) or \"off\"");
  }
  if (icp.max_iterations < 1) {
    return Refused("icp.max_iterations", absl::StrCat(icp.max_iterations), "at least 1");
  }
  if (!std::isfinite(icp.tolerance) || icp.tolerance < 0) {
    return Refused("icp.tolerance", absl::StrCat(icp.tolerance), "at least 0");
  }
  if (icp.scale_limit != 0) {
    return Refused("icp.scale_limit", absl::StrCat(icp.scale_limit), "0");
  }
  if (icp.rigid_first) {
    return Refused("icp.rigid_first", "true", "false");
  }
  if (icp.acceleration != Acceleration::kNone) {
    return Refused("icp.acceleration", Quoted(AccelerationName(icp.acceleration)), "\"none\"");
  }
  if (icp.trimmed_share != 0) {
    return Refused("icp.trimmed_share", absl::StrCat(icp.trimmed_share), "0");
  }
  if (icp.distance_limit != 0) {
    return Refused("icp.distance_limit", absl::StrCat(icp.distance_limit), "0");
  }
  if (icp.boundary_pairs != BoundaryPairs::kKeep) {
    return Refused("icp.boundary_pairs", Quoted(BoundaryPairsName(icp.boundary_pairs)), "\"keep\"");
  }
  if (icp.correspondence != Correspondence::kVertex) {
    return Refused("icp.correspondence", Quoted(CorrespondenceName(icp.correspondence)),
                   "\"vertex\"");
  }
  return absl::OkStatus();
}

absl::Status CheckCompare(const CompareOptions& compare) {
  if (compare.correspondence != Correspondence::kVertex) {
    return Refused("compare.correspondence", Quoted(CorrespondenceName(compare.correspondence)),
                   "\"vertex\"");
  }
  if (compare.boundary_pairs != BoundaryPairs::kKeep) {
    return Refused("compare.boundary_pairs", Quoted(BoundaryPairsName(compare.boundary_pairs)),
                   "\"keep\"");
  }
  if (compare.retention == Retention::kCompact || compare.retention == Retention::kSketch) {
    return Refused("compare.retention", Quoted(RetentionName(compare.retention)),
                   "\"vectors\", \"metrics\" or \"auto\"");
  }
  return absl::OkStatus();
}

}  // namespace

JobSpec FidentisSpec(Method method) {
  JobSpec spec;
  spec.arithmetic = Arithmetic::kFidentis;
  spec.method = method;
  spec.rounds = 3;
  spec.pose = PoseMode::kNone;
  const bool one_pass = method == Method::kOne || method == Method::kEach;
  spec.icp.max_iterations = one_pass ? 40 : 10;
  spec.icp.tolerance = 0.05;
  spec.icp.scale_mode = ScaleMode::kFromX;
  spec.icp.rigid_first = false;
  spec.icp.acceleration = Acceleration::kNone;
  spec.position_bits = 0;
  return spec;
}

absl::Status ValidateFidentis(const JobSpec& spec) {
  if (absl::Status status = CheckStart(spec); !status.ok()) {
    return status;
  }
  if (absl::Status status = CheckIcp(spec.icp); !status.ok()) {
    return status;
  }
  return CheckCompare(spec.compare);
}

}  // namespace cohort
