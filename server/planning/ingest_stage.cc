#include <array>
#include <iterator>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "server/planning/ingest_checks.h"
#include "server/planning/stage.h"

namespace cohort {
namespace {

constexpr double kSecondsPerByte = 1.5e-7;

/// Takes out the meshes without faces if the job asks for surfaces.
void RejectPointClouds(PlanState& state) {
  if (state.spec.icp.correspondence == Correspondence::kVertex &&
      state.spec.compare.correspondence == Correspondence::kVertex) {
    return;
  }
  std::vector<MeshRejection> rejections;
  for (const int32_t index : state.active) {
    const JobMesh& mesh = state.meshes[static_cast<size_t>(index)];
    if (mesh.ingested->faces == 0) {
      rejections.push_back({.index = index,
                            .reason = mesh.mesh.name + ": a point cloud; distances to surfaces "
                                                       "need faces"});
    }
  }
  state.Reject(rejections);
}

/// Raw files to canonical meshes. Batches are cut from all meshes, known or not, and by the sizes
/// of their files, so that a task keeps its number when a restarted server knows more meshes than
/// the first one did. They are those of the alignments, if the guess is good and no mesh is
/// rejected: what a worker has made it need not decode.
class IngestStage final : public Stage {
 public:
  [[nodiscard]] std::string Name() const override { return "ingest"; }

  [[nodiscard]] int64_t TaskCount(const PlanState& state) const override {
    return BatchesOfFiles(state).Count();
  }

  [[nodiscard]] double TaskCost(const PlanState& state, int64_t task) const override {
    double bytes = 0;
    for (const int32_t mesh : UnknownMeshes(state, task)) {
      bytes += static_cast<double>(state.meshes[static_cast<size_t>(mesh)].mesh.size_bytes);
    }
    return bytes * kSecondsPerByte;
  }

  [[nodiscard]] bool IsKnown(const PlanState& state, int64_t task) const override {
    return UnknownMeshes(state, task).empty();
  }

  /// Nothing has read them before; but the worker that makes meshes has them for what follows.
  [[nodiscard]] std::array<int64_t, 2> Reads(const PlanState& state, int64_t task) const override {
    return {BatchesOfFiles(state).At(task).begin, TaskTraits::kNothing};
  }

  [[nodiscard]] Task MakeTask(const PlanState& state, int64_t task) const override {
    Task made;
    made.kind = TaskKind::kIngest;
    made.position_bits = state.spec.position_bits;
    for (const int32_t index : UnknownMeshes(state, task)) {
      const SetMesh& mesh = state.meshes[static_cast<size_t>(index)].mesh;
      made.meshes.push_back({index, mesh.name, mesh.raw});
    }
    return made;
  }

  [[nodiscard]] absl::Status Absorb(PlanState& state,
                                    std::span<const TaskResult> results) const override {
    for (const TaskResult& result : results) {
      for (const IngestedMesh& mesh : result.ingested) {
        state.meshes[static_cast<size_t>(mesh.index)].ingested = mesh;
      }
    }
    state.RejectAllOf(results);
    RejectPointClouds(state);
    COHORT_RETURN_IF_ERROR(state.CheckEnoughLeft());
    COHORT_RETURN_IF_ERROR(state.ChooseBase());
    state.FormBatches();
    return CheckSizesFit(state);
  }

 private:
  static BatchPartition BatchesOfFiles(const PlanState& state) {
    return BatchesOf(std::ssize(state.meshes), state.file_vertices);
  }

  static std::vector<int32_t> UnknownMeshes(const PlanState& state, int64_t task) {
    const MeshRange batch = BatchesOfFiles(state).At(task);
    std::vector<int32_t> unknown;
    for (int64_t mesh = batch.begin; mesh < batch.end; ++mesh) {
      if (!state.meshes[static_cast<size_t>(mesh)].ingested) {
        unknown.push_back(static_cast<int32_t>(mesh));
      }
    }
    return unknown;
  }
};

}  // namespace

std::unique_ptr<const Stage> MakeIngestStage() {
  return std::make_unique<IngestStage>();
}

}  // namespace cohort
