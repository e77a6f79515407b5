#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "server/planning/block_pairs.h"
#include "server/planning/kept_bytes.h"
#include "server/planning/stage.h"

namespace cohort {
namespace {

constexpr double kSecondsPerLookup = 1.8e-8;
constexpr double kFidentisSecondsPerLookup = 4e-7;
constexpr int kExpectedIterations = 35;
constexpr int64_t kBlocksPerSide = 24;      ///< Tiles for some hundreds of slots,
constexpr double kLeastTileSeconds = 0.08;  ///< unless they would be over sooner than handed out;
constexpr int64_t kMaxBlockSize = 32;       ///< more if they would grow beyond this
constexpr double kMostTileBytes = 256e6;    ///< or their distances, where kept, beyond this;
constexpr double kMostTiles = 1e6;          ///< never more than this where they are not kept.

double SecondsPerLookup(const PlanState& state) {
  return state.spec.arithmetic == Arithmetic::kFidentis ? kFidentisSecondsPerLookup
                                                        : kSecondsPerLookup;
}

/// Meshes on a side of a tile; follows from the meshes alone.
int64_t BlockSize(const PlanState& state) {
  constexpr double kVectorBytes = 3.3;
  const double vertices =
      std::max(1.0, state.active_vertices / static_cast<double>(state.ActiveCount()));
  const double pairs_at_least = kLeastTileSeconds / (vertices * SecondsPerLookup(state));
  const double pairs_at_most = kMostTileBytes / (vertices * kVectorBytes);
  // A tile of b meshes a side holds 2 b^2 pairs.
  const auto least = static_cast<int64_t>(std::sqrt(pairs_at_least / 2));
  const auto most = static_cast<int64_t>(std::sqrt(pairs_at_most / 2));
  const int64_t even = (state.ActiveCount() + kBlocksPerSide - 1) / kBlocksPerSide;
  const int64_t size = std::clamp<int64_t>(std::min(std::max(even, least), most), 1, kMaxBlockSize);
  const Retention retention = ResolvedCompare(state).retention;
  if (retention == Retention::kVectors || retention == Retention::kCompact) {
    return size;
  }
  const double few = static_cast<double>(state.ActiveCount()) / std::sqrt(2 * kMostTiles);
  return std::max(size, static_cast<int64_t>(std::ceil(few)));
}

/// Meshes of a tile, as the state has them.
struct TilePlace {
  std::span<const int32_t> rows;
  std::span<const int32_t> columns;
  bool is_diagonal = false;  ///< Both are the same meshes.
};

int64_t BlockCount(int64_t meshes, int64_t size) {
  return (meshes + size - 1) / size;
}

std::span<const int32_t> BlockAt(std::span<const int32_t> meshes, int64_t size, int64_t block) {
  const int64_t begin = block * size;
  const int64_t end = std::min(begin + size, std::ssize(meshes));
  return meshes.subspan(static_cast<size_t>(begin), static_cast<size_t>(end - begin));
}

/// The tiles of a job: of all its meshes with each other; where a reference job has measured some,
/// first those of new meshes with kept ones, then those of new ones.
int64_t TileCount(const PlanState& state) {
  const int64_t size = BlockSize(state);
  if (!state.HasKeptFrame()) {
    return BlockPairCount(BlockCount(state.ActiveCount(), size));
  }
  const int64_t open = BlockCount(std::ssize(state.active_open), size);
  return open * BlockCount(std::ssize(state.active_kept), size) + BlockPairCount(open);
}

TilePlace TileAt(const PlanState& state, int64_t task) {
  const int64_t size = BlockSize(state);
  const std::vector<int32_t>& all = state.active;
  if (!state.HasKeptFrame()) {
    const auto [row, column] = BlockPairAt(BlockCount(state.ActiveCount(), size), task);
    return {BlockAt(all, size, row), BlockAt(all, size, column), row == column};
  }
  const std::vector<int32_t>& open = state.active_open;
  const std::vector<int32_t>& kept = state.active_kept;
  const int64_t open_blocks = BlockCount(std::ssize(open), size);
  const int64_t mixed = open_blocks * BlockCount(std::ssize(kept), size);
  if (task < mixed) {
    return {BlockAt(open, size, task % open_blocks), BlockAt(kept, size, task / open_blocks),
            false};
  }
  const auto [row, column] = BlockPairAt(open_blocks, task - mixed);
  return {BlockAt(open, size, row), BlockAt(open, size, column), row == column};
}

void AddFields(PlanState& state, const TaskResult& result) {
  if (!result.fields.empty()) {
    state.outputs.fields.push_back(result.fields);
  }
}

/// Tiles of pairs of aligned meshes, both directions each.
class CompareStage final : public Stage {
 public:
  [[nodiscard]] std::string Name() const override { return "compare"; }

  [[nodiscard]] int64_t TaskCount(const PlanState& state) const override {
    return TileCount(state);
  }

  [[nodiscard]] double TaskCost(const PlanState& state, int64_t task) const override {
    const TilePlace tile = TileAt(state, task);
    double lookups = state.VerticesOf(tile.rows) * static_cast<double>(tile.columns.size());
    if (!tile.is_diagonal) {
      lookups += state.VerticesOf(tile.columns) * static_cast<double>(tile.rows.size());
    }
    return lookups * SecondsPerLookup(state);
  }

  [[nodiscard]] std::array<int64_t, 2> Reads(const PlanState& state, int64_t task) const override {
    const TilePlace tile = TileAt(state, task);
    return {tile.rows.front(), tile.columns.front()};
  }

  [[nodiscard]] Task MakeTask(const PlanState& state, int64_t task) const override {
    const TilePlace tile = TileAt(state, task);
    std::vector<int32_t> both(tile.rows.begin(), tile.rows.end());
    if (!tile.is_diagonal) {
      both.insert(both.end(), tile.columns.begin(), tile.columns.end());
    }
    Task made;
    made.kind = TaskKind::kCompare;
    made.meshes = state.TaskMeshes(tile.rows);
    made.targets = state.TaskMeshes(tile.columns);
    made.alignments = state.AlignmentsOf(both);
    made.compare = ResolvedCompare(state);
    if (state.spec.arithmetic == Arithmetic::kFidentis) {
      made.arithmetic = Arithmetic::kFidentis;
      made.partials = state.PlacedOf(both);
    }
    made.frame_center = state.FrameCenter();
    return made;
  }

  [[nodiscard]] absl::Status Absorb(PlanState& state,
                                    std::span<const TaskResult> results) const override {
    for (const TaskResult& result : results) {
      state.outputs.tiles.push_back(result.output);
      AddFields(state, result);
    }
    state.CollectAlignments();
    state.outputs.frame = {.reference = state.reference, .center = state.FrameCenter()};
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
    return state.active_vertices * (iterations + 1) * SecondsPerLookup(state);
  }

  [[nodiscard]] Task MakeTask(const PlanState& state, int64_t task) const override {
    Task made;
    made.kind = TaskKind::kAlignAndCompare;
    made.meshes = state.TaskMeshes(state.active);
    made.targets = state.TaskMeshes(std::span(state.active).subspan(static_cast<size_t>(task), 1));
    made.alignments = state.AlignmentsOf(state.active);
    made.icp = state.spec.icp;
    made.undersampling = state.spec.undersampling;
    made.compare = ResolvedCompare(state);
    made.counts_reference_index = true;
    if (state.spec.arithmetic == Arithmetic::kFidentis) {
      made.arithmetic = Arithmetic::kFidentis;
      made.wants_placed = state.active[static_cast<size_t>(task)] == state.base;
    }
    return made;
  }

  [[nodiscard]] absl::Status Absorb(PlanState& state,
                                    std::span<const TaskResult> results) const override {
    for (size_t i = 0; i < results.size(); ++i) {
      state.outputs.tiles.push_back(results[i].output);
      AddFields(state, results[i]);
      if (state.active[i] != state.base) {
        continue;
      }
      state.outputs.alignments = {results[i].second_output};
      // One blob holds all alignments to the base.
      for (Batch& batch : state.batches) {
        batch.alignment = results[i].second_output;
        batch.placed = results[i].placed;
      }
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
