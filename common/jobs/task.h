#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <absl/status/statusor.h>
#include <nlohmann/json_fwd.hpp>

#include "common/base/sha256.h"
#include "common/geometry/mesh/mesh_health.h"
#include "common/geometry/registration/scaling_icp.h"
#include "common/jobs/ids.h"
#include "common/jobs/job_spec.h"

namespace cohort {

enum class TaskKind : uint8_t {
  kIngest,   ///< raw files -> canonical meshes and health reports
  kPose,     ///< meshes, reference -> coarse poses
  kAlign,    ///< meshes, reference, starts -> alignments, partial displacement sum or variation
  kAverage,  ///< reference, partial sums -> next reference
  kCompare,  ///< two blocks of aligned meshes -> all metrics of their pairs, both directions
  kAlignAndCompare,  ///< one target, all sources -> alignments, metrics (method each)
  kVariation,   ///< reference, aligned meshes -> distances of each reference vertex to each mesh
  kSummarize,   ///< variation blobs -> per-vertex metrics, mean shape
  kChooseBase,  ///< all meshes -> the one nearest to all others, a base blob
  kPreview,     ///< correspondences of two blocks of meshes -> a preview blob of their pairs
  kSymmetrize,  ///< meshes -> their symmetric copies
};
[[nodiscard]] std::string_view TaskKindName(TaskKind kind);  ///< "ingest", "pose", "align", ...

/// A mesh as a task sees it.
struct TaskMesh {
  int32_t index = 0;  ///< Place in the job's order (by name), 0-based.
  std::string name;   ///< File name, for messages.
  Digest blob;        ///< kIngest: the raw file; all others: the canonical mesh, or its
                      ///< symmetric copy where the job has them.
  friend bool operator==(const TaskMesh&, const TaskMesh&) = default;
};

/// What one worker slot does in one go. Pure: the same task gives the same bytes anywhere.
struct Task {
  TaskKind kind = TaskKind::kIngest;
  int64_t number = 0;  ///< TaskId::number.
  std::string stage;   ///< "ingest", "pose", "align 1", "average 1", ..., "compare", "summarize".
  double cost = 1;     ///< Rough seconds, for progress and ETA.

  std::vector<TaskMesh> meshes;   ///< Sources. kCompare, kPreview: rows of the tile.
  std::vector<TaskMesh> targets;  ///< kCompare, kPreview: columns (equal to `meshes` on the
                                  ///< diagonal); kAlignAndCompare: the one target; poses by
                                  ///< landmarks, kSummarize of kFidentis: the base mesh.
  Digest reference;               ///< Mesh blob; kPose, kAlign, kAverage, kVariation, kSummarize.
  /// Alignment blobs that together hold `meshes` and `targets`; kAlign: the starts;
  /// kAlignAndCompare: poses to the base mesh. Empty: identities.
  std::vector<Digest> alignments;
  std::string starts;  ///< kAlign: TaskResult::alignments of the round before; empty: `alignments`.
  /// kAverage: displacement blobs, kSummarize: variation blobs, kPreview: correspondence blobs.
  /// With Arithmetic::kFidentis: placed blobs; kAlign: the starts (none: the meshes of the files,
  /// centred); kCompare: that together hold `meshes` and `targets`; kAverage, kSummarize: all.
  std::vector<Digest> partials;

  /// kPose, kAlign with wants_pose, kChooseBase: landmark blob; empty: poses by shape.
  Digest landmarks;

  IcpOptions icp;                      ///< kAlign, kAlignAndCompare, kChooseBase, kSymmetrize;
                                       ///< kVariation: correspondence; kPose: scale mode, limit.
  UndersamplingOptions undersampling;  ///< kAlign, kAlignAndCompare.
  CompareOptions compare;              ///< kCompare, kAlignAndCompare.
  int position_bits = 18;              ///< kIngest; 0: as in the file.
  Arithmetic arithmetic = Arithmetic::kExact;  ///< All but kIngest.
  bool wants_placed = false;  ///< kFidentis: kAlign, kAlignAndCompare also write a placed blob.
  bool wants_pose = false;  ///< kAlign: start from coarse poses, found as by kPose, and write them.
  /// kAlign: also write the partial displacement sum. It is a round of the mean shape, which
  /// another alignment follows: its own alignments go into the result.
  bool wants_displacement = false;
  bool wants_variation = false;         ///< kAlign: also write what kVariation finds.
  bool wants_correspondences = false;   ///< That also writes the correspondences.
  bool counts_reference_index = false;  ///< The first task of a stage counts the index that all of
                                        ///< them need, so that counts do not depend on who ran it.
  /// kSummarize and what finds the variation: the mean shape is the reference and the mean
  /// displacement from it.
  bool moves_reference = false;
  /// kCompare: subtracted before distances become float32. kAlign with wants_variation: the same of
  /// the comparison to come.
  std::array<double, 3> frame_center{};
};

/// What decides to whom a task goes.
struct TaskTraits {
  static constexpr int64_t kNothing = -1;
  int64_t stage = 0;  ///< Tasks of one stage are of one kind.
  /// Numbers for the groups of meshes that it reads (the first mesh of each): a worker that has
  /// them is preferred.
  std::array<int64_t, 2> reads{kNothing, kNothing};
  double cost = 0;  ///< Task::cost.
};

/// Work done, counted as the algorithm needs it (not as caches happened to save it).
struct WorkCounters {
  int64_t index_builds = 0;
  int64_t lookups = 0;
  friend bool operator==(const WorkCounters&, const WorkCounters&) = default;
  WorkCounters& operator+=(const WorkCounters& other) {
    index_builds += other.index_builds;
    lookups += other.lookups;
    return *this;
  }
};

/// Counters of one task or one job. The thesis's tables 5.4-5.5 count align + average.
struct Counters {
  WorkCounters pose;
  WorkCounters align;
  WorkCounters average;  ///< Nearest vertices of the reference on each aligned mesh, M rounds.
  WorkCounters compare;
  WorkCounters variation;
  int64_t pairs = 0;  ///< Directed pairs measured.
  friend bool operator==(const Counters&, const Counters&) = default;
  Counters& operator+=(const Counters& other);
};

/// A mesh that a task took out of the job, and why.
struct MeshRejection {
  int32_t index = 0;
  std::string reason;  ///< One line for people.
  friend bool operator==(const MeshRejection&, const MeshRejection&) = default;
};

/// A mesh that ingest accepted.
struct IngestedMesh {
  int32_t index = 0;
  Digest blob;           ///< Canonical mesh.
  int64_t vertices = 0;  ///< Of the canonical mesh.
  int64_t faces = 0;
  std::array<double, 3> centroid{};  ///< Of the canonical vertices.
  MeshHealth health;                 ///< Of the file.
};

/// What a job with symmetric copies works with in place of a mesh.
struct SymmetricCopy {
  int32_t index = 0;
  Digest blob;           ///< Mesh blob; vertices and faces correspond to the canonical mesh's.
  double asymmetry = 0;  ///< SymmetricMesh::asymmetry, mesh units.
  friend bool operator==(const SymmetricCopy&, const SymmetricCopy&) = default;
};

/// What a finished task tells the server.
struct TaskResult {
  /// kIngest, kSymmetrize: empty. kPose, kAlign: alignment blob. kAverage: mesh blob. kCompare:
  /// tile blob. kAlignAndCompare: tile blob. kVariation: variation blob. kSummarize: summary blob.
  Digest output;
  /// kAlign with wants_displacement: the bytes of an alignment blob, and no `output`. Only the next
  /// alignment reads them: not worth a file and its sync.
  std::string alignments;
  Digest second_output;  ///< kAlign: displacement blob, if wanted. kVariation, kAlign:
                         ///< correspondence blob, if wanted. kAlignAndCompare: alignment
                         ///< blob. kSummarize: mean shape as mesh blob.
  Digest poses;          ///< kAlign: alignment blob of the coarse poses, if wanted.
  Digest variation;      ///< kAlign: variation blob, if wanted.
  Digest placed;         ///< If wanted: the meshes as they were aligned.
  /// kCompare, kAlignAndCompare: what is kept of the distances; empty: none. kVariation, kAlign
  /// with wants_variation: signatures of the meshes, as correspondence blob.
  Digest fields;
  int32_t base = -1;  ///< kChooseBase: index of the mesh.
  double change = 0;  ///< kAverage: RMS over the vertices of how far the reference moved.
  std::vector<IngestedMesh> ingested;     ///< kIngest.
  std::vector<SymmetricCopy> copies;      ///< kSymmetrize.
  std::vector<MeshRejection> rejections;  ///< kIngest, kPose, kAlign, kSymmetrize.
  Counters counters;
  double seconds = 0;  ///< Time the worker took; never part of a result.
};

[[nodiscard]] nlohmann::json ToJson(const MeshHealth& health);
[[nodiscard]] nlohmann::json ToJson(const Counters& counters);
[[nodiscard]] nlohmann::json ToJson(const TaskResult& result);
/// Reads what any earlier build wrote: a field that is missing takes its default, so the default of
/// a new field must mean what builds before it did. An unknown field is refused: a newer build
/// wrote it, and to drop it would change what the result says.
/// @return kDataLoss naming the field.
[[nodiscard]] absl::StatusOr<TaskResult> TaskResultFromJson(const nlohmann::json& json);

}  // namespace cohort
