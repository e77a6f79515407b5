#include <algorithm>

#include "server/planning/block_pairs.h"
#include "server/planning/stage.h"

namespace cohort {
namespace {

// At 20,000 vertices.
constexpr double kSecondsPerPair = 1e-6;
constexpr double kSecondsPerMesh = 2e-4;  ///< To read, check and sort its field.
/// Fields of 2 x 128 meshes are in memory at a time: 30 MB at 20,000 vertices.
constexpr int64_t kMeshesPerBlock = 128;

/// Whole batches of about kMeshesPerBlock meshes: [begin, end) of each block.
struct BatchRange {
  size_t begin = 0;
  size_t end = 0;
};

std::vector<BatchRange> BlocksOf(const PlanState& state) {
  std::vector<BatchRange> blocks;
  int64_t meshes = kMeshesPerBlock;
  for (size_t i = 0; i < state.batches.size(); ++i) {
    const auto more = static_cast<int64_t>(state.batches[i].meshes.size());
    if (meshes + more > kMeshesPerBlock) {
      blocks.push_back({.begin = i, .end = i});
      meshes = 0;
    }
    meshes += more;
    blocks.back().end = i + 1;
  }
  return blocks;
}

std::vector<int32_t> MeshesOf(const PlanState& state, const BatchRange& block) {
  std::vector<int32_t> meshes;
  for (size_t i = block.begin; i < block.end; ++i) {
    const std::vector<int32_t>& more = state.batches[i].meshes;
    meshes.insert(meshes.end(), more.begin(), more.end());
  }
  return meshes;
}

/// The quick matrix from the correspondences of the variation.
class PreviewStage final : public Stage {
 public:
  [[nodiscard]] std::string Name() const override { return "preview"; }
  [[nodiscard]] int64_t TaskCount(const PlanState& state) const override {
    return BlockPairCount(static_cast<int64_t>(BlocksOf(state).size()));
  }
  [[nodiscard]] double TaskCost(const PlanState& state, int64_t /*task*/) const override {
    const auto meshes = static_cast<double>(std::min(state.ActiveCount(), kMeshesPerBlock));
    return meshes * meshes * kSecondsPerPair + 2 * meshes * kSecondsPerMesh;
  }
  [[nodiscard]] Task MakeTask(const PlanState& state, int64_t task) const override {
    const std::vector<BatchRange> blocks = BlocksOf(state);
    const auto [row, column] = BlockPairAt(static_cast<int64_t>(blocks.size()), task);
    Task made;
    made.kind = TaskKind::kPreview;
    made.meshes = state.TaskMeshes(MeshesOf(state, blocks[static_cast<size_t>(row)]));
    made.targets = state.TaskMeshes(MeshesOf(state, blocks[static_cast<size_t>(column)]));
    AddCorrespondences(state, blocks[static_cast<size_t>(row)], made);
    if (row != column) {
      AddCorrespondences(state, blocks[static_cast<size_t>(column)], made);
    }
    return made;
  }
  [[nodiscard]] absl::Status Absorb(PlanState& state,
                                    std::span<const TaskResult> results) const override {
    for (const TaskResult& result : results) {
      state.outputs.preview.push_back(result.output);
    }
    return absl::OkStatus();
  }

 private:
  static void AddCorrespondences(const PlanState& state, const BatchRange& block, Task& task) {
    for (size_t i = block.begin; i < block.end; ++i) {
      task.partials.push_back(state.batches[i].displacement);
    }
  }
};

}  // namespace

std::unique_ptr<const Stage> MakePreviewStage() {
  return std::make_unique<PreviewStage>();
}

}  // namespace cohort
