// Jobs over symmetric copies of their meshes.
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "common/geometry/registration/mirror.h"
#include "common/store/memory_blob_store.h"
#include "common/store/mesh_blob.h"
#include "tests/testing/demo_scans.h"
#include "tests/testing/status_matchers.h"
#include "tests/worker/tasks/run_job.h"

namespace cohort {
namespace {

using testing::FinishedJob;
using ::testing::HasSubstr;
using testing::IsOk;
using testing::Order;
using testing::QuickSpec;
using testing::RunJob;

JobSpec SymmetricSpec(Method method) {
  JobSpec spec = QuickSpec(method);
  spec.symmetric_copies = true;
  return spec;
}

TEST(SymmetricCopies, AreThoseOfTheCanonicalMeshes) {
  MemoryBlobStore store;
  const auto meshes = testing::PutDemoScans(store, 3, 1, 2500);
  const FinishedJob job = RunJob(SymmetricSpec(Method::kOne), meshes, store);
  ASSERT_THAT(job.status, IsOk());
  PacketSearch search;
  for (const JobMesh& mesh : job.plan->Meshes()) {
    const TriangleMesh original = *DecodeMeshBlob(*store.Get(mesh.ingested->blob));
    const auto expected = MakeSymmetric(original, {}, search);
    ASSERT_THAT(expected, IsOk());
    ASSERT_TRUE(mesh.copy.has_value());
    EXPECT_EQ(mesh.copy->asymmetry, expected->asymmetry);
    EXPECT_GT(mesh.copy->asymmetry, 0.05);
    const TriangleMesh copy = *DecodeMeshBlob(*store.Get(mesh.copy->blob));
    EXPECT_EQ(copy.vertices, expected->mesh.vertices);
    // Less than a third of the asymmetry is left.
    EXPECT_LT(MakeSymmetric(copy, {}, search)->asymmetry, expected->asymmetry / 3);
  }
}

TEST(SymmetricCopies, AreWhatEveryMethodMeasures) {
  for (const Method method : {Method::kAverage, Method::kOne, Method::kEach, Method::kNone}) {
    MemoryBlobStore store;
    const auto meshes = testing::PutDemoScans(store, 3, 1);
    const FinishedJob forward = RunJob(SymmetricSpec(method), meshes, store);
    const FinishedJob backward = RunJob(SymmetricSpec(method), meshes, store, Order::kBackward);
    const FinishedJob plain = RunJob(QuickSpec(method), meshes, store);
    ASSERT_THAT(forward.status, IsOk());
    EXPECT_EQ(forward.plan->Outputs().tiles, backward.plan->Outputs().tiles);
    EXPECT_EQ(forward.plan->Outputs().mean_shape, backward.plan->Outputs().mean_shape);
    EXPECT_NE(forward.plan->Outputs().tiles, plain.plan->Outputs().tiles);
    EXPECT_NE(forward.plan->Outputs().mean_shape, plain.plan->Outputs().mean_shape);
  }
}

TEST(SymmetricCopies, AreQuarantinedWhereTheMirrorImageCannotBeAligned) {
  MemoryBlobStore store;
  const auto meshes = testing::PutDemoScans(store, 2, 1);
  JobSpec spec = SymmetricSpec(Method::kOne);
  spec.icp.distance_limit = 1e-9;  // No pair counts.
  const std::unique_ptr<JobPlan> plan = *JobPlan::Create(spec, meshes, {});
  MeshCache cache(store, 1 << 20);
  TaskRunner runner(store, cache);
  for (const Task& task : plan->TakeReadyTasks()) {
    ASSERT_THAT(plan->TaskFinished(task.number, *runner.Run(task, {})), IsOk());
  }
  const Task task = plan->TakeReadyTasks().at(0);
  ASSERT_EQ(task.kind, TaskKind::kSymmetrize);
  const auto result = runner.Run(task, {});
  ASSERT_THAT(result, IsOk());
  EXPECT_TRUE(result->copies.empty());
  ASSERT_EQ(result->rejections.size(), 1u);
  EXPECT_THAT(result->rejections[0].reason, HasSubstr(meshes[0].name + ": no symmetric copy: "));
}

}  // namespace
}  // namespace cohort
