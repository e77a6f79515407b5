#include "common/jobs/job_spec.h"

#include <cmath>

#include <absl/strings/str_cat.h>
#include <nlohmann/json.hpp>

#include "common/base/status_macros.h"
#include "common/jobs/fidentis_spec.h"
#include "common/jobs/job_spec_names.h"
#include "common/jobs/json_fields.h"

namespace cohort {
namespace {

constexpr int kMostPriority = 100;
constexpr int kMaxRounds = 100;
constexpr int kMinPositionBits = 8;
constexpr int kMaxPositionBits = 30;

template <typename T>
absl::Status Refused(std::string_view field, T value, std::string_view expected) {
  return absl::InvalidArgumentError(absl::StrCat("job spec: ", std::string(field), " is ", value,
                                                 ", expected ", std::string(expected)));
}

/// What only one arithmetic has, or has in another way.
absl::Status CheckEngine(const JobSpec& spec) {
  if (spec.arithmetic == Arithmetic::kFidentis) {
    return ValidateFidentis(spec);
  }
  if (spec.icp.scale_mode == ScaleMode::kFromX) {
    return Refused("icp.scale", "\"from-x\"", "symmetric, least-squares or off");
  }
  if (spec.compare.sign == DistanceSign::kSigned) {
    return Refused("compare.sign", "\"signed\"", "\"absolute\" but in the preset fidentis");
  }
  if (spec.position_bits < kMinPositionBits || spec.position_bits > kMaxPositionBits) {
    return Refused("position_bits", spec.position_bits,
                   absl::StrCat(kMinPositionBits, " to ", kMaxPositionBits));
  }
  if (absl::Status status = spec.icp.Validate(); !status.ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat("job spec: icp: ", std::string(status.message())));
  }
  if (absl::Status status = spec.undersampling.Validate(); !status.ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat("job spec: undersampling: ", std::string(status.message())));
  }
  return absl::OkStatus();
}

absl::Status CheckPose(const JobSpec& spec) {
  if ((spec.pose == PoseMode::kLandmarks) != !spec.landmarks.empty()) {
    return Refused("landmarks", spec.landmarks.empty() ? "empty" : "a blob",
                   "a blob with the pose \"landmarks\" and none with another");
  }
  if (spec.pose == PoseMode::kLandmarks && spec.method == Method::kNone) {
    return Refused("pose", "\"landmarks\"",
                   "another with the method \"none\", which moves no mesh");
  }
  return absl::OkStatus();
}

}  // namespace

absl::Status JobSpec::Validate() const {
  if (rounds < 1 || rounds > kMaxRounds) {
    return Refused("rounds", rounds, absl::StrCat("1 to ", kMaxRounds));
  }
  if (priority < -kMostPriority || priority > kMostPriority) {
    return Refused("priority", priority, absl::StrCat("-", kMostPriority, " to ", kMostPriority));
  }
  if (base_rule == BaseRule::kAuto && !base.empty()) {
    return Refused("base", absl::StrCat("\"", base, "\""), "none with the base rule \"auto\"");
  }
  COHORT_RETURN_IF_ERROR(CheckPose(*this));
  if (!std::isfinite(mean_tolerance) || mean_tolerance < 0) {
    return Refused("mean_tolerance", mean_tolerance, "at least 0");
  }
  if (compare.correspondence == Correspondence::kSurface &&
      compare.boundary_pairs == BoundaryPairs::kReject) {
    return Refused("compare.boundary_pairs", "\"reject\"",
                   "\"keep\" where distances go to the surface");
  }
  if (retention_budget < 0) {
    return Refused("retention_budget", retention_budget, "at least 0 bytes");
  }
  if (preview && method == Method::kEach) {
    return Refused("preview", "true",
                   "false with the method \"each\", which has no common reference");
  }
  if (neighbours < 1) {
    return Refused("neighbours", neighbours, "at least 1");
  }
  const bool checked = std::isfinite(size_ratio_limit) && size_ratio_limit > 1;
  if (size_ratio_limit != 0 && !checked) {
    return Refused("size_ratio_limit", size_ratio_limit, "0 (not checked) or more than 1");
  }
  return CheckEngine(*this);
}

absl::StatusOr<JobSpec> PresetSpec(std::string_view preset, Method method) {
  JobSpec spec;
  spec.method = method;
  if (preset == "default") {
    return spec;
  }
  if (preset == "thesis") {
    const bool one_pass = method == Method::kOne || method == Method::kEach;
    spec.icp.max_iterations = one_pass ? 40 : 10;
    spec.icp.tolerance = 0.05;
    spec.icp.scale_mode = ScaleMode::kFree;
    spec.icp.rigid_first = false;
    spec.icp.acceleration = Acceleration::kNone;
    spec.rounds = 3;
    return spec;
  }
  if (preset == "fidentis") {
    return FidentisSpec(method);
  }
  return absl::InvalidArgumentError(absl::StrCat("preset is \"", std::string(preset),
                                                 "\", expected default, thesis or fidentis"));
}

nlohmann::json ToJson(const JobSpec& spec) {
  return {{"arithmetic", ArithmeticName(spec.arithmetic)},
          {"method", MethodName(spec.method)},
          {"base_rule", BaseRuleName(spec.base_rule)},
          {"base", spec.base},
          {"rounds", spec.rounds},
          {"mean_tolerance", spec.mean_tolerance},
          {"pose", PoseModeName(spec.pose)},
          {"landmarks", spec.landmarks.Hex()},
          {"symmetric_copies", spec.symmetric_copies},
          {"icp",
           {{"scale", ScaleModeName(spec.icp.scale_mode)},
            {"scale_limit", spec.icp.scale_limit},
            {"rigid_first", spec.icp.rigid_first},
            {"max_iterations", spec.icp.max_iterations},
            {"tolerance", spec.icp.tolerance},
            {"acceleration", AccelerationName(spec.icp.acceleration)},
            {"trimmed_share", spec.icp.trimmed_share},
            {"distance_limit", spec.icp.distance_limit},
            {"boundary_pairs", BoundaryPairsName(spec.icp.boundary_pairs)},
            {"correspondence", CorrespondenceName(spec.icp.correspondence)}}},
          {"undersampling",
           {{"method", UndersamplingName(spec.undersampling.method)},
            {"count", spec.undersampling.count},
            {"share", spec.undersampling.share},
            {"radius", spec.undersampling.radius},
            {"seed", static_cast<int64_t>(spec.undersampling.seed)}}},
          {"compare",
           {{"correspondence", CorrespondenceName(spec.compare.correspondence)},
            {"boundary_pairs", BoundaryPairsName(spec.compare.boundary_pairs)},
            {"retention", RetentionName(spec.compare.retention)},
            {"sign", DistanceSignName(spec.compare.sign)}}},
          {"retention_budget", spec.retention_budget},
          {"preview", spec.preview},
          {"priority", spec.priority},
          {"fresh", spec.fresh},
          {"reference_job", spec.reference_job},
          {"metric", MetricName(spec.metric)},
          {"symmetrization", SymmetrizationName(spec.symmetrization)},
          {"neighbours", spec.neighbours},
          {"position_bits", spec.position_bits},
          {"size_ratio_limit", spec.size_ratio_limit}};
}

namespace {

void ReadIcp(JsonFields& fields, IcpOptions& icp) {
  fields.ReadName("scale", ScaleModeFromName, icp.scale_mode);
  fields.Read("scale_limit", icp.scale_limit);
  fields.Read("rigid_first", icp.rigid_first);
  fields.Read("max_iterations", icp.max_iterations);
  fields.Read("tolerance", icp.tolerance);
  fields.ReadName("acceleration", AccelerationFromName, icp.acceleration);
  fields.Read("trimmed_share", icp.trimmed_share);
  fields.Read("distance_limit", icp.distance_limit);
  fields.ReadName("boundary_pairs", BoundaryPairsFromName, icp.boundary_pairs);
  fields.ReadName("correspondence", CorrespondenceFromName, icp.correspondence);
}

void ReadUndersampling(JsonFields& fields, UndersamplingOptions& undersampling) {
  auto seed = static_cast<int64_t>(undersampling.seed);
  fields.ReadName("method", UndersamplingFromName, undersampling.method);
  fields.Read("count", undersampling.count);
  fields.Read("share", undersampling.share);
  fields.Read("radius", undersampling.radius);
  fields.Read("seed", seed);
  undersampling.seed = static_cast<uint64_t>(seed);
}

void ReadCompare(JsonFields& fields, CompareOptions& compare) {
  fields.ReadName("correspondence", CorrespondenceFromName, compare.correspondence);
  fields.ReadName("boundary_pairs", BoundaryPairsFromName, compare.boundary_pairs);
  fields.ReadName("retention", RetentionFromName, compare.retention);
  fields.ReadName("sign", DistanceSignFromName, compare.sign);
}

}  // namespace

absl::StatusOr<JobSpec> JobSpecFromJson(const nlohmann::json& json) {
  JobSpec spec;
  JsonFields fields(json, "job spec", absl::StatusCode::kInvalidArgument, Presence::kOptional);
  fields.ReadName("arithmetic", ArithmeticFromName, spec.arithmetic);
  fields.ReadName("method", MethodFromName, spec.method);
  fields.ReadName("base_rule", BaseRuleFromName, spec.base_rule);
  fields.Read("base", spec.base);
  fields.Read("rounds", spec.rounds);
  fields.Read("mean_tolerance", spec.mean_tolerance);
  fields.ReadName("pose", PoseModeFromName, spec.pose);
  fields.Read("landmarks", spec.landmarks);
  fields.Read("symmetric_copies", spec.symmetric_copies);
  fields.ReadObject("icp", [&spec](JsonFields& icp) { ReadIcp(icp, spec.icp); });
  fields.ReadObject("undersampling",
                    [&spec](JsonFields& item) { ReadUndersampling(item, spec.undersampling); });
  fields.ReadObject("compare", [&spec](JsonFields& item) { ReadCompare(item, spec.compare); });
  fields.Read("retention_budget", spec.retention_budget);
  fields.Read("preview", spec.preview);
  fields.Read("priority", spec.priority);
  fields.Read("fresh", spec.fresh);
  fields.Read("reference_job", spec.reference_job);
  fields.ReadName("metric", MetricFromName, spec.metric);
  fields.ReadName("symmetrization", SymmetrizationFromName, spec.symmetrization);
  fields.Read("neighbours", spec.neighbours);
  fields.Read("position_bits", spec.position_bits);
  fields.Read("size_ratio_limit", spec.size_ratio_limit);
  COHORT_RETURN_IF_ERROR(fields.Finish());
  return spec;
}

}  // namespace cohort
