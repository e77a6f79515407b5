#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>
#include <gtest/gtest.h>

#include "common/base/random.h"
#include "common/jobs/blobs.h"
#include "server/planning/job_plan.h"
#include "tests/testing/status_matchers.h"

namespace cohort::testing {

/// A job of meshes a.ply, b.ply, ... and workers that answer every task at once with blobs that
/// bear speaking names, so that a plan can be written down and compared as text:
///
///   "6 align 1: a | to a | from pose#3 | displacement, counts index"
///
/// is task 6 of stage "align 1", for mesh a, to the canonical mesh a, from the output of task 3;
/// its outputs will be called "align 1#6" and "align 1#6+".
class FakeJob {
 public:
  explicit FakeJob(int mesh_count) {
    for (int i = 0; i < mesh_count; ++i) {
      names_.push_back(mesh_count <= 26 ? std::string(1, static_cast<char>('a' + i))
                                        : absl::StrCat("m", 100000 + i));
      meshes_.push_back({.name = names_.back() + ".ply",
                         .raw = Name(names_.back() + " raw"),
                         .size_bytes = 42000000,
                         .labels = {}});
      radii_.push_back(80);
    }
  }

  [[nodiscard]] const std::vector<SetMesh>& Meshes() const { return meshes_; }
  void SetRadius(int mesh, double radius) { radii_[static_cast<size_t>(mesh)] = radius; }
  /// The mesh is refused by the first task of this stage that it is in.
  void RejectIn(const std::string& stage, int mesh, const std::string& reason = "it is broken") {
    rejections_[{stage, mesh}] = reason;
  }

  [[nodiscard]] std::unique_ptr<JobPlan> Plan(const JobSpec& spec,
                                              const std::vector<int32_t>& known = {}) {
    auto plan = JobPlan::Create(spec, meshes_, Known(known));
    EXPECT_THAT(plan, IsOk());
    return plan.ok() ? *std::move(plan) : nullptr;
  }
  [[nodiscard]] std::vector<IngestedMesh> Known(const std::vector<int32_t>& indices) {
    std::vector<IngestedMesh> known;
    known.reserve(indices.size());
    for (const int32_t index : indices) {
      known.push_back(Ingested(index));
    }
    return known;
  }
  [[nodiscard]] std::vector<int32_t> AllIndices() const {
    std::vector<int32_t> all;
    for (size_t i = 0; i < meshes_.size(); ++i) {
      all.push_back(static_cast<int32_t>(i));
    }
    return all;
  }

  /// What a worker would answer.
  [[nodiscard]] TaskResult ResultOf(const Task& task) {
    TaskResult result;
    const std::string name = absl::StrCat(task.stage, "#", task.number);
    for (const TaskMesh& mesh : task.meshes) {
      const auto rejection = rejections_.find({task.stage, mesh.index});
      if (rejection != rejections_.end()) {
        result.rejections.push_back({mesh.index, rejection->second});
      } else if (task.kind == TaskKind::kIngest) {
        result.ingested.push_back(Ingested(mesh.index));
      } else if (task.kind == TaskKind::kSymmetrize) {
        result.copies.push_back(
            {mesh.index, Name(names_[static_cast<size_t>(mesh.index)] + "*"), 0.5});
      }
    }
    if (task.wants_displacement) {
      result.alignments = Alignments(task, result, name);
    } else if (task.kind != TaskKind::kIngest && task.kind != TaskKind::kSymmetrize) {
      result.output = Name(name);
    }
    if (task.wants_displacement || task.wants_correspondences ||
        task.kind == TaskKind::kAlignAndCompare || task.kind == TaskKind::kSummarize) {
      result.second_output = Name(name + "+");
    }
    if (task.wants_pose) {
      result.poses = Name(name + "^");
    }
    if (task.wants_variation) {
      result.variation = Name(name + "~");
    }
    if (task.wants_placed) {
      result.placed = Name(name + "@");
    }
    if (task.kind == TaskKind::kChooseBase) {
      result.base = task.meshes.back().index;
    }
    result.counters.pairs = 1;
    return result;
  }

  /// Answers all ready tasks and returns them as text; the status of the last answer in `status`.
  [[nodiscard]] std::vector<std::string> RunReady(JobPlan& plan, absl::Status* status = nullptr) {
    std::vector<std::string> lines;
    absl::Status last;
    for (const Task& task : plan.TakeReadyTasks()) {
      lines.push_back(Line(task));
      last = plan.TaskFinished(task.number, ResultOf(task));
    }
    if (status != nullptr) {
      *status = last;
    } else {
      EXPECT_THAT(last, IsOk());
    }
    return lines;
  }
  /// Runs to the end; steps are separated by "--".
  [[nodiscard]] std::vector<std::string> RunAll(JobPlan& plan) {
    std::vector<std::string> lines;
    while (!plan.Done() && !::testing::Test::HasFailure()) {
      std::vector<std::string> step = RunReady(plan);
      if (step.empty()) {
        ADD_FAILURE() << "nothing is ready, but the plan is not done";
      }
      if (!lines.empty()) {
        lines.emplace_back("--");
      }
      lines.insert(lines.end(), step.begin(), step.end());
    }
    return lines;
  }
  /// Runs until the next ready task is of `stage`.
  void RunUntil(JobPlan& plan, const std::string& stage) {
    while (!plan.Done() && plan.CurrentProgress().stage != stage &&
           !::testing::Test::HasFailure()) {
      (void)RunReady(plan);
    }
  }

  [[nodiscard]] Digest Name(const std::string& name) {
    Digest digest = Sha256::Of(name);
    digest_names_[digest] = name;
    return digest;
  }
  [[nodiscard]] std::string NameOf(const Digest& digest) const {
    const auto found = digest_names_.find(digest);
    return digest.empty() ? "-" : found == digest_names_.end() ? "?" : found->second;
  }
  [[nodiscard]] std::string NamesOf(const std::vector<Digest>& digests) const {
    return absl::StrJoin(digests, " ", [this](std::string* out, const Digest& digest) {
      absl::StrAppend(out, NameOf(digest));
    });
  }

  [[nodiscard]] std::string Line(const Task& task) const {
    std::string line = absl::StrCat(task.number, " ", task.stage, ":");
    const auto add_meshes = [&](const std::vector<TaskMesh>& meshes) {
      for (const TaskMesh& mesh : meshes) {
        // The blob bears the mesh's name: anything else would be the wrong blob.
        const std::string blob = NameOf(mesh.blob);
        const std::string& name = names_[static_cast<size_t>(mesh.index)];
        EXPECT_EQ(mesh.name, name + ".ply");
        absl::StrAppend(&line, " ", blob);
      }
    };
    add_meshes(task.meshes);
    if (!task.targets.empty()) {
      absl::StrAppend(&line, " x");
      add_meshes(task.targets);
    }
    if (!task.reference.empty()) {
      absl::StrAppend(&line, " | to ", NameOf(task.reference));
    }
    if (!task.alignments.empty()) {
      absl::StrAppend(&line, " | from ", NamesOf(task.alignments));
    }
    if (!task.starts.empty()) {
      absl::StrAppend(&line, " | from ", NameOf(Sha256::Of(task.starts)));
    }
    if (!task.partials.empty()) {
      absl::StrAppend(&line, " | of ", NamesOf(task.partials));
    }
    if (!task.landmarks.empty()) {
      absl::StrAppend(&line, " | by ", NameOf(task.landmarks));
    }
    std::vector<std::string> flags;
    if (task.arithmetic == Arithmetic::kFidentis) flags.emplace_back("fidentis");
    if (task.wants_placed) flags.emplace_back("placed");
    if (task.wants_pose) flags.emplace_back("pose");
    if (task.wants_displacement) flags.emplace_back("displacement");
    if (task.wants_variation) flags.emplace_back("variation");
    if (task.wants_correspondences) flags.emplace_back("correspondences");
    if (task.counts_reference_index) flags.emplace_back("counts index");
    if (task.moves_reference) flags.emplace_back("moves reference");
    if (!flags.empty()) {
      absl::StrAppend(&line, " | ", absl::StrJoin(flags, ", "));
    }
    return line;
  }

 public:
  /// Of every mesh. So large by default that tiles are divided by the number of meshes alone.
  int64_t vertices = 700000;

 private:
  /// Of the meshes that are not rejected; bear the name, too.
  [[nodiscard]] std::string Alignments(const Task& task,
                                       const TaskResult& result,
                                       const std::string& name) {
    std::vector<MeshAlignment> alignments;
    for (const TaskMesh& mesh : task.meshes) {
      const bool is_rejected =
          std::any_of(result.rejections.begin(), result.rejections.end(),
                      [&](const MeshRejection& one) { return one.index == mesh.index; });
      if (!is_rejected) {
        alignments.push_back({.mesh = mesh.index, .alignment = {}});
        alignments.back().alignment.lookups = task.number;
      }
    }
    std::string bytes = EncodeAlignmentBlob(alignments);
    digest_names_[Sha256::Of(bytes)] = name;
    return bytes;
  }
  IngestedMesh Ingested(int32_t index) {
    const auto place = static_cast<size_t>(index);
    IngestedMesh mesh;
    mesh.index = index;
    mesh.blob = Name(names_[place]);
    mesh.vertices = vertices;
    mesh.centroid = {1.0 * index, 2.0 * index, 3.0 * index};
    mesh.health.rms_radius = radii_[place];
    return mesh;
  }

  std::vector<std::string> names_;
  std::vector<SetMesh> meshes_;
  std::vector<double> radii_;
  std::map<std::pair<std::string, int32_t>, std::string> rejections_;
  std::map<Digest, std::string> digest_names_;
};

/// A spec with few rounds.
inline JobSpec SpecOf(Method method, PoseMode pose = PoseMode::kPrincipalAxes, int rounds = 1) {
  JobSpec spec;
  spec.method = method;
  spec.pose = pose;
  spec.rounds = rounds;
  return spec;
}

}  // namespace cohort::testing
