#include <algorithm>
#include <cmath>
#include <utility>

#include "server/planning/stage.h"

namespace cohort {
namespace {

constexpr double kSecondsPerLookup = 3e-7;
constexpr int kExpectedIterations = 60;
constexpr int64_t kBlocksPerSide = 12;  ///< Enough tiles to keep some dozens of workers busy,
constexpr int64_t kMaxBlockSize = 32;   ///< more if they would grow beyond this.

/// All unordered pairs of `blocks` blocks, each block with itself too, row by row:
/// (0,0) (0,1) ... (0,n-1) (1,1) ...
/// @return the pair at `place`. Counted from the end, rows have 1, 2, 3, ... pairs.
std::pair<int64_t, int64_t> BlockPair(int64_t blocks, int64_t place) {
  const int64_t from_end = blocks * (blocks + 1) / 2 - 1 - place;
  auto row_from_end =
      static_cast<int64_t>((std::sqrt(8 * static_cast<double>(from_end) + 1) - 1) / 2);
  while (row_from_end * (row_from_end + 1) / 2 > from_end) {
    --row_from_end;
  }
  while ((row_from_end + 1) * (row_from_end + 2) / 2 <= from_end) {
    ++row_from_end;
  }
  const int64_t column_from_end = from_end - row_from_end * (row_from_end + 1) / 2;
  return {blocks - 1 - row_from_end, blocks - 1 - column_from_end};
}

int64_t BlockSize(const PlanState& state) {
  return std::clamp<int64_t>((state.ActiveCount() + kBlocksPerSide - 1) / kBlocksPerSide, 1,
                             kMaxBlockSize);
}

int64_t BlockCount(const PlanState& state) {
  return (state.ActiveCount() + BlockSize(state) - 1) / BlockSize(state);
}

std::vector<int32_t> BlockAt(const PlanState& state, int64_t block) {
  const int64_t begin = block * BlockSize(state);
  const int64_t end = std::min(begin + BlockSize(state), state.ActiveCount());
  return {state.active.begin() + begin, state.active.begin() + end};
}

/// Tiles of pairs of aligned meshes, both directions each.
class CompareStage final : public Stage {
 public:
  [[nodiscard]] std::string Name() const override { return "compare"; }

  [[nodiscard]] int64_t TaskCount(const PlanState& state) const override {
    return BlockCount(state) * (BlockCount(state) + 1) / 2;
  }

  [[nodiscard]] double TaskCost(const PlanState& state, int64_t task) const override {
    const auto [row, column] = BlockPair(BlockCount(state), task);
    const std::vector<int32_t> rows = BlockAt(state, row);
    const std::vector<int32_t> columns = BlockAt(state, column);
    double lookups = state.VerticesOf(rows) * static_cast<double>(columns.size());
    if (row != column) {
      lookups += state.VerticesOf(columns) * static_cast<double>(rows.size());
    }
    return lookups * kSecondsPerLookup;
  }

  [[nodiscard]] Task MakeTask(const PlanState& state, int64_t task) const override {
    const auto [row, column] = BlockPair(BlockCount(state), task);
    const std::vector<int32_t> rows = BlockAt(state, row);
    const std::vector<int32_t> columns = BlockAt(state, column);
    std::vector<int32_t> both = rows;
    if (row != column) {
      both.insert(both.end(), columns.begin(), columns.end());
    }
    Task made;
    made.kind = TaskKind::kCompare;
    made.meshes = state.TaskMeshes(rows);
    made.targets = state.TaskMeshes(columns);
    made.alignments = state.AlignmentsOf(both);
    made.frame_center = state.meshes[static_cast<size_t>(state.base)].ingested->centroid;
    return made;
  }

  [[nodiscard]] absl::Status Absorb(PlanState& state,
                                    std::span<const TaskResult> results) const override {
    for (const TaskResult& result : results) {
      state.outputs.tiles.push_back(result.output);
    }
    for (const Batch& batch : state.batches) {
      if (!batch.alignment.empty()) {
        state.outputs.alignments.push_back(batch.alignment);
      }
    }
    return absl::OkStatus();
  }
};

/// Method each: all meshes are aligned to one target and measured against it, for every target.
class AlignAndCompareStage final : public Stage {
 public:
  [[nodiscard]] std::string Name() const override { return "compare"; }

  [[nodiscard]] int64_t TaskCount(const PlanState& state) const override {
    return state.ActiveCount();
  }

  [[nodiscard]] double TaskCost(const PlanState& state, int64_t /*task*/) const override {
    const int iterations = std::min(state.spec.icp.max_iterations, kExpectedIterations);
    return state.VerticesOf(state.active) * (iterations + 1) * kSecondsPerLookup;
  }

  [[nodiscard]] Task MakeTask(const PlanState& state, int64_t task) const override {
    Task made;
    made.kind = TaskKind::kAlignAndCompare;
    made.meshes = state.TaskMeshes(state.active);
    made.targets = state.TaskMeshes({state.active[static_cast<size_t>(task)]});
    made.alignments = state.AlignmentsOf(state.active);
    made.icp = state.spec.icp;
    made.counts_reference_index = true;
    return made;
  }

  [[nodiscard]] absl::Status Absorb(PlanState& state,
                                    std::span<const TaskResult> results) const override {
    for (size_t i = 0; i < results.size(); ++i) {
      state.outputs.tiles.push_back(results[i].output);
      if (state.active[i] == state.base) {
        state.outputs.alignments = {results[i].second_output};
      }
    }
    // One blob holds all alignments to the base.
    for (Batch& batch : state.batches) {
      batch.alignment = state.outputs.alignments.front();
    }
    return absl::OkStatus();
  }
};

}  // namespace

std::unique_ptr<const Stage> MakeCompareStage() {
  return std::make_unique<CompareStage>();
}

std::unique_ptr<const Stage> MakeAlignAndCompareStage() {
  return std::make_unique<AlignAndCompareStage>();
}

}  // namespace cohort
