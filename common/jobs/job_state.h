#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/jobs/ids.h"
#include "common/jobs/job_spec.h"
#include "common/jobs/task.h"

namespace cohort {

enum class JobState : uint8_t {
  kQueued,
  kRunning,
  kSucceeded,
  kFailed,
  kCancelled,
  kPaused,  ///< No new tasks are handed out; those that are out may end.
};
[[nodiscard]] std::string_view JobStateName(JobState state);  ///< "queued", "running", ...
[[nodiscard]] std::optional<JobState> JobStateFromName(std::string_view name);
[[nodiscard]] inline bool IsFinal(JobState state) {
  return state == JobState::kSucceeded || state == JobState::kFailed ||
         state == JobState::kCancelled;
}

/// A mesh of a set, as added.
struct SetMesh {
  std::string name;  ///< File name, unique in its set.
  Digest raw;        ///< The file's bytes.
  int64_t size_bytes = 0;
  std::map<std::string, std::string> labels;  ///< "person" and any other columns of --labels.
};

/// When a stage ran, by the server's clock.
struct StageTime {
  std::string name;
  int64_t started_unix_ms = 0;   ///< First task handed out.
  int64_t finished_unix_ms = 0;  ///< Last task done so far.
  friend bool operator==(const StageTime&, const StageTime&) = default;
};

/// Finished and known tasks, and how much of the expected cost is done.
struct Progress {
  std::string stage;  ///< Of the earliest unfinished task; empty when done.
  int64_t tasks_done = 0;
  int64_t tasks_total = 0;  ///< Rounds not planned yet are counted as announced.
  double cost_done = 0;
  double cost_total = 0;
  std::vector<StageTime> stages;  ///< Begun so far, in that order; never part of a result.
  int64_t tasks_reused = 0;       ///< Of those done: known from an earlier job.
  int64_t tasks_given_up = 0;     ///< Failed too often; the job cannot succeed without them.
  std::string waiting_for;        ///< Why the server hands out no task; empty: it does.
};

/// What all meshes of a job were brought to, so that a later job can add to them.
struct CommonFrame {
  Digest reference;                ///< Mesh blob that they were aligned to; empty: unknown.
  std::array<double, 3> center{};  ///< Subtracted before distances become float32.
  friend bool operator==(const CommonFrame&, const CommonFrame&) = default;
};

/// Pairs that an earlier job has measured in the same frame.
struct ImportedPairs {
  std::vector<Digest> tiles;
  std::vector<Digest> fields;
  std::vector<int32_t> mesh_of;  ///< This job's index of each mesh of that job; -1: not in it.
  friend bool operator==(const ImportedPairs&, const ImportedPairs&) = default;
};

/// Blobs that hold the results of a job that succeeded.
struct JobOutputs {
  std::vector<Digest> tiles;       ///< Tile blobs.
  std::vector<Digest> alignments;  ///< Alignment blobs to the final reference (each: to the base).
  Digest mean_shape;               ///< Mesh blob.
  Digest summary;                  ///< Summary blob: per-vertex metrics on the mean shape.
  Digest variation_shape;          ///< Mesh blob that the summary is of; empty: the mean shape.
  std::vector<Digest> fields;      ///< Field blobs: what is kept of the distances.
  Digest base_choice;              ///< Base blob, if the base was chosen; else empty.
  std::vector<Digest> preview;     ///< Preview blobs, if asked for; there before the others.
  CommonFrame frame;
  std::vector<ImportedPairs> imported;  ///< Of the job with a reference job; besides `tiles`.
  std::vector<Digest> poses;  ///< Alignment blobs of the coarse poses; empty: none were made.
  /// Correspondence blobs of a few vertices of the reference (pairs/signature.h); empty: no
  /// variation was measured, or by a build that kept none.
  std::vector<Digest> signatures;
};

/// A mesh of a job and what became of it.
struct JobMesh {
  SetMesh mesh;
  std::optional<IngestedMesh> ingested;
  std::optional<SymmetricCopy> copy;  ///< Only of jobs with symmetric copies.
  std::string rejection;              ///< Why it is not in the results; empty if it is.
};

/// A job as everyone sees it.
struct Job {
  JobId id;
  std::string set;
  JobSpec spec;
  JobState state = JobState::kQueued;
  std::string error;    ///< Why it failed.
  int64_t version = 0;  ///< Grows with every change of the job.
  /// kPlanVersion and kResultsVersion of the server that began it; 0: one that did not tell.
  int64_t plan_version = 0;
  int64_t results_version = 0;
  int64_t created_unix_ms = 0;
  int64_t started_unix_ms = 0;   ///< 0: not yet.
  int64_t finished_unix_ms = 0;  ///< 0: not yet.
  int64_t meshes = 0;
  int64_t rejected_meshes = 0;
  Progress progress;
  Counters counters;
};

[[nodiscard]] nlohmann::json ToJson(const JobOutputs& outputs);
/// Fields that are missing take their defaults, as TaskResultFromJson does.
/// @return kDataLoss naming the field.
[[nodiscard]] absl::StatusOr<JobOutputs> JobOutputsFromJson(const nlohmann::json& json);

}  // namespace cohort
