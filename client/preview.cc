#include "client/preview.h"

#include <algorithm>
#include <vector>

#include "client/files.h"
#include "common/base/status_macros.h"
#include "common/report/csv.h"
#include "common/report/heatmap.h"
#include "common/report/job_meshes.h"

namespace cohort {

absl::StatusOr<int64_t> WritePreview(Session& session,
                                     const Job& job,
                                     const std::filesystem::path& folder) {
  COHORT_ASSIGN_OR_RETURN(const std::vector<JobMesh> meshes, session.ListJobMeshes(job.id));
  COHORT_ASSIGN_OR_RETURN(const RowMajorMatrix values,
                          session.GetPreview(job.id, static_cast<int64_t>(meshes.size())));
  const MetricMatrix matrix = WithoutRejected(values, meshes);
  COHORT_RETURN_IF_ERROR(PrepareFolder(folder));
  COHORT_RETURN_IF_ERROR(WriteWholeFile(folder / "preview_matrix.csv",
                                        MatrixCsv(matrix, "preview of corresponded rms")));
  const MatrixDescription description{.method = job.spec.method, .is_preview = true};
  COHORT_ASSIGN_OR_RETURN(const std::string picture, HeatmapPng(matrix, description));
  COHORT_RETURN_IF_ERROR(WriteWholeFile(folder / "preview_heatmap.png", picture));
  return static_cast<int64_t>(matrix.labels.size());
}

bool HasFreshPreview(const Job& job) {
  const std::vector<StageTime>& stages = job.progress.stages;
  return job.spec.preview && job.state == JobState::kRunning &&
         std::any_of(stages.begin(), stages.end(),
                     [](const StageTime& stage) { return stage.name == "compare"; });
}

}  // namespace cohort
