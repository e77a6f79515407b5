#include "worker/tasks/variation_task.h"

#include <array>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "common/base/status_macros.h"
#include "common/geometry/comparison/metrics.h"
#include "common/geometry/registration/mean_shape.h"
#include "common/jobs/blobs.h"
#include "common/store/mesh_blob.h"
#include "worker/tasks/displacement_finder.h"
#include "worker/tasks/variation_output.h"

namespace cohort {

absl::StatusOr<TaskResult> RunVariationTask(const Task& task, const TaskContext& context) {
  COHORT_ASSIGN_OR_RETURN(
      DisplacementFinder displacements,
      DisplacementFinder::Create(task.reference, task.icp.correspondence, context));
  COHORT_ASSIGN_OR_RETURN(const auto alignments, LoadAlignments(context.store, task.alignments));
  TaskResult result;
  VariationOutput output(task, displacements.VertexCount());
  for (const TaskMesh& input : task.meshes) {
    COHORT_RETURN_IF_ERROR(context.CheckStop());
    COHORT_ASSIGN_OR_RETURN(const Similarity T_reference_mesh, SimilarityOf(alignments, input));
    COHORT_ASSIGN_OR_RETURN(const Eigen::Matrix3Xd displacement,
                            displacements.Find(input.blob, T_reference_mesh));
    output.Add(input.index, displacement, result.counters);
  }
  const VariationOutput::Blobs blobs = std::move(output).Encode();
  const std::array<TaskBlob, 3> written = {{{blobs.variation, result.output},
                                            {blobs.signatures, result.fields},
                                            {blobs.correspondences, result.second_output}}};
  COHORT_RETURN_IF_ERROR(WriteBlobs(context, written));
  return result;
}

absl::StatusOr<TaskResult> RunSummarizeTask(const Task& task, const TaskContext& context) {
  COHORT_ASSIGN_OR_RETURN(const auto reference, context.meshes.Get(task.reference));
  std::vector<Eigen::MatrixXf> distances;
  Eigen::Matrix3Xd sum = Eigen::Matrix3Xd::Zero(3, reference->VertexCount());
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
    if (task.moves_reference) {
      sum += part.displacement.sum.cast<double>();
    }
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
    mean_shape.vertices =
        MoveByMeanDisplacement(reference->vertices, std::span(&sum, 1), summary.mesh_count);
  }
  const std::string summary_blob = EncodeSummaryBlob(summary);
  const std::string mean_blob = EncodeRawMeshBlob(mean_shape);
  TaskResult result;
  const std::array<TaskBlob, 2> written = {
      {{summary_blob, result.output}, {mean_blob, result.second_output}}};
  COHORT_RETURN_IF_ERROR(WriteBlobs(context, written));
  return result;
}

}  // namespace cohort
