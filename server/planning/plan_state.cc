#include "server/planning/plan_state.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include <absl/strings/str_cat.h>

namespace cohort {
namespace {

/// Of binary and text files alike; only for the progress shown before ingest.
constexpr double kBytesPerVertex = 60;
constexpr int64_t kMeshesPerBatchStep = 64;  ///< A job has about 64 batches,
constexpr int64_t kMaxBatchSize = 16;        ///< more if they would grow beyond this.
constexpr int64_t kNamedRejections = 3;

/// One blob of each batch that holds some of `chosen`, each once, in batch order.
std::vector<Digest> BlobsOf(const std::vector<Batch>& batches,
                            const std::vector<int32_t>& chosen,
                            Digest Batch::*blob) {
  std::vector<Digest> result;
  for (const int32_t mesh : chosen) {
    // Batches are consecutive: the last one that begins at or before the mesh holds it.
    const auto after =
        std::partition_point(batches.begin(), batches.end(),
                             [mesh](const Batch& batch) { return batch.meshes.front() <= mesh; });
    const Digest& found = (*std::prev(after)).*blob;
    if (!found.empty() && (result.empty() || result.back() != found)) {
      result.push_back(found);
    }
  }
  return result;
}

}  // namespace

double PlanState::VerticesOf(int32_t mesh) const {
  const JobMesh& chosen = meshes[static_cast<size_t>(mesh)];
  return chosen.ingested ? static_cast<double>(chosen.ingested->vertices)
                         : static_cast<double>(chosen.mesh.size_bytes) / kBytesPerVertex;
}

double PlanState::VerticesOf(const std::vector<int32_t>& chosen) const {
  double sum = 0;
  for (const int32_t mesh : chosen) {
    sum += VerticesOf(mesh);
  }
  return sum;
}

const Digest& PlanState::BlobOf(int32_t mesh) const {
  const JobMesh& chosen = meshes[static_cast<size_t>(mesh)];
  return chosen.copy ? chosen.copy->blob : chosen.ingested->blob;
}

std::vector<TaskMesh> PlanState::TaskMeshes(const std::vector<int32_t>& chosen) const {
  std::vector<TaskMesh> result;
  result.reserve(chosen.size());
  for (const int32_t index : chosen) {
    result.push_back({index, meshes[static_cast<size_t>(index)].mesh.name, BlobOf(index)});
  }
  return result;
}

std::vector<Digest> PlanState::AlignmentsOf(const std::vector<int32_t>& chosen) const {
  return BlobsOf(batches, chosen, &Batch::alignment);
}

std::vector<Digest> PlanState::PlacedOf(const std::vector<int32_t>& chosen) const {
  return BlobsOf(batches, chosen, &Batch::placed);
}

absl::Status PlanState::ChooseBase() {
  if (spec.base.empty()) {
    base = active.front();
  }
  const JobMesh& chosen = meshes[static_cast<size_t>(base)];
  if (!chosen.rejection.empty()) {
    return absl::FailedPreconditionError(
        absl::StrCat("the base mesh ", chosen.mesh.name, " cannot be used: ", chosen.rejection));
  }
  reference = BlobOf(base);
  return absl::OkStatus();
}

void PlanState::FormBatches() {
  const int64_t size = std::clamp<int64_t>(ActiveCount() / kMeshesPerBatchStep, 1, kMaxBatchSize);
  batches.clear();
  for (std::vector<int32_t>& piece : SplitEvenly(active, size)) {
    batches.push_back(
        {.meshes = std::move(piece), .alignment = {}, .displacement = {}, .placed = {}});
  }
}

void PlanState::Reject(const std::vector<MeshRejection>& rejections) {
  for (const MeshRejection& rejection : rejections) {
    meshes[static_cast<size_t>(rejection.index)].rejection =
        rejection.reason.empty() ? "rejected without a reason" : rejection.reason;
  }
  const auto is_rejected = [this](int32_t mesh) {
    return !meshes[static_cast<size_t>(mesh)].rejection.empty();
  };
  std::erase_if(active, is_rejected);
  for (Batch& batch : batches) {
    std::erase_if(batch.meshes, is_rejected);
  }
  std::erase_if(batches, [](const Batch& batch) { return batch.meshes.empty(); });
}

absl::Status PlanState::CheckEnoughLeft() const {
  if (active.size() >= 2) {
    return absl::OkStatus();
  }
  std::string message = absl::StrCat("a comparison needs 2 meshes, but of ", meshes.size(),
                                     " only ", active.size(), " can be used");
  int64_t named = 0;
  int64_t more = 0;
  for (const JobMesh& mesh : meshes) {
    if (mesh.rejection.empty()) {
      continue;
    }
    if (named == kNamedRejections) {
      ++more;
      continue;
    }
    absl::StrAppend(&message, named == 0 ? ": " : "; ", mesh.mesh.name, ": ", mesh.rejection);
    ++named;
  }
  if (more > 0) {
    absl::StrAppend(&message, "; and ", more, " more");
  }
  return absl::FailedPreconditionError(message);
}

std::vector<std::vector<int32_t>> SplitEvenly(const std::vector<int32_t>& meshes, int64_t size) {
  std::vector<std::vector<int32_t>> pieces;
  for (auto from = meshes.begin(); from != meshes.end();) {
    const auto to = from + std::min<int64_t>(size, meshes.end() - from);
    pieces.emplace_back(from, to);
    from = to;
  }
  return pieces;
}

}  // namespace cohort
