#include "worker/tasks/variation_task.h"

#include <string>
#include <utility>
#include <vector>

#include "common/base/status_macros.h"
#include "common/geometry/comparison/metrics.h"
#include "common/geometry/registration/mean_shape.h"
#include "common/jobs/blobs.h"
#include "common/jobs/preview_blobs.h"
#include "common/pairs/signature.h"
#include "common/store/mesh_blob.h"
#include "worker/tasks/displacement_finder.h"

namespace cohort {

absl::StatusOr<TaskResult> RunVariationTask(const Task& task, const TaskContext& context) {
  COHORT_ASSIGN_OR_RETURN(
      DisplacementFinder displacements,
      DisplacementFinder::Create(task.reference, task.icp.correspondence, context));
  COHORT_ASSIGN_OR_RETURN(const auto alignments, LoadAlignments(context.store, task.alignments));
  const int64_t n = displacements.VertexCount();
  TaskResult result;
  CorrespondencePart correspondences{.meshes = {}, .fields = DisplacementFields(n)};
  CorrespondencePart signatures{.meshes = {},
                                .fields = DisplacementFields(std::ssize(SignatureVertices(n)))};
  VariationPart part;
  part.distances.resize(n, static_cast<Eigen::Index>(task.meshes.size()));
  part.displacement.sum = Eigen::Matrix3Xd::Zero(3, task.moves_reference ? n : 0);
  for (size_t k = 0; k < task.meshes.size(); ++k) {
    COHORT_RETURN_IF_ERROR(context.CheckStop());
    const TaskMesh& input = task.meshes[k];
    COHORT_ASSIGN_OR_RETURN(const Similarity T_reference_mesh, SimilarityOf(alignments, input));
    COHORT_ASSIGN_OR_RETURN(const Eigen::Matrix3Xd displacement,
                            displacements.Find(input.blob, T_reference_mesh));
    part.distances.col(static_cast<Eigen::Index>(k)) =
        displacement.colwise().norm().transpose().cast<float>();
    if (task.moves_reference) {
      part.displacement.sum += displacement;
    }
    ++part.displacement.mesh_count;
    part.meshes.push_back(input.index);
    signatures.meshes.push_back(input.index);
    signatures.fields.Add(SignatureOf(displacement));
    if (task.wants_displacement) {
      correspondences.meshes.push_back(input.index);
      correspondences.fields.Add(displacement.cast<float>());
    }
    result.counters.variation += {.index_builds = 1, .lookups = n};
  }
  COHORT_ASSIGN_OR_RETURN(result.output, context.store.Put(EncodeVariationBlob(part)));
  COHORT_ASSIGN_OR_RETURN(result.fields, context.store.Put(EncodeCorrespondenceBlob(signatures)));
  if (task.wants_displacement) {
    COHORT_ASSIGN_OR_RETURN(result.second_output,
                            context.store.Put(EncodeCorrespondenceBlob(correspondences)));
  }
  return result;
}

absl::StatusOr<TaskResult> RunSummarizeTask(const Task& task, const TaskContext& context) {
  COHORT_ASSIGN_OR_RETURN(const auto reference, context.meshes.Get(task.reference));
  std::vector<Eigen::MatrixXf> distances;
  std::vector<Eigen::Matrix3Xd> sums;
  VariationSummary summary;
  for (const Digest& blob : task.partials) {
    COHORT_RETURN_IF_ERROR(context.CheckStop());
    COHORT_ASSIGN_OR_RETURN(const std::string bytes, context.store.Get(blob));
    COHORT_ASSIGN_OR_RETURN(VariationPart part, DecodeVariationBlob(bytes));
    const int64_t moved = task.moves_reference ? reference->VertexCount() : 0;
    if (part.distances.rows() != reference->VertexCount() ||
        part.displacement.sum.cols() != moved) {
      return absl::DataLossError("variation blob " + blob.Hex() + " does not fit the reference");
    }
    summary.mesh_count += part.displacement.mesh_count;
    distances.push_back(std::move(part.distances));
    sums.push_back(std::move(part.displacement.sum));
  }
  std::vector<double> values;
  for (Eigen::Index vertex = 0; vertex < reference->vertices.cols(); ++vertex) {
    values.clear();
    for (const Eigen::MatrixXf& part : distances) {
      for (Eigen::Index k = 0; k < part.cols(); ++k) {
        values.push_back(static_cast<double>(part(vertex, k)));
      }
    }
    summary.values.push_back(MetricsOfDistances(values));
  }
  TriangleMesh mean_shape = *reference;
  if (task.moves_reference) {
    mean_shape.vertices = MoveByMeanDisplacement(reference->vertices, sums, summary.mesh_count);
  }
  TaskResult result;
  COHORT_ASSIGN_OR_RETURN(result.output, context.store.Put(EncodeSummaryBlob(summary)));
  COHORT_ASSIGN_OR_RETURN(result.second_output, context.store.Put(EncodeRawMeshBlob(mean_shape)));
  return result;
}

}  // namespace cohort
