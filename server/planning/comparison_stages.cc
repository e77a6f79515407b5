#include <algorithm>
#include <cmath>

#include "server/planning/block_pairs.h"
#include "server/planning/stage.h"

namespace cohort {
namespace {

constexpr double kSecondsPerLookup = 1.8e-8;
constexpr double kFidentisSecondsPerLookup = 4e-7;
constexpr int kExpectedIterations = 35;
constexpr int64_t kBlocksPerSide = 24;      ///< Tiles for some hundreds of slots,
constexpr double kLeastTileSeconds = 0.05;  ///< unless they would be over sooner than handed out;
constexpr int64_t kMaxBlockSize = 32;       ///< more if they would grow beyond this
constexpr double kMostTileBytes = 256e6;    ///< or their distances, where kept, beyond this.

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
  return std::clamp<int64_t>(std::min(std::max(even, least), most), 1, kMaxBlockSize);
}

int64_t BlockCount(const PlanState& state) {
  return (state.ActiveCount() + BlockSize(state) - 1) / BlockSize(state);
}

std::vector<int32_t> BlockAt(const PlanState& state, int64_t block) {
  const int64_t begin = block * BlockSize(state);
  const int64_t end = std::min(begin + BlockSize(state), state.ActiveCount());
  return {state.active.begin() + begin, state.active.begin() + end};
}

/// Bytes that keeping the distances of all pairs takes, roughly.
double BytesKept(const PlanState& state, Retention retention) {
  constexpr double kVectorBytes = 3.3;
  constexpr double kCompactBytes = 1.7;
  constexpr double kSketchBytes = 700;
  const auto meshes = static_cast<double>(state.ActiveCount());
  const double distances = state.active_vertices * meshes;
  switch (retention) {
    case Retention::kVectors:
      return distances * kVectorBytes;
    case Retention::kCompact:
      return distances * kCompactBytes;
    case Retention::kSketch:
      return meshes * meshes * kSketchBytes;
    case Retention::kMetrics:
    case Retention::kAuto:
      break;
  }
  return 0;
}

/// The job's options with Retention::kAuto decided: by the meshes alone, so that every task, also
/// after a restart, decides the same.
CompareOptions ResolvedCompare(const PlanState& state) {
  CompareOptions compare = state.spec.compare;
  if (compare.retention == Retention::kAuto) {
    compare.retention = Retention::kMetrics;
    for (const Retention richer : {Retention::kSketch, Retention::kCompact, Retention::kVectors}) {
      // The predecessor's distances are kept whole or not at all.
      if (state.spec.arithmetic == Arithmetic::kFidentis && richer != Retention::kVectors) {
        continue;
      }
      if (BytesKept(state, richer) <= static_cast<double>(state.spec.retention_budget)) {
        compare.retention = richer;
      }
    }
  }
  return compare;
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
    return BlockPairCount(BlockCount(state));
  }

  [[nodiscard]] double TaskCost(const PlanState& state, int64_t task) const override {
    const auto [row, column] = BlockPairAt(BlockCount(state), task);
    const std::vector<int32_t> rows = BlockAt(state, row);
    const std::vector<int32_t> columns = BlockAt(state, column);
    double lookups = state.VerticesOf(rows) * static_cast<double>(columns.size());
    if (row != column) {
      lookups += state.VerticesOf(columns) * static_cast<double>(rows.size());
    }
    return lookups * SecondsPerLookup(state);
  }

  [[nodiscard]] std::array<int64_t, 2> Reads(const PlanState& state, int64_t task) const override {
    const auto [row, column] = BlockPairAt(BlockCount(state), task);
    const auto first_mesh = [&](int64_t block) -> int64_t {
      return state.active[static_cast<size_t>(block * BlockSize(state))];
    };
    return {first_mesh(row), first_mesh(column)};
  }

  [[nodiscard]] Task MakeTask(const PlanState& state, int64_t task) const override {
    const auto [row, column] = BlockPairAt(BlockCount(state), task);
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
    made.compare = ResolvedCompare(state);
    if (state.spec.arithmetic == Arithmetic::kFidentis) {
      made.arithmetic = Arithmetic::kFidentis;
      made.partials = state.PlacedOf(both);
    }
    made.frame_center = state.meshes[static_cast<size_t>(state.base)].ingested->centroid;
    return made;
  }

  [[nodiscard]] absl::Status Absorb(PlanState& state,
                                    std::span<const TaskResult> results) const override {
    for (const TaskResult& result : results) {
      state.outputs.tiles.push_back(result.output);
      AddFields(state, result);
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
    return state.active_vertices * (iterations + 1) * SecondsPerLookup(state);
  }

  [[nodiscard]] Task MakeTask(const PlanState& state, int64_t task) const override {
    Task made;
    made.kind = TaskKind::kAlignAndCompare;
    made.meshes = state.TaskMeshes(state.active);
    made.targets = state.TaskMeshes({state.active[static_cast<size_t>(task)]});
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
