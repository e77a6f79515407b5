#include "client/preview.h"

#include <algorithm>
#include <vector>

#include "client/fetched_matrix.h"
#include "client/files.h"
#include "client/matrix_writer.h"
#include "common/base/status_macros.h"
#include "common/report/heatmap.h"

namespace cohort {

absl::StatusOr<int64_t> WritePreview(Session& session,
                                     const Job& job,
                                     const std::filesystem::path& folder) {
  COHORT_ASSIGN_OR_RETURN(const std::vector<JobMesh> meshes, session.ListJobMeshes(job.id));
  COHORT_ASSIGN_OR_RETURN(const LargeMatrix matrix, FetchPreview(session, job.id, meshes));
  const MatrixView view = matrix.View();
  COHORT_RETURN_IF_ERROR(PrepareFolder(folder));
  SerialExecutor executor;
  COHORT_RETURN_IF_ERROR(
      WriteMatrixCsv(folder / "preview_matrix.csv", view, "preview of corresponded rms", executor));
  const MatrixDescription description{.method = job.spec.method, .is_preview = true};
  COHORT_ASSIGN_OR_RETURN(const std::string picture, HeatmapPng(view, description));
  COHORT_RETURN_IF_ERROR(WriteWholeFile(folder / "preview_heatmap.png", picture));
  return std::ssize(view.labels);
}

bool HasFreshPreview(const Job& job) {
  const std::vector<StageTime>& stages = job.progress.stages;
  return job.spec.preview && job.state == JobState::kRunning &&
         std::any_of(stages.begin(), stages.end(),
                     [](const StageTime& stage) { return stage.name == "compare"; });
}

}  // namespace cohort
