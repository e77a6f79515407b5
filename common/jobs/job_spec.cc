#include "common/jobs/job_spec.h"

#include <array>
#include <cmath>
#include <utility>

#include <absl/strings/str_cat.h>
#include <nlohmann/json.hpp>

#include "common/base/status_macros.h"
#include "common/jobs/json_fields.h"

namespace cohort {
namespace {

constexpr int kMaxRounds = 100;
constexpr int kMinPositionBits = 8;
constexpr int kMaxPositionBits = 30;

template <typename T, size_t kSize>
using Names = std::array<std::pair<T, std::string_view>, kSize>;

constexpr Names<Method, 4> kMethods = {{{Method::kAverage, "average"},
                                        {Method::kOne, "one"},
                                        {Method::kEach, "each"},
                                        {Method::kNone, "none"}}};
constexpr Names<PoseMode, 2> kPoseModes = {
    {{PoseMode::kPrincipalAxes, "principal-axes"}, {PoseMode::kNone, "none"}}};
constexpr Names<Symmetrization, 3> kSymmetrizations = {{{Symmetrization::kMean, "mean"},
                                                        {Symmetrization::kMax, "max"},
                                                        {Symmetrization::kDirected, "directed"}}};
constexpr Names<ScaleMode, 3> kScaleModes = {{{ScaleMode::kOff, "off"},
                                              {ScaleMode::kFree, "least-squares"},
                                              {ScaleMode::kSymmetric, "symmetric"}}};

template <typename T, size_t kSize>
std::string_view NameOf(const Names<T, kSize>& names, T value) {
  for (const auto& [candidate, name] : names) {
    if (candidate == value) {
      return name;
    }
  }
  return "unknown";
}

template <typename T, size_t kSize>
std::optional<T> FromName(const Names<T, kSize>& names, std::string_view name) {
  for (const auto& [value, candidate] : names) {
    if (candidate == name) {
      return value;
    }
  }
  return std::nullopt;
}

std::optional<ScaleMode> ScaleModeFromName(std::string_view name) {
  return FromName(kScaleModes, name);
}

template <typename T>
absl::Status Refused(std::string_view field, T value, std::string_view expected) {
  return absl::InvalidArgumentError(absl::StrCat("job spec: ", std::string(field), " is ", value,
                                                 ", expected ", std::string(expected)));
}

}  // namespace

absl::Status JobSpec::Validate() const {
  if (rounds < 1 || rounds > kMaxRounds) {
    return Refused("rounds", rounds, absl::StrCat("1 to ", kMaxRounds));
  }
  if (neighbours < 1) {
    return Refused("neighbours", neighbours, "at least 1");
  }
  if (position_bits < kMinPositionBits || position_bits > kMaxPositionBits) {
    return Refused("position_bits", position_bits,
                   absl::StrCat(kMinPositionBits, " to ", kMaxPositionBits));
  }
  const bool checked = std::isfinite(size_ratio_limit) && size_ratio_limit > 1;
  if (size_ratio_limit != 0 && !checked) {
    return Refused("size_ratio_limit", size_ratio_limit, "0 (not checked) or more than 1");
  }
  if (absl::Status status = icp.Validate(); !status.ok()) {
    return absl::InvalidArgumentError(
        absl::StrCat("job spec: icp: ", std::string(status.message())));
  }
  return absl::OkStatus();
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
    spec.rounds = 3;
    return spec;
  }
  return absl::InvalidArgumentError(
      absl::StrCat("preset is \"", std::string(preset), "\", expected default or thesis"));
}

std::string_view MethodName(Method method) {
  return NameOf(kMethods, method);
}
std::optional<Method> MethodFromName(std::string_view name) {
  return FromName(kMethods, name);
}
std::string_view PoseModeName(PoseMode pose) {
  return NameOf(kPoseModes, pose);
}
std::optional<PoseMode> PoseModeFromName(std::string_view name) {
  return FromName(kPoseModes, name);
}
std::string_view SymmetrizationName(Symmetrization value) {
  return NameOf(kSymmetrizations, value);
}
std::optional<Symmetrization> SymmetrizationFromName(std::string_view name) {
  return FromName(kSymmetrizations, name);
}

nlohmann::json ToJson(const JobSpec& spec) {
  return {{"method", MethodName(spec.method)},
          {"base", spec.base},
          {"rounds", spec.rounds},
          {"pose", PoseModeName(spec.pose)},
          {"icp",
           {{"scale", NameOf(kScaleModes, spec.icp.scale_mode)},
            {"max_iterations", spec.icp.max_iterations},
            {"tolerance", spec.icp.tolerance}}},
          {"metric", MetricName(spec.metric)},
          {"symmetrization", SymmetrizationName(spec.symmetrization)},
          {"neighbours", spec.neighbours},
          {"position_bits", spec.position_bits},
          {"size_ratio_limit", spec.size_ratio_limit}};
}

absl::StatusOr<JobSpec> JobSpecFromJson(const nlohmann::json& json) {
  JobSpec spec;
  JsonFields fields(json, "job spec", absl::StatusCode::kInvalidArgument, Presence::kOptional);
  fields.ReadName("method", MethodFromName, spec.method);
  fields.Read("base", spec.base);
  fields.Read("rounds", spec.rounds);
  fields.ReadName("pose", PoseModeFromName, spec.pose);
  fields.ReadObject("icp", [&spec](JsonFields& icp) {
    icp.ReadName("scale", ScaleModeFromName, spec.icp.scale_mode);
    icp.Read("max_iterations", spec.icp.max_iterations);
    icp.Read("tolerance", spec.icp.tolerance);
  });
  fields.ReadName("metric", MetricFromName, spec.metric);
  fields.ReadName("symmetrization", SymmetrizationFromName, spec.symmetrization);
  fields.Read("neighbours", spec.neighbours);
  fields.Read("position_bits", spec.position_bits);
  fields.Read("size_ratio_limit", spec.size_ratio_limit);
  COHORT_RETURN_IF_ERROR(fields.Finish());
  return spec;
}

}  // namespace cohort
