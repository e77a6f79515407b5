#include "common/rpc/convert_estimate.h"

#include "common/base/status_macros.h"
#include "common/rpc/convert_enums.h"

namespace cohort {

v1::Estimate ToProto(const Estimate& estimate) {
  v1::Estimate wire;
  wire.set_meshes(estimate.meshes);
  wire.set_pairs(estimate.pairs);
  for (const StageEstimate& stage : estimate.stages) {
    v1::StageEstimate* added = wire.add_stages();
    added->set_name(stage.name);
    added->set_tasks(stage.tasks);
    added->set_core_seconds(stage.core_seconds);
    added->set_measured(stage.is_measured);
  }
  wire.set_slots(estimate.slots);
  wire.set_wall_seconds(estimate.wall_seconds);
  wire.set_retention(ToProto(estimate.retention));
  for (const auto& [retention, bytes] : estimate.distance_bytes) {
    v1::RetentionBytes* added = wire.add_distance_bytes();
    added->set_retention(ToProto(retention));
    added->set_size_bytes(bytes);
  }
  wire.set_other_bytes(estimate.other_bytes);
  if (estimate.free_bytes) {
    wire.set_free_bytes(*estimate.free_bytes);
  }
  wire.set_average_core_seconds(estimate.average_core_seconds);
  return wire;
}

absl::StatusOr<Estimate> FromProto(const v1::Estimate& wire) {
  Estimate estimate;
  estimate.meshes = wire.meshes();
  estimate.pairs = wire.pairs();
  for (const v1::StageEstimate& stage : wire.stages()) {
    estimate.stages.push_back({.name = stage.name(),
                               .tasks = stage.tasks(),
                               .core_seconds = stage.core_seconds(),
                               .is_measured = stage.measured()});
  }
  estimate.slots = wire.slots();
  estimate.wall_seconds = wire.wall_seconds();
  COHORT_ASSIGN_OR_RETURN(estimate.retention, FromProto(wire.retention()));
  for (const v1::RetentionBytes& bytes : wire.distance_bytes()) {
    COHORT_ASSIGN_OR_RETURN(const Retention retention, FromProto(bytes.retention()));
    estimate.distance_bytes[retention] = bytes.size_bytes();
  }
  estimate.other_bytes = wire.other_bytes();
  if (wire.has_free_bytes()) {
    estimate.free_bytes = wire.free_bytes();
  }
  estimate.average_core_seconds = wire.average_core_seconds();
  return estimate;
}

}  // namespace cohort
