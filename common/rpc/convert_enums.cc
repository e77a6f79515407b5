#include "common/rpc/convert_enums.h"

#include <string>

namespace cohort {
namespace {

/// Our enumerations count from 0 in the order of the wire's, which count from 1.
template <typename Wire, typename Ours>
Wire Shift(Ours value) {
  return static_cast<Wire>(static_cast<int>(value) + 1);
}

template <typename Ours, typename Wire>
absl::StatusOr<Ours> Unshift(Wire wire, Ours last, const char* name) {
  const int value = static_cast<int>(wire) - 1;
  if (value < 0 || value > static_cast<int>(last)) {
    return absl::InvalidArgumentError(std::string(name) + ": value " +
                                      std::to_string(static_cast<int>(wire)) + " is not known");
  }
  return static_cast<Ours>(value);
}

// The shift holds as long as first and last agree and nothing is inserted in between.
static_assert(static_cast<int>(Method::kNone) + 1 == v1::METHOD_NONE);
static_assert(static_cast<int>(PoseMode::kLandmarks) + 1 == v1::POSE_MODE_LANDMARKS);
static_assert(static_cast<int>(ScaleMode::kFromX) + 1 == v1::SCALE_MODE_FROM_X);
static_assert(static_cast<int>(Arithmetic::kFidentis) + 1 == v1::ARITHMETIC_FIDENTIS);
static_assert(static_cast<int>(DistanceSign::kSigned) + 1 == v1::DISTANCE_SIGN_SIGNED);
static_assert(static_cast<int>(Metric::kPercentile75) + 1 == v1::METRIC_PERCENTILE_75);
static_assert(static_cast<int>(Symmetrization::kDirected) + 1 == v1::SYMMETRIZATION_DIRECTED);
static_assert(static_cast<int>(JobState::kPaused) + 1 == v1::JOB_STATE_PAUSED);
static_assert(static_cast<int>(TaskKind::kSymmetrize) + 1 == v1::TASK_KIND_SYMMETRIZE);
static_assert(static_cast<int>(BaseRule::kAuto) + 1 == v1::BASE_RULE_AUTO);
static_assert(static_cast<int>(Acceleration::kAnderson) + 1 == v1::ACCELERATION_ANDERSON);
static_assert(static_cast<int>(BoundaryPairs::kReject) + 1 == v1::BOUNDARY_PAIRS_REJECT);
static_assert(static_cast<int>(Correspondence::kSurface) + 1 == v1::CORRESPONDENCE_SURFACE);
static_assert(static_cast<int>(UndersamplingMethod::kCurvature) + 1 ==
              v1::UNDERSAMPLING_METHOD_CURVATURE);
static_assert(static_cast<int>(Retention::kAuto) + 1 == v1::RETENTION_AUTO);

}  // namespace

v1::Method ToProto(Method method) {
  return Shift<v1::Method>(method);
}
v1::PoseMode ToProto(PoseMode pose) {
  return Shift<v1::PoseMode>(pose);
}
v1::ScaleMode ToProto(ScaleMode scale) {
  return Shift<v1::ScaleMode>(scale);
}
v1::Metric ToProto(Metric metric) {
  return Shift<v1::Metric>(metric);
}
v1::Symmetrization ToProto(Symmetrization symmetrization) {
  return Shift<v1::Symmetrization>(symmetrization);
}
v1::JobState ToProto(JobState state) {
  return Shift<v1::JobState>(state);
}
v1::TaskKind ToProto(TaskKind kind) {
  return Shift<v1::TaskKind>(kind);
}

absl::StatusOr<Method> FromProto(v1::Method wire) {
  return Unshift(wire, Method::kNone, "method");
}
absl::StatusOr<PoseMode> FromProto(v1::PoseMode wire) {
  return Unshift(wire, PoseMode::kLandmarks, "pose");
}
absl::StatusOr<ScaleMode> FromProto(v1::ScaleMode wire) {
  return Unshift(wire, ScaleMode::kFromX, "scale");
}
absl::StatusOr<Metric> FromProto(v1::Metric wire) {
  return Unshift(wire, Metric::kPercentile75, "metric");
}
absl::StatusOr<Symmetrization> FromProto(v1::Symmetrization wire) {
  return Unshift(wire, Symmetrization::kDirected, "symmetrization");
}
absl::StatusOr<JobState> FromProto(v1::JobState wire) {
  return Unshift(wire, JobState::kPaused, "state");
}
absl::StatusOr<TaskKind> FromProto(v1::TaskKind wire) {
  return Unshift(wire, TaskKind::kSymmetrize, "kind");
}
v1::Arithmetic ToProto(Arithmetic value) {
  return Shift<v1::Arithmetic>(value);
}
absl::StatusOr<Arithmetic> FromProto(v1::Arithmetic wire) {
  return Unshift(wire, Arithmetic::kFidentis, "arithmetic");
}
v1::DistanceSign ToProto(DistanceSign value) {
  return Shift<v1::DistanceSign>(value);
}
absl::StatusOr<DistanceSign> FromProto(v1::DistanceSign wire) {
  return Unshift(wire, DistanceSign::kSigned, "distance sign");
}
v1::BaseRule ToProto(BaseRule value) {
  return Shift<v1::BaseRule>(value);
}
absl::StatusOr<BaseRule> FromProto(v1::BaseRule wire) {
  return Unshift(wire, BaseRule::kAuto, "base rule");
}
v1::Acceleration ToProto(Acceleration value) {
  return Shift<v1::Acceleration>(value);
}
absl::StatusOr<Acceleration> FromProto(v1::Acceleration wire) {
  return Unshift(wire, Acceleration::kAnderson, "acceleration");
}
v1::BoundaryPairs ToProto(BoundaryPairs value) {
  return Shift<v1::BoundaryPairs>(value);
}
absl::StatusOr<BoundaryPairs> FromProto(v1::BoundaryPairs wire) {
  return Unshift(wire, BoundaryPairs::kReject, "boundary pairs");
}
v1::Correspondence ToProto(Correspondence value) {
  return Shift<v1::Correspondence>(value);
}
absl::StatusOr<Correspondence> FromProto(v1::Correspondence wire) {
  return Unshift(wire, Correspondence::kSurface, "correspondence");
}
v1::UndersamplingMethod ToProto(UndersamplingMethod value) {
  return Shift<v1::UndersamplingMethod>(value);
}
absl::StatusOr<UndersamplingMethod> FromProto(v1::UndersamplingMethod wire) {
  return Unshift(wire, UndersamplingMethod::kCurvature, "undersampling method");
}
v1::Retention ToProto(Retention value) {
  return Shift<v1::Retention>(value);
}
absl::StatusOr<Retention> FromProto(v1::Retention wire) {
  return Unshift(wire, Retention::kAuto, "retention");
}

}  // namespace cohort
