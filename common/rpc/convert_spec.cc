#include "common/rpc/convert_spec.h"

#include "common/base/status_macros.h"
#include "common/rpc/convert.h"
#include "common/rpc/convert_enums.h"

namespace cohort {

absl::StatusOr<Digest> OptionalDigest(const std::string& hex) {
  return hex.empty() ? absl::StatusOr<Digest>(Digest()) : Digest::FromHex(hex);
}

v1::IcpOptions ToProto(const IcpOptions& icp) {
  v1::IcpOptions wire;
  wire.set_scale(ToProto(icp.scale_mode));
  wire.set_scale_limit(icp.scale_limit);
  wire.set_rigid_first(icp.rigid_first);
  wire.set_max_iterations(icp.max_iterations);
  wire.set_tolerance(icp.tolerance);
  wire.set_acceleration(ToProto(icp.acceleration));
  wire.set_trimmed_share(icp.trimmed_share);
  wire.set_distance_limit(icp.distance_limit);
  wire.set_boundary_pairs(ToProto(icp.boundary_pairs));
  wire.set_correspondence(ToProto(icp.correspondence));
  return wire;
}

absl::StatusOr<IcpOptions> FromProto(const v1::IcpOptions& wire) {
  IcpOptions icp;
  COHORT_ASSIGN_OR_RETURN(icp.scale_mode, FromProto(wire.scale()));
  icp.scale_limit = wire.scale_limit();
  icp.rigid_first = wire.rigid_first();
  icp.max_iterations = wire.max_iterations();
  icp.tolerance = wire.tolerance();
  COHORT_ASSIGN_OR_RETURN(icp.acceleration, FromProto(wire.acceleration()));
  icp.trimmed_share = wire.trimmed_share();
  icp.distance_limit = wire.distance_limit();
  COHORT_ASSIGN_OR_RETURN(icp.boundary_pairs, FromProto(wire.boundary_pairs()));
  COHORT_ASSIGN_OR_RETURN(icp.correspondence, FromProto(wire.correspondence()));
  return icp;
}

v1::Undersampling ToProto(const UndersamplingOptions& undersampling) {
  v1::Undersampling wire;
  wire.set_method(ToProto(undersampling.method));
  wire.set_count(undersampling.count);
  wire.set_share(undersampling.share);
  wire.set_radius(undersampling.radius);
  wire.set_seed(undersampling.seed);
  return wire;
}

absl::StatusOr<UndersamplingOptions> FromProto(const v1::Undersampling& wire) {
  UndersamplingOptions undersampling;
  COHORT_ASSIGN_OR_RETURN(undersampling.method, FromProto(wire.method()));
  undersampling.count = wire.count();
  undersampling.share = wire.share();
  undersampling.radius = wire.radius();
  undersampling.seed = wire.seed();
  return undersampling;
}

v1::CompareOptions ToProto(const CompareOptions& compare) {
  v1::CompareOptions wire;
  wire.set_correspondence(ToProto(compare.correspondence));
  wire.set_boundary_pairs(ToProto(compare.boundary_pairs));
  wire.set_retention(ToProto(compare.retention));
  wire.set_sign(ToProto(compare.sign));
  return wire;
}

absl::StatusOr<CompareOptions> FromProto(const v1::CompareOptions& wire) {
  CompareOptions compare;
  COHORT_ASSIGN_OR_RETURN(compare.correspondence, FromProto(wire.correspondence()));
  COHORT_ASSIGN_OR_RETURN(compare.boundary_pairs, FromProto(wire.boundary_pairs()));
  COHORT_ASSIGN_OR_RETURN(compare.retention, FromProto(wire.retention()));
  COHORT_ASSIGN_OR_RETURN(compare.sign, FromProto(wire.sign()));
  return compare;
}

v1::JobSpec ToProto(const JobSpec& spec) {
  v1::JobSpec wire;
  wire.set_arithmetic(ToProto(spec.arithmetic));
  wire.set_method(ToProto(spec.method));
  wire.set_base_rule(ToProto(spec.base_rule));
  wire.set_base(spec.base);
  wire.set_rounds(spec.rounds);
  wire.set_mean_tolerance(spec.mean_tolerance);
  wire.set_pose(ToProto(spec.pose));
  *wire.mutable_icp() = ToProto(spec.icp);
  *wire.mutable_undersampling() = ToProto(spec.undersampling);
  *wire.mutable_compare() = ToProto(spec.compare);
  wire.set_retention_budget(spec.retention_budget);
  wire.set_preview(spec.preview);
  wire.set_priority(spec.priority);
  wire.set_fresh(spec.fresh);
  wire.set_reference_job(spec.reference_job);
  wire.set_metric(ToProto(spec.metric));
  wire.set_symmetrization(ToProto(spec.symmetrization));
  wire.set_neighbours(spec.neighbours);
  wire.set_position_bits(spec.position_bits);
  wire.set_size_ratio_limit(spec.size_ratio_limit);
  wire.set_landmarks_sha256(spec.landmarks.Hex());
  wire.set_symmetric_copies(spec.symmetric_copies);
  return wire;
}

absl::StatusOr<JobSpec> FromProto(const v1::JobSpec& wire) {
  JobSpec spec;
  COHORT_ASSIGN_OR_RETURN(spec.arithmetic, FromProto(wire.arithmetic()));
  COHORT_ASSIGN_OR_RETURN(spec.method, FromProto(wire.method()));
  COHORT_ASSIGN_OR_RETURN(spec.base_rule, FromProto(wire.base_rule()));
  spec.base = wire.base();
  spec.rounds = wire.rounds();
  spec.mean_tolerance = wire.mean_tolerance();
  COHORT_ASSIGN_OR_RETURN(spec.pose, FromProto(wire.pose()));
  COHORT_ASSIGN_OR_RETURN(spec.icp, FromProto(wire.icp()));
  COHORT_ASSIGN_OR_RETURN(spec.undersampling, FromProto(wire.undersampling()));
  COHORT_ASSIGN_OR_RETURN(spec.compare, FromProto(wire.compare()));
  spec.retention_budget = wire.retention_budget();
  spec.preview = wire.preview();
  spec.priority = wire.priority();
  spec.fresh = wire.fresh();
  spec.reference_job = wire.reference_job();
  COHORT_ASSIGN_OR_RETURN(spec.metric, FromProto(wire.metric()));
  COHORT_ASSIGN_OR_RETURN(spec.symmetrization, FromProto(wire.symmetrization()));
  spec.neighbours = wire.neighbours();
  spec.position_bits = wire.position_bits();
  spec.size_ratio_limit = wire.size_ratio_limit();
  COHORT_ASSIGN_OR_RETURN(spec.landmarks, OptionalDigest(wire.landmarks_sha256()));
  spec.symmetric_copies = wire.symmetric_copies();
  return spec;
}

}  // namespace cohort
