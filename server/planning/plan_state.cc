#include "server/planning/plan_state.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <iterator>
#include <span>
#include <utility>

#include <absl/strings/str_cat.h>

namespace cohort {
namespace {

/// Of binary and text files alike; only for the progress shown before ingest.
constexpr double kBytesPerVertex = 60;
constexpr int64_t kNamedRejections = 3;

double VerticesInFile(const SetMesh& mesh) {
  return static_cast<double>(mesh.size_bytes) / kBytesPerVertex;
}

/// The batch that holds a mesh: those that are kept are consecutive among themselves, and so are
/// the others.
const Batch& BatchOf(std::span<const Batch> kept, std::span<const Batch> open, int32_t mesh) {
  const auto find = [mesh](std::span<const Batch> batches) {
    const auto after =
        std::partition_point(batches.begin(), batches.end(),
                             [mesh](const Batch& batch) { return batch.meshes.front() <= mesh; });
    return after == batches.begin() ? nullptr : &*std::prev(after);
  };
  const Batch* batch = find(kept);
  const bool is_kept =
      batch != nullptr && std::binary_search(batch->meshes.begin(), batch->meshes.end(), mesh);
  if (!is_kept) {
    batch = find(open);
  }
  assert(batch != nullptr);  // Every active mesh is in a batch.
  return *batch;
}

/// One blob of each batch that holds some of `chosen`, each once, in the order of the meshes.
std::vector<Digest> BlobsOf(const PlanState& state,
                            const std::vector<int32_t>& chosen,
                            Digest Batch::*blob) {
  const std::span<const Batch> batches(state.batches);
  const size_t first_open = state.FirstOpenBatch();
  std::vector<Digest> result;
  for (const int32_t mesh : chosen) {
    const Digest& found =
        BatchOf(batches.first(first_open), batches.subspan(first_open), mesh).*blob;
    if (first_open > 0 && std::find(result.begin(), result.end(), found) != result.end()) {
      continue;
    }
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
                         : VerticesInFile(chosen.mesh);
}

double PlanState::VerticesOf(std::span<const int32_t> chosen) const {
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

std::vector<TaskMesh> PlanState::TaskMeshes(std::span<const int32_t> chosen) const {
  std::vector<TaskMesh> result;
  result.reserve(chosen.size());
  for (const int32_t index : chosen) {
    result.push_back({index, meshes[static_cast<size_t>(index)].mesh.name, BlobOf(index)});
  }
  return result;
}

std::vector<Digest> PlanState::AlignmentsOf(const std::vector<int32_t>& chosen) const {
  return BlobsOf(*this, chosen, &Batch::alignment);
}

std::vector<Digest> PlanState::PlacedOf(const std::vector<int32_t>& chosen) const {
  return BlobsOf(*this, chosen, &Batch::placed);
}

size_t PlanState::FirstOpenBatch() const {
  const auto first = std::partition_point(batches.begin(), batches.end(),
                                          [](const Batch& batch) { return batch.is_kept; });
  return static_cast<size_t>(first - batches.begin());
}

std::array<double, 3> PlanState::FrameCenter() const {
  return HasKeptFrame() ? outputs.frame.center
                        : meshes[static_cast<size_t>(base)].ingested->centroid;
}

absl::Status PlanState::ChooseBase() {
  if (HasKeptFrame()) {
    reference = outputs.frame.reference;
    return absl::OkStatus();
  }
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

void PlanState::GuessFileVertices() {
  double sum = 0;
  for (const JobMesh& mesh : meshes) {
    sum += VerticesInFile(mesh.mesh);
  }
  file_vertices = sum / static_cast<double>(std::max<size_t>(1, meshes.size()));
}

BatchPartition PlanState::BatchesOfActive(int64_t count) const {
  const auto active_count = static_cast<double>(std::max<int64_t>(1, ActiveCount()));
  return BatchesOf(count, active_vertices / active_count);
}

void PlanState::FormBatches() {
  active_vertices = VerticesOf(active);
  batches.clear();
  active_open.clear();
  active_kept.clear();
  std::set_difference(active.begin(), active.end(), kept.begin(), kept.end(),
                      std::back_inserter(active_open));
  std::set_intersection(active.begin(), active.end(), kept.begin(), kept.end(),
                        std::back_inserter(active_kept));
  const auto add = [this](const std::vector<int32_t>& chosen, bool is_kept) {
    const BatchPartition partition = BatchesOfActive(std::ssize(chosen));
    for (int64_t i = 0; i < partition.Count(); ++i) {
      const MeshRange range = partition.At(i);
      batches.push_back({.meshes = {chosen.begin() + range.begin, chosen.begin() + range.end},
                         .is_kept = is_kept,
                         .alignment = is_kept ? kept_alignments : Digest(),
                         .starts = {},
                         .displacement = {},
                         .placed = {}});
    }
  };
  add(active_kept, true);
  add(active_open, false);
}

void PlanState::CollectAlignments() {
  outputs.alignments.clear();
  for (const Batch& batch : batches) {
    const bool is_new = outputs.alignments.empty() || outputs.alignments.back() != batch.alignment;
    if (!batch.alignment.empty() && is_new) {
      outputs.alignments.push_back(batch.alignment);
    }
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
  for (std::vector<int32_t>* left : {&active, &active_kept, &active_open}) {
    std::erase_if(*left, is_rejected);
  }
  for (Batch& batch : batches) {
    std::erase_if(batch.meshes, is_rejected);
  }
  std::erase_if(batches, [](const Batch& batch) { return batch.meshes.empty(); });
}

void PlanState::RejectAllOf(std::span<const TaskResult> results) {
  std::vector<MeshRejection> rejections;
  for (const TaskResult& result : results) {
    rejections.insert(rejections.end(), result.rejections.begin(), result.rejections.end());
  }
  Reject(rejections);
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

}  // namespace cohort
