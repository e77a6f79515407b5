#include "client/fetched_matrix.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "common/base/status_macros.h"

namespace cohort {
namespace {

/// The rows that the meshes of a job have in its matrix.
struct Rows {
  std::vector<std::string> labels;
  std::vector<int64_t> of_mesh;  ///< -1: it was rejected.
};

Rows RowsOf(std::span<const JobMesh> meshes) {
  Rows rows;
  for (const JobMesh& mesh : meshes) {
    const bool is_in = mesh.rejection.empty();
    rows.of_mesh.push_back(is_in ? std::ssize(rows.labels) : -1);
    if (is_in) {
      rows.labels.push_back(mesh.mesh.name);
    }
  }
  return rows;
}

/// What is known of only one direction of a pair goes for the other too.
void FillFromOtherHalf(Eigen::Ref<RowMajorMatrix> matrix) {
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    for (Eigen::Index column = 0; column < row; ++column) {
      double& there = matrix(row, column);
      double& back = matrix(column, row);
      if (std::isnan(there)) {
        there = back;
      } else if (std::isnan(back)) {
        back = there;
      }
    }
  }
}

}  // namespace

absl::Status PutPart(const MatrixPart& part,
                     std::span<const int64_t> row_of,
                     Eigen::Ref<RowMajorMatrix> matrix) {
  const auto is_foreign = [&](int32_t mesh) { return mesh < 0 || mesh >= std::ssize(row_of); };
  if (std::any_of(part.rows.begin(), part.rows.end(), is_foreign) ||
      std::any_of(part.columns.begin(), part.columns.end(), is_foreign)) {
    return absl::DataLossError("the server sent values of meshes that the job does not have");
  }
  const double* value = part.values.data();
  for (const int32_t source : part.rows) {
    const int64_t row = row_of[static_cast<size_t>(source)];
    for (const int32_t target : part.columns) {
      const int64_t column = row_of[static_cast<size_t>(target)];
      if (row >= 0 && column >= 0) {
        matrix(row, column) = *value;
      }
      ++value;
    }
  }
  return absl::OkStatus();
}

absl::StatusOr<LargeMatrix> FetchMatrix(Session& session,
                                        const JobId& id,
                                        Metric metric,
                                        std::span<const JobMesh> meshes) {
  Rows rows = RowsOf(meshes);
  LargeMatrix matrix(std::move(rows.labels));
  COHORT_RETURN_IF_ERROR(session.ReadMatrix(id, metric, [&](const MatrixPart& part) {
    return PutPart(part, rows.of_mesh, matrix.Values());
  }));
  return matrix;
}

absl::StatusOr<LargeMatrix> FetchPreview(Session& session,
                                         const JobId& id,
                                         std::span<const JobMesh> meshes) {
  Rows rows = RowsOf(meshes);
  LargeMatrix matrix(std::move(rows.labels));
  COHORT_RETURN_IF_ERROR(session.ReadPreview(
      id, [&](const MatrixPart& part) { return PutPart(part, rows.of_mesh, matrix.Values()); }));
  FillFromOtherHalf(matrix.Values());
  return matrix;
}

}  // namespace cohort
