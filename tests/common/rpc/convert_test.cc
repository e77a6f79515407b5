#include "common/rpc/convert.h"

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "common/jobs/fidentis_spec.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::IsOk;
using testing::StatusIs;

JobSpec UnusualSpec() {
  JobSpec spec;
  spec.method = Method::kEach;
  spec.base = "b.ply";
  spec.rounds = 7;
  spec.pose = PoseMode::kNone;
  spec.icp = {.scale_mode = ScaleMode::kOff,
              .scale_limit = 1.5,
              .rigid_first = false,
              .max_iterations = 11,
              .tolerance = 0.1,
              .acceleration = Acceleration::kNone,
              .trimmed_share = 0.2,
              .distance_limit = 9,
              .boundary_pairs = BoundaryPairs::kReject,
              .correspondence = Correspondence::kSurface};
  spec.undersampling = {
      .method = UndersamplingMethod::kDisk, .count = 5, .share = 0.3, .radius = 4, .seed = 99};
  spec.compare = {.correspondence = Correspondence::kSurface,
                  .boundary_pairs = BoundaryPairs::kReject,
                  .retention = Retention::kSketch};
  spec.mean_tolerance = 0.5;
  spec.retention_budget = 77;
  spec.metric = Metric::kPercentile75;
  spec.symmetrization = Symmetrization::kDirected;
  spec.neighbours = 5;
  spec.position_bits = 14;
  spec.size_ratio_limit = 2.5;
  spec.landmarks = Sha256::Of("landmarks");
  spec.symmetric_copies = true;
  return spec;
}

IngestedMesh UnusualIngested() {
  IngestedMesh mesh;
  mesh.index = 3;
  mesh.blob = Sha256::Of("canonical");
  mesh.vertices = 10;
  mesh.faces = 20;
  mesh.centroid = {1.0 / 3, -2, 1e-9};
  mesh.health.vertices = 11;
  mesh.health.boundary_share = 0.25;
  mesh.health.rms_radius = 55.5;
  mesh.health.point_cloud = true;
  mesh.health.warnings = {"one", "two"};
  return mesh;
}

TEST(Convert, AJobSpecSurvivesTheWay) {
  const auto back = FromProto(ToProto(UnusualSpec()));
  ASSERT_THAT(back, IsOk());
  EXPECT_EQ(ToJson(*back), ToJson(UnusualSpec()));
}

TEST(Convert, AJobSpecOfThePredecessorSurvivesTheWay) {
  JobSpec spec = FidentisSpec(Method::kOne);
  spec.compare.sign = DistanceSign::kSigned;
  const auto back = FromProto(ToProto(spec));
  ASSERT_THAT(back, IsOk());
  EXPECT_EQ(ToJson(*back), ToJson(spec));
  EXPECT_EQ(back->arithmetic, Arithmetic::kFidentis);
}

TEST(Convert, ATaskSurvivesTheWay) {
  Task task;
  task.kind = TaskKind::kCompare;
  task.number = 42;
  task.stage = "compare";
  task.cost = 1.5;
  task.meshes = {{.index = 1, .name = "a", .blob = Sha256::Of("a")}};
  task.targets = {{.index = 2, .name = "b", .blob = Sha256::Of("b")}};
  task.reference = Sha256::Of("r");
  task.alignments = {Sha256::Of("x"), Sha256::Of("y")};
  task.starts = std::string("\0starts\xff", 8);
  task.partials = {Sha256::Of("z")};
  task.icp = UnusualSpec().icp;
  task.undersampling = UnusualSpec().undersampling;
  task.compare = UnusualSpec().compare;
  task.position_bits = 12;
  task.arithmetic = Arithmetic::kFidentis;
  task.wants_placed = true;
  task.wants_pose = true;
  task.wants_displacement = true;
  task.wants_variation = true;
  task.wants_correspondences = true;
  task.counts_reference_index = true;
  task.moves_reference = true;
  task.frame_center = {0.1, 0.2, 0.3};
  task.landmarks = Sha256::Of("landmarks");
  const auto back = FromProto(ToProto(task));
  ASSERT_THAT(back, IsOk());
  EXPECT_EQ(ToProto(*back).SerializeAsString(), ToProto(task).SerializeAsString());
  EXPECT_EQ(back->meshes, task.meshes);
  EXPECT_EQ(back->alignments, task.alignments);
  EXPECT_EQ(back->starts, task.starts);
  EXPECT_EQ(back->frame_center, task.frame_center);
  EXPECT_EQ(back->icp.tolerance, task.icp.tolerance);
  EXPECT_EQ(back->undersampling.radius, task.undersampling.radius);
  EXPECT_EQ(back->compare, task.compare);
  EXPECT_EQ(back->arithmetic, Arithmetic::kFidentis);
  EXPECT_TRUE(back->wants_placed);
  EXPECT_TRUE(back->wants_pose);
  EXPECT_TRUE(back->wants_displacement);
  EXPECT_TRUE(back->wants_variation);
  EXPECT_TRUE(back->wants_correspondences);
  EXPECT_EQ(back->landmarks, task.landmarks);
}

TEST(Convert, ATaskResultSurvivesTheWay) {
  TaskResult result;
  result.output = Sha256::Of("out");
  result.alignments = std::string("\0alignments\xff", 12);
  result.poses = Sha256::Of("poses");
  result.variation = Sha256::Of("variation");
  result.ingested = {UnusualIngested()};
  result.copies = {{.index = 7, .blob = Sha256::Of("copy"), .asymmetry = 0.3}};
  result.rejections = {{.index = 4, .reason = "broken"}};
  result.counters.align = {.index_builds = 1, .lookups = 2};
  result.counters.pairs = 9;
  result.seconds = 0.5;
  result.placed = Sha256::Of("placed");
  result.fields = Sha256::Of("fields");
  result.change = 0.25;
  result.base = 3;
  const auto back = FromProto(ToProto(result));
  ASSERT_THAT(back, IsOk());
  EXPECT_EQ(ToJson(*back), ToJson(result));
}

TEST(Convert, AJobAndItsMeshesSurviveTheWay) {
  Job job;
  job.id = JobId{"j-1"};
  job.set = "set";
  job.spec = UnusualSpec();
  job.state = JobState::kFailed;
  job.error = "why";
  job.version = 5;
  job.created_unix_ms = 1;
  job.started_unix_ms = 2;
  job.finished_unix_ms = 3;
  job.meshes = 4;
  job.rejected_meshes = 1;
  job.progress = {.stage = "pose",
                  .tasks_done = 1,
                  .tasks_total = 2,
                  .cost_done = 3,
                  .cost_total = 4,
                  .stages = {{.name = "ingest", .started_unix_ms = 5, .finished_unix_ms = 6}},
                  .waiting_for = "space"};
  const auto back = FromProto(ToProto(job));
  ASSERT_THAT(back, IsOk());
  EXPECT_EQ(back->progress.stages, job.progress.stages);
  EXPECT_EQ(back->progress.waiting_for, "space");
  EXPECT_EQ(ToProto(*back).SerializeAsString(), ToProto(job).SerializeAsString());
  JobMesh mesh;
  mesh.mesh = {
      .name = "a.ply", .raw = Sha256::Of("raw"), .size_bytes = 3, .labels = {{"person", "p"}}};
  mesh.ingested = UnusualIngested();
  mesh.copy = SymmetricCopy{.index = 3, .blob = Sha256::Of("copy"), .asymmetry = 0.25};
  mesh.rejection = "late";
  const auto mesh_back = FromProto(ToProto(mesh));
  ASSERT_THAT(mesh_back, IsOk());
  EXPECT_EQ(mesh_back->mesh.labels, mesh.mesh.labels);
  EXPECT_EQ(mesh_back->ingested->health.warnings, mesh.ingested->health.warnings);
  EXPECT_EQ(mesh_back->rejection, "late");
  EXPECT_EQ(mesh_back->copy, mesh.copy);
}

TEST(Convert, UnknownEnumerationsAndDigestsAreNamed) {
  v1::JobSpec spec = ToProto(UnusualSpec());
  spec.set_method(v1::METHOD_UNSPECIFIED);
  EXPECT_THAT(FromProto(spec), StatusIs(absl::StatusCode::kInvalidArgument, "method"));
  spec = ToProto(UnusualSpec());
  spec.set_metric(static_cast<v1::Metric>(99));
  EXPECT_THAT(FromProto(spec), StatusIs(absl::StatusCode::kInvalidArgument, "metric: value 99"));
  v1::SetMesh mesh;
  mesh.set_sha256("abc");
  EXPECT_THAT(FromProto(mesh), StatusIs(absl::StatusCode::kInvalidArgument, "abc"));
  v1::IngestedMesh ingested = ToProto(UnusualIngested());
  ingested.mutable_centroid()->RemoveLast();
  EXPECT_THAT(FromProto(ingested), StatusIs(absl::StatusCode::kInvalidArgument, "centroid"));
}

}  // namespace
}  // namespace cohort
