#include "common/rpc/convert.h"

#include <string>
#include <utility>

#include "common/base/status_macros.h"
#include "common/rpc/convert_enums.h"
#include "common/rpc/convert_spec.h"

namespace cohort {
namespace {

absl::StatusOr<std::array<double, 3>> PointFromProto(
    const google::protobuf::RepeatedField<double>& wire, const char* field) {
  if (wire.size() != 3) {
    return absl::InvalidArgumentError(std::string(field) + ": 3 numbers expected, got " +
                                      std::to_string(wire.size()));
  }
  return std::array<double, 3>{wire[0], wire[1], wire[2]};
}

v1::WorkCounters ToProto(const WorkCounters& counters) {
  v1::WorkCounters wire;
  wire.set_index_builds(counters.index_builds);
  wire.set_lookups(counters.lookups);
  return wire;
}

WorkCounters FromProto(const v1::WorkCounters& wire) {
  return {.index_builds = wire.index_builds(), .lookups = wire.lookups()};
}

v1::MeshHealth ToProto(const MeshHealth& health) {
  v1::MeshHealth wire;
  wire.set_vertices(health.vertices);
  wire.set_faces(health.faces);
  wire.set_duplicate_vertices(health.duplicate_vertices);
  wire.set_unreferenced_vertices(health.unreferenced_vertices);
  wire.set_degenerate_faces(health.degenerate_faces);
  wire.set_duplicate_faces(health.duplicate_faces);
  wire.set_non_manifold_edges(health.non_manifold_edges);
  wire.set_components(health.components);
  wire.set_largest_component_share(health.largest_component_share);
  wire.set_boundary_share(health.boundary_share);
  wire.set_diagonal(health.diagonal);
  wire.set_rms_radius(health.rms_radius);
  wire.set_surface_area(health.surface_area);
  wire.set_point_cloud(health.point_cloud);
  for (const std::string& warning : health.warnings) {
    wire.add_warnings(warning);
  }
  return wire;
}

MeshHealth FromProto(const v1::MeshHealth& wire) {
  MeshHealth health;
  health.vertices = wire.vertices();
  health.faces = wire.faces();
  health.duplicate_vertices = wire.duplicate_vertices();
  health.unreferenced_vertices = wire.unreferenced_vertices();
  health.degenerate_faces = wire.degenerate_faces();
  health.duplicate_faces = wire.duplicate_faces();
  health.non_manifold_edges = wire.non_manifold_edges();
  health.components = wire.components();
  health.largest_component_share = wire.largest_component_share();
  health.boundary_share = wire.boundary_share();
  health.diagonal = wire.diagonal();
  health.rms_radius = wire.rms_radius();
  health.surface_area = wire.surface_area();
  health.point_cloud = wire.point_cloud();
  health.warnings.assign(wire.warnings().begin(), wire.warnings().end());
  return health;
}

v1::Progress ToProto(const Progress& progress) {
  v1::Progress wire;
  wire.set_stage(progress.stage);
  wire.set_tasks_done(progress.tasks_done);
  wire.set_tasks_total(progress.tasks_total);
  wire.set_cost_done(progress.cost_done);
  wire.set_cost_total(progress.cost_total);
  wire.set_tasks_reused(progress.tasks_reused);
  wire.set_tasks_given_up(progress.tasks_given_up);
  wire.set_waiting_for(progress.waiting_for);
  for (const StageTime& stage : progress.stages) {
    auto* added = wire.add_stages();
    added->set_name(stage.name);
    added->set_started_unix_ms(stage.started_unix_ms);
    added->set_finished_unix_ms(stage.finished_unix_ms);
  }
  return wire;
}

Progress FromProto(const v1::Progress& wire) {
  Progress progress = {.stage = wire.stage(),
                       .tasks_done = wire.tasks_done(),
                       .tasks_total = wire.tasks_total(),
                       .cost_done = wire.cost_done(),
                       .cost_total = wire.cost_total(),
                       .stages = {},
                       .tasks_reused = wire.tasks_reused(),
                       .tasks_given_up = wire.tasks_given_up(),
                       .waiting_for = wire.waiting_for()};
  for (const v1::StageTime& stage : wire.stages()) {
    progress.stages.push_back({.name = stage.name(),
                               .started_unix_ms = stage.started_unix_ms(),
                               .finished_unix_ms = stage.finished_unix_ms()});
  }
  return progress;
}

v1::TaskMesh ToProto(const TaskMesh& mesh) {
  v1::TaskMesh wire;
  wire.set_index(mesh.index);
  wire.set_name(mesh.name);
  wire.set_sha256(mesh.blob.Hex());
  return wire;
}

absl::StatusOr<std::vector<TaskMesh>> FromProto(
    const google::protobuf::RepeatedPtrField<v1::TaskMesh>& wire) {
  std::vector<TaskMesh> meshes;
  meshes.reserve(static_cast<size_t>(wire.size()));
  for (const v1::TaskMesh& mesh : wire) {
    COHORT_ASSIGN_OR_RETURN(Digest blob, Digest::FromHex(mesh.sha256()));
    meshes.push_back({.index = mesh.index(), .name = mesh.name(), .blob = std::move(blob)});
  }
  return meshes;
}

v1::SymmetricCopy ToProto(const SymmetricCopy& copy) {
  v1::SymmetricCopy wire;
  wire.set_index(copy.index);
  wire.set_sha256(copy.blob.Hex());
  wire.set_asymmetry(copy.asymmetry);
  return wire;
}

absl::StatusOr<SymmetricCopy> FromProto(const v1::SymmetricCopy& wire) {
  SymmetricCopy copy{.index = wire.index(), .blob = {}, .asymmetry = wire.asymmetry()};
  COHORT_ASSIGN_OR_RETURN(copy.blob, Digest::FromHex(wire.sha256()));
  return copy;
}

absl::StatusOr<std::vector<Digest>> FromProto(
    const google::protobuf::RepeatedPtrField<std::string>& wire) {
  std::vector<Digest> digests;
  digests.reserve(static_cast<size_t>(wire.size()));
  for (const std::string& hex : wire) {
    COHORT_ASSIGN_OR_RETURN(Digest digest, Digest::FromHex(hex));
    digests.push_back(std::move(digest));
  }
  return digests;
}

}  // namespace

v1::Counters ToProto(const Counters& counters) {
  v1::Counters wire;
  *wire.mutable_pose() = ToProto(counters.pose);
  *wire.mutable_align() = ToProto(counters.align);
  *wire.mutable_average() = ToProto(counters.average);
  *wire.mutable_compare() = ToProto(counters.compare);
  *wire.mutable_variation() = ToProto(counters.variation);
  wire.set_pairs(counters.pairs);
  return wire;
}

Counters FromProto(const v1::Counters& wire) {
  return {.pose = FromProto(wire.pose()),
          .align = FromProto(wire.align()),
          .average = FromProto(wire.average()),
          .compare = FromProto(wire.compare()),
          .variation = FromProto(wire.variation()),
          .pairs = wire.pairs()};
}

v1::Job ToProto(const Job& job) {
  v1::Job wire;
  wire.set_id(job.id.value);
  wire.set_set(job.set);
  *wire.mutable_spec() = ToProto(job.spec);
  wire.set_state(ToProto(job.state));
  wire.set_error(job.error);
  wire.set_version(job.version);
  wire.set_created_unix_ms(job.created_unix_ms);
  wire.set_started_unix_ms(job.started_unix_ms);
  wire.set_finished_unix_ms(job.finished_unix_ms);
  wire.set_meshes(job.meshes);
  wire.set_rejected_meshes(job.rejected_meshes);
  *wire.mutable_progress() = ToProto(job.progress);
  *wire.mutable_counters() = ToProto(job.counters);
  return wire;
}

absl::StatusOr<Job> FromProto(const v1::Job& wire) {
  Job job;
  job.id = JobId{wire.id()};
  job.set = wire.set();
  COHORT_ASSIGN_OR_RETURN(job.spec, FromProto(wire.spec()));
  COHORT_ASSIGN_OR_RETURN(job.state, FromProto(wire.state()));
  job.error = wire.error();
  job.version = wire.version();
  job.created_unix_ms = wire.created_unix_ms();
  job.started_unix_ms = wire.started_unix_ms();
  job.finished_unix_ms = wire.finished_unix_ms();
  job.meshes = wire.meshes();
  job.rejected_meshes = wire.rejected_meshes();
  job.progress = FromProto(wire.progress());
  job.counters = FromProto(wire.counters());
  return job;
}

v1::SetMesh ToProto(const SetMesh& mesh) {
  v1::SetMesh wire;
  wire.set_name(mesh.name);
  wire.set_sha256(mesh.raw.Hex());
  wire.set_size_bytes(mesh.size_bytes);
  wire.mutable_labels()->insert(mesh.labels.begin(), mesh.labels.end());
  return wire;
}

absl::StatusOr<SetMesh> FromProto(const v1::SetMesh& wire) {
  SetMesh mesh;
  mesh.name = wire.name();
  COHORT_ASSIGN_OR_RETURN(mesh.raw, Digest::FromHex(wire.sha256()));
  mesh.size_bytes = wire.size_bytes();
  mesh.labels.insert(wire.labels().begin(), wire.labels().end());
  return mesh;
}

v1::IngestedMesh ToProto(const IngestedMesh& mesh) {
  v1::IngestedMesh wire;
  wire.set_index(mesh.index);
  wire.set_sha256(mesh.blob.Hex());
  wire.set_vertices(mesh.vertices);
  wire.set_faces(mesh.faces);
  wire.mutable_centroid()->Add(mesh.centroid.begin(), mesh.centroid.end());
  *wire.mutable_health() = ToProto(mesh.health);
  return wire;
}

absl::StatusOr<IngestedMesh> FromProto(const v1::IngestedMesh& wire) {
  IngestedMesh mesh;
  mesh.index = wire.index();
  COHORT_ASSIGN_OR_RETURN(mesh.blob, Digest::FromHex(wire.sha256()));
  mesh.vertices = wire.vertices();
  mesh.faces = wire.faces();
  COHORT_ASSIGN_OR_RETURN(mesh.centroid, PointFromProto(wire.centroid(), "centroid"));
  mesh.health = FromProto(wire.health());
  return mesh;
}

v1::JobMesh ToProto(const JobMesh& mesh) {
  v1::JobMesh wire;
  *wire.mutable_mesh() = ToProto(mesh.mesh);
  if (mesh.ingested) {
    *wire.mutable_ingested() = ToProto(*mesh.ingested);
  }
  if (mesh.copy) {
    *wire.mutable_copy() = ToProto(*mesh.copy);
  }
  wire.set_rejection(mesh.rejection);
  return wire;
}

absl::StatusOr<JobMesh> FromProto(const v1::JobMesh& wire) {
  JobMesh mesh;
  COHORT_ASSIGN_OR_RETURN(mesh.mesh, FromProto(wire.mesh()));
  if (wire.has_ingested()) {
    COHORT_ASSIGN_OR_RETURN(mesh.ingested, FromProto(wire.ingested()));
  }
  if (wire.has_copy()) {
    COHORT_ASSIGN_OR_RETURN(mesh.copy, FromProto(wire.copy()));
  }
  mesh.rejection = wire.rejection();
  return mesh;
}

v1::Lease ToProto(const Lease& lease) {
  v1::Lease wire;
  wire.set_job(lease.task.job.value);
  wire.set_task(lease.task.number);
  wire.set_epoch(lease.epoch);
  return wire;
}

Lease FromProto(const v1::Lease& wire) {
  return {.task = {.job = JobId{wire.job()}, .number = wire.task()}, .epoch = wire.epoch()};
}

v1::Task ToProto(const Task& task) {
  v1::Task wire;
  wire.set_kind(ToProto(task.kind));
  wire.set_number(task.number);
  wire.set_stage(task.stage);
  wire.set_cost(task.cost);
  for (const TaskMesh& mesh : task.meshes) {
    *wire.add_meshes() = ToProto(mesh);
  }
  for (const TaskMesh& mesh : task.targets) {
    *wire.add_targets() = ToProto(mesh);
  }
  wire.set_reference_sha256(task.reference.Hex());
  for (const Digest& digest : task.alignments) {
    wire.add_alignment_sha256(digest.Hex());
  }
  wire.set_starts(task.starts);
  for (const Digest& digest : task.partials) {
    wire.add_partial_sha256(digest.Hex());
  }
  *wire.mutable_icp() = ToProto(task.icp);
  *wire.mutable_undersampling() = ToProto(task.undersampling);
  *wire.mutable_compare() = ToProto(task.compare);
  wire.set_position_bits(task.position_bits);
  wire.set_arithmetic(ToProto(task.arithmetic));
  wire.set_wants_placed(task.wants_placed);
  wire.set_wants_pose(task.wants_pose);
  wire.set_wants_displacement(task.wants_displacement);
  wire.set_wants_variation(task.wants_variation);
  wire.set_wants_correspondences(task.wants_correspondences);
  wire.set_counts_reference_index(task.counts_reference_index);
  wire.set_moves_reference(task.moves_reference);
  wire.mutable_frame_center()->Add(task.frame_center.begin(), task.frame_center.end());
  wire.set_landmarks_sha256(task.landmarks.Hex());
  return wire;
}

absl::StatusOr<Task> FromProto(const v1::Task& wire) {
  Task task;
  COHORT_ASSIGN_OR_RETURN(task.kind, FromProto(wire.kind()));
  task.number = wire.number();
  task.stage = wire.stage();
  task.cost = wire.cost();
  COHORT_ASSIGN_OR_RETURN(task.meshes, FromProto(wire.meshes()));
  COHORT_ASSIGN_OR_RETURN(task.targets, FromProto(wire.targets()));
  COHORT_ASSIGN_OR_RETURN(task.reference, OptionalDigest(wire.reference_sha256()));
  COHORT_ASSIGN_OR_RETURN(task.alignments, FromProto(wire.alignment_sha256()));
  task.starts = wire.starts();
  COHORT_ASSIGN_OR_RETURN(task.partials, FromProto(wire.partial_sha256()));
  COHORT_ASSIGN_OR_RETURN(task.icp, FromProto(wire.icp()));
  COHORT_ASSIGN_OR_RETURN(task.undersampling, FromProto(wire.undersampling()));
  COHORT_ASSIGN_OR_RETURN(task.compare, FromProto(wire.compare()));
  task.position_bits = wire.position_bits();
  COHORT_ASSIGN_OR_RETURN(task.arithmetic, FromProto(wire.arithmetic()));
  task.wants_placed = wire.wants_placed();
  task.wants_pose = wire.wants_pose();
  task.wants_displacement = wire.wants_displacement();
  task.wants_variation = wire.wants_variation();
  task.wants_correspondences = wire.wants_correspondences();
  task.counts_reference_index = wire.counts_reference_index();
  task.moves_reference = wire.moves_reference();
  COHORT_ASSIGN_OR_RETURN(task.frame_center, PointFromProto(wire.frame_center(), "frame_center"));
  COHORT_ASSIGN_OR_RETURN(task.landmarks, OptionalDigest(wire.landmarks_sha256()));
  return task;
}

v1::TaskResult ToProto(const TaskResult& result) {
  v1::TaskResult wire;
  wire.set_output_sha256(result.output.Hex());
  wire.set_alignments(result.alignments);
  wire.set_second_output_sha256(result.second_output.Hex());
  wire.set_poses_sha256(result.poses.Hex());
  wire.set_variation_sha256(result.variation.Hex());
  for (const IngestedMesh& mesh : result.ingested) {
    *wire.add_ingested() = ToProto(mesh);
  }
  for (const SymmetricCopy& copy : result.copies) {
    *wire.add_copies() = ToProto(copy);
  }
  for (const MeshRejection& rejection : result.rejections) {
    auto* added = wire.add_rejections();
    added->set_index(rejection.index);
    added->set_reason(rejection.reason);
  }
  *wire.mutable_counters() = ToProto(result.counters);
  wire.set_seconds(result.seconds);
  wire.set_placed_sha256(result.placed.Hex());
  wire.set_fields_sha256(result.fields.Hex());
  wire.set_change(result.change);
  wire.set_base(result.base);
  return wire;
}

absl::StatusOr<TaskResult> FromProto(const v1::TaskResult& wire) {
  TaskResult result;
  COHORT_ASSIGN_OR_RETURN(result.output, OptionalDigest(wire.output_sha256()));
  result.alignments = wire.alignments();
  COHORT_ASSIGN_OR_RETURN(result.second_output, OptionalDigest(wire.second_output_sha256()));
  COHORT_ASSIGN_OR_RETURN(result.poses, OptionalDigest(wire.poses_sha256()));
  COHORT_ASSIGN_OR_RETURN(result.variation, OptionalDigest(wire.variation_sha256()));
  for (const v1::IngestedMesh& mesh : wire.ingested()) {
    COHORT_ASSIGN_OR_RETURN(IngestedMesh ingested, FromProto(mesh));
    result.ingested.push_back(std::move(ingested));
  }
  for (const v1::SymmetricCopy& wire_copy : wire.copies()) {
    COHORT_ASSIGN_OR_RETURN(SymmetricCopy copy, FromProto(wire_copy));
    result.copies.push_back(std::move(copy));
  }
  for (const v1::MeshRejection& rejection : wire.rejections()) {
    result.rejections.push_back({.index = rejection.index(), .reason = rejection.reason()});
  }
  result.counters = FromProto(wire.counters());
  result.seconds = wire.seconds();
  COHORT_ASSIGN_OR_RETURN(result.placed, OptionalDigest(wire.placed_sha256()));
  COHORT_ASSIGN_OR_RETURN(result.fields, OptionalDigest(wire.fields_sha256()));
  result.change = wire.change();
  result.base = wire.base();
  return result;
}

}  // namespace cohort
