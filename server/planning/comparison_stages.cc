#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "server/planning/block_pairs.h"
#include "server/planning/block_partition.h"
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

/// How large tiles are to be; follows from the meshes alone.
struct TileSize {
  int64_t mean = 1;  ///< Meshes on a side, on average.
  int64_t most = 1;
};

TileSize TileSizeOf(const PlanState& state) {
  constexpr double kVectorBytes = 3.3;
  const double vertices =
      std::max(1.0, state.active_vertices / static_cast<double>(state.ActiveCount()));
  const double pairs_at_least = kLeastTileSeconds / (vertices * SecondsPerLookup(state));
  const double pairs_at_most = kMostTileBytes / (vertices * kVectorBytes);
  // A tile of b meshes a side holds 2 b^2 pairs.
  const auto least = static_cast<int64_t>(std::sqrt(pairs_at_least / 2));
  const auto in_memory = static_cast<int64_t>(std::sqrt(pairs_at_most / 2));
  const int64_t most = std::clamp<int64_t>(in_memory, 1, kMaxBlockSize);
  const int64_t even = (state.ActiveCount() + kBlocksPerSide - 1) / kBlocksPerSide;
  const int64_t mean = std::clamp<int64_t>(std::max(even, least), 1, most);
  const Retention retention = ResolvedCompare(state).retention;
  if (retention == Retention::kVectors || retention == Retention::kCompact) {
    return {.mean = mean, .most = most};
  }
  const auto few = static_cast<int64_t>(
      std::ceil(static_cast<double>(state.ActiveCount()) / std::sqrt(2 * kMostTiles)));
  return few > mean ? TileSize{.mean = few, .most = state.ActiveCount()}
                    : TileSize{.mean = mean, .most = most};
}

BlockPartition BlocksOf(int64_t meshes, const TileSize& size) {
  BlockPartition blocks(meshes, (meshes + size.mean - 1) / size.mean);
  while (blocks.MostMeshes() > size.most) {
    blocks = BlockPartition(meshes, blocks.Count() + 1);
  }
  return blocks;
}

/// Meshes of a tile, as the state has them.
struct TilePlace {
  std::span<const int32_t> rows;
  std::span<const int32_t> columns;
  bool is_diagonal = false;  ///< Both are the same meshes.
};

std::span<const int32_t> BlockAt(std::span<const int32_t> meshes,
                                 const BlockPartition& blocks,
                                 int64_t block) {
  const MeshRange range = blocks.At(block);
  return meshes.subspan(static_cast<size_t>(range.begin), static_cast<size_t>(range.Size()));
}

/// The tiles of a job: of all its meshes with each other; where a reference job has measured some,
/// first those of new meshes with kept ones, then those of new ones.
int64_t TileCount(const PlanState& state) {
  const TileSize size = TileSizeOf(state);
  if (!state.HasKeptFrame()) {
    return BlockPairCount(BlocksOf(state.ActiveCount(), size).Count());
  }
  const int64_t open = BlocksOf(std::ssize(state.active_open), size).Count();
  return open * BlocksOf(std::ssize(state.active_kept), size).Count() + BlockPairCount(open);
}

TilePlace TileAt(const PlanState& state, int64_t task) {
  const TileSize size = TileSizeOf(state);
  if (!state.HasKeptFrame()) {
    const BlockPartition blocks = BlocksOf(state.ActiveCount(), size);
    const auto [row, column] = BlockPairAt(blocks.Count(), task);
    return {BlockAt(state.active, blocks, row), BlockAt(state.active, blocks, column),
            row == column};
  }
  const std::vector<int32_t>& open = state.active_open;
  const std::vector<int32_t>& kept = state.active_kept;
  const BlockPartition open_blocks = BlocksOf(std::ssize(open), size);
  const BlockPartition kept_blocks = BlocksOf(std::ssize(kept), size);
  const int64_t mixed = open_blocks.Count() * kept_blocks.Count();
  if (task < mixed) {
    return {BlockAt(open, open_blocks, task % open_blocks.Count()),
            BlockAt(kept, kept_blocks, task / open_blocks.Count()), false};
  }
  const auto [row, column] = BlockPairAt(open_blocks.Count(), task - mixed);
  return {BlockAt(open, open_blocks, row), BlockAt(open, open_blocks, column), row == column};
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
