#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <absl/status/status.h>

#include "common/jobs/job_state.h"
#include "common/jobs/task.h"
#include "server/planning/batch_partition.h"

namespace cohort {

/// Meshes that go through the alignments together, and what has come of them so far. A batch keeps
/// its identity when meshes leave it.
struct Batch {
  std::vector<int32_t> meshes;  ///< Active ones, ascending; never empty.
  bool is_kept = false;         ///< Aligned by the reference job.
  Digest alignment;             ///< Newest alignment blob that holds them; empty: none yet,
  std::string starts;           ///< or this, TaskResult::alignments, is newer.
  Digest displacement;          ///< Newest displacement blob.
  Digest placed;                ///< Arithmetic::kFidentis: newest placed blob that holds them.
};

/// What a plan knows of its job between two steps. Everything here follows from the job and the
/// results alone, never from the workers.
struct PlanState {
  JobSpec spec;
  std::vector<JobMesh> meshes;  ///< In the job's order.
  std::vector<int32_t> active;  ///< Meshes still in the job, ascending.
  double active_vertices = 0;  ///< Of the active meshes when the step began or batches were formed.
  std::vector<Batch> batches;  ///< All active meshes, in order. Provisional until ingest ends.
  std::vector<int32_t> active_kept;  ///< Active meshes of the batches that are kept, ascending,
  std::vector<int32_t> active_open;  ///< and of those that are not.
  double file_vertices = 0;          ///< Of a mesh on average, guessed from the sizes of the files.
  int32_t base = 0;                  ///< The base mesh. Provisional until ingest ends.
  bool mean_has_settled = false;     ///< The last round moved the mean shape by no more than asked.
  Digest reference;                  ///< Newest reference: the base mesh or the last mean shape.
  std::vector<int32_t> kept;         ///< Meshes whose alignments a reference job made, ascending.
  Digest kept_alignments;            ///< Alignment blob of those.
  std::vector<Digest> variations;    ///< Variation blobs in batch order.
  JobOutputs outputs;

  [[nodiscard]] int64_t ActiveCount() const { return static_cast<int64_t>(active.size()); }
  /// Known after ingest; before, a guess from the file's size.
  [[nodiscard]] double VerticesOf(int32_t mesh) const;
  [[nodiscard]] double VerticesOf(std::span<const int32_t> chosen) const;
  /// What the job works with in place of the file: the canonical mesh, or its symmetric copy; only
  /// after ingest.
  [[nodiscard]] const Digest& BlobOf(int32_t mesh) const;
  /// With BlobOf; only after ingest.
  [[nodiscard]] std::vector<TaskMesh> TaskMeshes(std::span<const int32_t> chosen) const;
  /// Alignment blobs of the batches that hold `chosen` (active, ascending), each once, in batch
  /// order. Empty while nothing is aligned.
  [[nodiscard]] std::vector<Digest> AlignmentsOf(const std::vector<int32_t>& chosen) const;

  /// The same of their placed blobs.
  [[nodiscard]] std::vector<Digest> PlacedOf(const std::vector<int32_t>& chosen) const;

  /// True if the job adds to the frame of a reference job.
  [[nodiscard]] bool HasKeptFrame() const { return !spec.reference_job.empty(); }
  /// What all distances are measured relative to; only after ingest.
  [[nodiscard]] std::array<double, 3> FrameCenter() const;
  /// The first batch that is not kept; those before it are.
  [[nodiscard]] size_t FirstOpenBatch() const;

  /// Takes the mesh that the job names, or else the first that can be used, as base and reference.
  /// @return kFailedPrecondition if the mesh that the job names was rejected.
  [[nodiscard]] absl::Status ChooseBase();
  /// Sets file_vertices.
  void GuessFileVertices();
  /// How so many of the active meshes are divided into batches.
  [[nodiscard]] BatchPartition BatchesOfActive(int64_t count) const;
  /// Divides the active meshes into new batches.
  void FormBatches();
  /// Writes the alignments of all batches into the outputs.
  void CollectAlignments();
  /// Takes meshes out of the job; batches left empty are dropped.
  void Reject(const std::vector<MeshRejection>& rejections);
  /// Those that any of the results rejects.
  void RejectAllOf(std::span<const TaskResult> results);
  /// @return kFailedPrecondition, naming the first rejections, if fewer than 2 meshes are left.
  [[nodiscard]] absl::Status CheckEnoughLeft() const;
};

}  // namespace cohort
