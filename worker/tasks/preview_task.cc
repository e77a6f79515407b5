#include "worker/tasks/preview_task.h"

#include <algorithm>
#include <string>
#include <vector>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "common/jobs/preview_blobs.h"

namespace cohort {
namespace {

absl::StatusOr<std::vector<CorrespondencePart>> LoadParts(const Task& task,
                                                          const TaskContext& context) {
  std::vector<CorrespondencePart> parts;
  for (const Digest& blob : task.partials) {
    COHORT_RETURN_IF_ERROR(context.CheckStop());
    COHORT_ASSIGN_OR_RETURN(const std::string bytes, context.store.Get(blob));
    COHORT_ASSIGN_OR_RETURN(CorrespondencePart part, DecodeCorrespondenceBlob(bytes));
    if (!parts.empty() && part.fields.VertexCount() != parts.front().fields.VertexCount()) {
      return absl::DataLossError(absl::StrCat("correspondence blob ", blob.Hex(), " has ",
                                              part.fields.VertexCount(), " vertices, another ",
                                              parts.front().fields.VertexCount()));
    }
    parts.push_back(std::move(part));
  }
  if (parts.empty()) {
    return absl::DataLossError("preview task without correspondences");
  }
  return parts;
}

absl::Status AddField(const std::vector<CorrespondencePart>& parts,
                      const TaskMesh& mesh,
                      DisplacementFields& fields) {
  for (const CorrespondencePart& part : parts) {
    const auto found = std::find(part.meshes.begin(), part.meshes.end(), mesh.index);
    if (found != part.meshes.end()) {
      const int64_t at = found - part.meshes.begin();
      fields.AddSteps(part.fields.StepExponent(at), part.fields.Values(at));
      return absl::OkStatus();
    }
  }
  return absl::DataLossError(
      absl::StrCat("no correspondences of mesh ", mesh.index, " (", mesh.name, ")"));
}

absl::StatusOr<DisplacementFields> FieldsOf(const std::vector<CorrespondencePart>& parts,
                                            const std::vector<TaskMesh>& meshes) {
  DisplacementFields fields(parts.front().fields.VertexCount());
  for (const TaskMesh& mesh : meshes) {
    COHORT_RETURN_IF_ERROR(AddField(parts, mesh, fields));
  }
  return fields;
}

std::vector<int32_t> IndicesOf(const std::vector<TaskMesh>& meshes) {
  std::vector<int32_t> indices(meshes.size());
  std::transform(meshes.begin(), meshes.end(), indices.begin(),
                 [](const TaskMesh& mesh) { return mesh.index; });
  return indices;
}

absl::StatusOr<Eigen::MatrixXd> MeasureTargets(const std::vector<CorrespondencePart>& parts,
                                               const Task& task,
                                               const DisplacementFields& rows) {
  if (task.meshes == task.targets) {
    return CorrespondedRms(rows, rows);
  }
  COHORT_ASSIGN_OR_RETURN(const DisplacementFields columns, FieldsOf(parts, task.targets));
  return CorrespondedRms(rows, columns);
}

}  // namespace

absl::StatusOr<TaskResult> RunPreviewTask(const Task& task, const TaskContext& context) {
  COHORT_ASSIGN_OR_RETURN(const auto parts, LoadParts(task, context));
  COHORT_ASSIGN_OR_RETURN(const DisplacementFields rows, FieldsOf(parts, task.meshes));
  COHORT_ASSIGN_OR_RETURN(const Eigen::MatrixXd rms, MeasureTargets(parts, task, rows));
  PreviewBlock block = {
      .rows = IndicesOf(task.meshes), .columns = IndicesOf(task.targets), .values = {}};
  block.values.reserve(static_cast<size_t>(rms.size()));
  for (Eigen::Index row = 0; row < rms.rows(); ++row) {
    for (Eigen::Index column = 0; column < rms.cols(); ++column) {
      block.values.push_back(rms(row, column));
    }
  }
  TaskResult result;
  COHORT_ASSIGN_OR_RETURN(result.output, context.store.Put(EncodePreviewBlob(block)));
  return result;
}

}  // namespace cohort
