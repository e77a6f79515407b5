#include "worker/tasks/choose_base_task.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "common/base/status_macros.h"
#include "common/jobs/blobs.h"
#include "worker/tasks/align_task.h"
#include "worker/tasks/pose_finder.h"

namespace cohort {
namespace {

constexpr int64_t kMostCandidates = 300;
constexpr int64_t kAlignedVertices = 1000;
constexpr int64_t kMeasuredVertices = 500;
constexpr int kMostIterations = 50;
constexpr double kRelativeTolerance = 1e-5;  ///< Of the RMS radius; a centre need not be exact.

/// A mesh in the frame of the first one.
struct Candidate {
  int32_t index = 0;
  std::shared_ptr<const PackedMesh> vertices;
  std::unique_ptr<const PackedMesh> sample;
};

std::vector<TaskMesh> EvenlySpaced(const std::vector<TaskMesh>& meshes) {
  const auto count = static_cast<int64_t>(meshes.size());
  const int64_t taken = std::min(count, kMostCandidates);
  std::vector<TaskMesh> chosen;
  for (int64_t i = 0; i < taken; ++i) {
    chosen.push_back(meshes[static_cast<size_t>(i * count / taken)]);
  }
  return chosen;
}

/// The job's alignment, made cheap.
Task CheapAlignment(const Task& task, double radius) {
  Task cheap = task;
  cheap.undersampling = {.method = UndersamplingMethod::kRandom, .count = kAlignedVertices};
  cheap.icp.max_iterations = std::min(cheap.icp.max_iterations, kMostIterations);
  cheap.icp.tolerance = kRelativeTolerance * radius;
  return cheap;
}

double RmsRadius(const TriangleMesh& mesh) {
  const Eigen::Vector3d center = mesh.vertices.rowwise().mean();
  return std::sqrt((mesh.vertices.colwise() - center).squaredNorm() /
                   static_cast<double>(mesh.VertexCount()));
}

/// Candidates that could be brought to the first mesh; one that could not is no centre.
absl::StatusOr<std::vector<Candidate>> Place(const Task& task, const TaskContext& context) {
  const std::vector<TaskMesh> inputs = EvenlySpaced(task.meshes);
  COHORT_ASSIGN_OR_RETURN(const auto first, context.meshes.Get(inputs.front().blob));
  COHORT_ASSIGN_OR_RETURN(const auto target, context.meshes.GetIcpMesh(inputs.front().blob));
  COHORT_ASSIGN_OR_RETURN(const PoseFinder poses,
                          PoseFinder::Create(task, inputs.front(), context));
  const Task cheap = CheapAlignment(task, RmsRadius(*first));
  PacketSearch search;
  std::vector<Candidate> candidates;
  for (const TaskMesh& input : inputs) {
    COHORT_RETURN_IF_ERROR(context.CheckStop());
    COHORT_ASSIGN_OR_RETURN(const auto mesh, context.meshes.Get(input.blob));
    const absl::StatusOr<CoarsePose> pose = poses.Find(input);
    if (!pose.ok()) {
      continue;
    }
    const absl::StatusOr<Alignment> aligned =
        AlignMesh(cheap, input, *target, pose->T_target_source, context, search);
    if (!aligned.ok()) {
      continue;
    }
    Candidate candidate{.index = input.index, .vertices = nullptr, .sample = nullptr};
    COHORT_ASSIGN_OR_RETURN(
        candidate.vertices,
        context.meshes.GetPlaced(input.blob, aligned->T_target_source, target->Center()));
    const UndersamplingOptions sampling = {.method = UndersamplingMethod::kRandom,
                                           .count = kMeasuredVertices};
    COHORT_ASSIGN_OR_RETURN(const std::vector<int32_t> kept, SelectVertices(*mesh, sampling));
    const Eigen::Matrix3Xd sample = mesh->vertices(Eigen::all, kept);
    candidate.sample = std::make_unique<const PackedMesh>(
        (aligned->T_target_source.Apply(sample).colwise() - target->Center()).cast<float>());
    candidates.push_back(std::move(candidate));
  }
  return candidates;
}

double MeanDistance(const PackedMesh& sample, const PackedMesh& target, PacketSearch& search) {
  NearestSlots nearest;
  search.Find(sample, target, nearest);
  double sum = 0;
  for (size_t slot = 0; slot < static_cast<size_t>(sample.VertexCount()); ++slot) {
    sum += std::sqrt(nearest.squared_distances[slot]);
  }
  return sum / sample.VertexCount();
}

}  // namespace

absl::StatusOr<TaskResult> RunChooseBaseTask(const Task& task, const TaskContext& context) {
  COHORT_ASSIGN_OR_RETURN(const std::vector<Candidate> candidates, Place(task, context));
  if (candidates.empty()) {
    return absl::FailedPreconditionError("no mesh can serve as base: none could be aligned to " +
                                         task.meshes.front().name);
  }
  std::vector<double> sums(candidates.size(), 0);
  PacketSearch search;
  TaskResult result;
  for (size_t a = 0; a < candidates.size(); ++a) {
    COHORT_RETURN_IF_ERROR(context.CheckStop());
    for (size_t b = 0; b < candidates.size(); ++b) {
      if (a == b) {
        continue;
      }
      const double mean = MeanDistance(*candidates[a].sample, *candidates[b].vertices, search);
      sums[a] += mean / 2;  // A pair counts for both, once from each side.
      sums[b] += mean / 2;
      result.counters.pose.lookups += candidates[a].sample->VertexCount();
    }
  }
  BaseChoice choice;
  const double others = std::max(1.0, static_cast<double>(candidates.size()) - 1);
  for (size_t i = 0; i < candidates.size(); ++i) {
    choice.candidates.push_back({.mesh = candidates[i].index, .mean_distance = sums[i] / others});
  }
  const auto best = std::min_element(sums.begin(), sums.end());  // the first on a tie
  choice.base = candidates[static_cast<size_t>(best - sums.begin())].index;
  result.base = choice.base;
  COHORT_ASSIGN_OR_RETURN(result.output, context.store.Put(EncodeBaseBlob(choice)));
  return result;
}

}  // namespace cohort
