// The preview matrix through plan and tasks, held against correspondences found by brute force.
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include <gmock/gmock.h>

#include "common/jobs/blobs.h"
#include "common/jobs/preview_blobs.h"
#include "common/store/memory_blob_store.h"
#include "common/store/mesh_blob.h"
#include "tests/testing/demo_scans.h"
#include "tests/testing/status_matchers.h"
#include "tests/worker/tasks/run_job.h"

namespace cohort {
namespace {

using testing::FinishedJob;
using testing::IsOk;
using testing::Order;
using testing::QuickSpec;
using testing::RmsOfPairs;
using testing::RunJob;
using testing::StatusIs;

using PairValues = std::map<std::pair<int, int>, double>;

PairValues PreviewOf(const FinishedJob& job, BlobStore& store) {
  PairValues pairs;
  for (const Digest& blob : job.plan->Outputs().preview) {
    const std::string bytes = *store.Get(blob);
    const PreviewBlock block = *DecodePreviewBlob(bytes);
    for (size_t r = 0; r < block.rows.size(); ++r) {
      for (size_t c = 0; c < block.columns.size(); ++c) {
        const double value = block.values[r * block.columns.size() + c];
        pairs[{block.rows[r], block.columns[c]}] = value;
        pairs[{block.columns[c], block.rows[r]}] = value;
      }
    }
  }
  return pairs;
}

JobSpec SpecWithPreview(Method method) {
  JobSpec spec = QuickSpec(method);
  spec.preview = true;
  return spec;
}

/// The nearest vertex of `mesh` to each vertex of the reference, by looking at all.
Eigen::Matrix3Xd PartnersByBruteForce(const Eigen::Matrix3Xd& reference,
                                      const Eigen::Matrix3Xd& mesh) {
  Eigen::Matrix3Xd partners(3, reference.cols());
  for (Eigen::Index k = 0; k < reference.cols(); ++k) {
    Eigen::Index nearest = 0;
    (mesh.colwise() - reference.col(k)).colwise().squaredNorm().minCoeff(&nearest);
    partners.col(k) = mesh.col(nearest);
  }
  return partners;
}

TEST(Preview, IsTheRmsOverTheCorrespondingPointsOfTheBase) {
  MemoryBlobStore store;
  const auto meshes = testing::PutDemoScans(store, 4, 1);
  const FinishedJob job = RunJob(SpecWithPreview(Method::kOne), meshes, store);
  ASSERT_THAT(job.status, IsOk());
  const auto& inputs = job.plan->Meshes();
  std::map<int32_t, Similarity> poses;
  for (const Digest& blob : job.plan->Outputs().alignments) {
    const auto alignments = *DecodeAlignmentBlob(*store.Get(blob));
    for (const MeshAlignment& item : alignments) {
      poses[item.mesh] = item.alignment.T_target_source;
    }
  }
  const TriangleMesh base = *DecodeMeshBlob(*store.Get(inputs[0].ingested->blob));
  std::vector<Eigen::Matrix3Xd> partners;
  for (int32_t mesh = 0; mesh < 4; ++mesh) {
    const TriangleMesh shape =
        *DecodeMeshBlob(*store.Get(inputs[static_cast<size_t>(mesh)].ingested->blob));
    partners.push_back(PartnersByBruteForce(base.vertices, poses[mesh].Apply(shape.vertices)));
  }
  double largest = 0;
  for (const Eigen::Matrix3Xd& points : partners) {
    largest = std::max(largest, (points - base.vertices).cwiseAbs().maxCoeff());
  }
  const PairValues preview = PreviewOf(job, store);
  ASSERT_EQ(preview.size(), 16U);
  for (const auto& [pair, value] : preview) {
    const Eigen::Matrix3Xd difference =
        partners[static_cast<size_t>(pair.first)] - partners[static_cast<size_t>(pair.second)];
    const double truth =
        std::sqrt(difference.squaredNorm() / static_cast<double>(base.VertexCount()));
    // The error that corresponded_rms.h states, of two meshes of the same size.
    const double bound = 2 * largest / 4700;
    EXPECT_NEAR(value, truth, bound) << pair.first << ", " << pair.second;
  }
}

TEST(Preview, ChangesNoOtherResult) {
  for (const Method method : {Method::kAverage, Method::kOne, Method::kNone}) {
    MemoryBlobStore store;
    const auto meshes = testing::PutDemoScans(store, 3, 1);
    const FinishedJob with = RunJob(SpecWithPreview(method), meshes, store, Order::kBackward);
    const FinishedJob without = RunJob(QuickSpec(method), meshes, store);
    ASSERT_THAT(with.status, IsOk());
    ASSERT_THAT(without.status, IsOk());
    EXPECT_EQ(RmsOfPairs(with, store), RmsOfPairs(without, store));
    EXPECT_EQ(with.plan->Outputs().summary, without.plan->Outputs().summary);
    EXPECT_TRUE(without.plan->Outputs().preview.empty());
  }
}

TEST(Preview, IsThereBeforeTheComparisonBegins) {
  MemoryBlobStore store;
  const auto meshes = testing::PutDemoScans(store, 3, 1);
  const auto plan = *JobPlan::Create(SpecWithPreview(Method::kNone), meshes, {});
  MeshCache cache(store, 1 << 20);
  TaskRunner runner(store, cache);
  bool saw_compare = false;
  for (std::vector<Task> ready = plan->TakeReadyTasks(); !ready.empty();
       ready = plan->TakeReadyTasks()) {
    for (const Task& task : ready) {
      if (task.kind == TaskKind::kCompare) {
        saw_compare = true;
        EXPECT_FALSE(plan->Outputs().preview.empty());
        EXPECT_TRUE(plan->Outputs().tiles.empty());
      }
      ASSERT_THAT(plan->TaskFinished(task.number, *runner.Run(task, {})), IsOk());
    }
  }
  EXPECT_TRUE(saw_compare);
}

TEST(Preview, NeedsACommonReference) {
  EXPECT_THAT(SpecWithPreview(Method::kEach).Validate(),
              StatusIs(absl::StatusCode::kInvalidArgument, "preview"));
}

TEST(Preview, AMissingCorrespondenceIsNamed) {
  MemoryBlobStore store;
  CorrespondencePart part{.meshes = {1}, .fields = DisplacementFields(2)};
  part.fields.Add(Eigen::Matrix3Xf::Zero(3, 2));
  Task task;
  task.kind = TaskKind::kPreview;
  task.meshes = {{.index = 5, .name = "face5.ply", .blob = {}}};
  task.targets = task.meshes;
  task.partials = {*store.Put(EncodeCorrespondenceBlob(part))};
  MeshCache cache(store, 1 << 20);
  const auto result = TaskRunner(store, cache).Run(task, {});
  EXPECT_THAT(result, StatusIs(absl::StatusCode::kDataLoss, "face5.ply"));
}

}  // namespace
}  // namespace cohort
