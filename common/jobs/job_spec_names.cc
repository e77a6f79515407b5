#include "common/jobs/job_spec_names.h"

#include <array>
#include <cstddef>
#include <utility>

namespace cohort {
namespace {

template <typename T, size_t kSize>
using Names = std::array<std::pair<T, std::string_view>, kSize>;

constexpr Names<Method, 4> kMethods = {{{Method::kAverage, "average"},
                                        {Method::kOne, "one"},
                                        {Method::kEach, "each"},
                                        {Method::kNone, "none"}}};
constexpr Names<PoseMode, 3> kPoseModes = {{{PoseMode::kPrincipalAxes, "principal-axes"},
                                            {PoseMode::kNone, "none"},
                                            {PoseMode::kLandmarks, "landmarks"}}};
constexpr Names<Symmetrization, 3> kSymmetrizations = {{{Symmetrization::kMean, "mean"},
                                                        {Symmetrization::kMax, "max"},
                                                        {Symmetrization::kDirected, "directed"}}};
constexpr Names<ScaleMode, 4> kScaleModes = {{{ScaleMode::kOff, "off"},
                                              {ScaleMode::kFree, "least-squares"},
                                              {ScaleMode::kSymmetric, "symmetric"},
                                              {ScaleMode::kFromX, "from-x"}}};
constexpr Names<Arithmetic, 2> kArithmetics = {
    {{Arithmetic::kExact, "exact"}, {Arithmetic::kFidentis, "fidentis"}}};
constexpr Names<DistanceSign, 2> kDistanceSigns = {
    {{DistanceSign::kAbsolute, "absolute"}, {DistanceSign::kSigned, "signed"}}};
constexpr Names<BaseRule, 2> kBaseRules = {
    {{BaseRule::kGiven, "given"}, {BaseRule::kAuto, "auto"}}};
constexpr Names<Retention, 5> kRetentions = {{{Retention::kVectors, "vectors"},
                                              {Retention::kCompact, "compact"},
                                              {Retention::kSketch, "sketch"},
                                              {Retention::kMetrics, "metrics"},
                                              {Retention::kAuto, "auto"}}};
constexpr Names<Correspondence, 2> kCorrespondences = {
    {{Correspondence::kVertex, "vertex"}, {Correspondence::kSurface, "surface"}}};
constexpr Names<BoundaryPairs, 2> kBoundaryPairs = {
    {{BoundaryPairs::kKeep, "keep"}, {BoundaryPairs::kReject, "reject"}}};
constexpr Names<Acceleration, 2> kAccelerations = {
    {{Acceleration::kNone, "none"}, {Acceleration::kAnderson, "anderson"}}};
constexpr Names<UndersamplingMethod, 4> kUndersamplings = {
    {{UndersamplingMethod::kNone, "none"},
     {UndersamplingMethod::kRandom, "random"},
     {UndersamplingMethod::kDisk, "disk"},
     {UndersamplingMethod::kCurvature, "curvature"}}};

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

}  // namespace

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
std::string_view ScaleModeName(ScaleMode mode) {
  return NameOf(kScaleModes, mode);
}
std::optional<ScaleMode> ScaleModeFromName(std::string_view name) {
  return FromName(kScaleModes, name);
}
std::string_view ArithmeticName(Arithmetic value) {
  return NameOf(kArithmetics, value);
}
std::optional<Arithmetic> ArithmeticFromName(std::string_view name) {
  return FromName(kArithmetics, name);
}
std::string_view DistanceSignName(DistanceSign value) {
  return NameOf(kDistanceSigns, value);
}
std::optional<DistanceSign> DistanceSignFromName(std::string_view name) {
  return FromName(kDistanceSigns, name);
}
std::string_view BaseRuleName(BaseRule rule) {
  return NameOf(kBaseRules, rule);
}
std::optional<BaseRule> BaseRuleFromName(std::string_view name) {
  return FromName(kBaseRules, name);
}
std::string_view RetentionName(Retention retention) {
  return NameOf(kRetentions, retention);
}
std::optional<Retention> RetentionFromName(std::string_view name) {
  return FromName(kRetentions, name);
}
std::string_view CorrespondenceName(Correspondence value) {
  return NameOf(kCorrespondences, value);
}
std::optional<Correspondence> CorrespondenceFromName(std::string_view name) {
  return FromName(kCorrespondences, name);
}
std::string_view BoundaryPairsName(BoundaryPairs value) {
  return NameOf(kBoundaryPairs, value);
}
std::optional<BoundaryPairs> BoundaryPairsFromName(std::string_view name) {
  return FromName(kBoundaryPairs, name);
}
std::string_view AccelerationName(Acceleration value) {
  return NameOf(kAccelerations, value);
}
std::optional<Acceleration> AccelerationFromName(std::string_view name) {
  return FromName(kAccelerations, name);
}
std::string_view UndersamplingName(UndersamplingMethod method) {
  return NameOf(kUndersamplings, method);
}
std::optional<UndersamplingMethod> UndersamplingFromName(std::string_view name) {
  return FromName(kUndersamplings, name);
}

}  // namespace cohort
