#include "client/fetched_job.h"

#include "client/fetched_matrix.h"
#include "common/base/status_macros.h"
#include "common/report/job_meshes.h"
#include "common/store/mesh_blob.h"

namespace cohort {
namespace {

std::vector<std::string> UnmeasuredMeshes(const MatrixView& directed) {
  std::vector<std::string> names;
  for (Eigen::Index row = 0; row < directed.values.rows(); ++row) {
    const auto unknown = directed.values.row(row).array().isNaN();
    const Eigen::Index off_diagonal = unknown.count() - (unknown(row) ? 1 : 0);
    if (off_diagonal == directed.values.cols() - 1) {
      names.push_back(directed.labels[static_cast<size_t>(row)]);
    }
  }
  return names;
}

absl::StatusOr<TriangleMesh> FetchMesh(Session& session, const Digest& blob) {
  COHORT_ASSIGN_OR_RETURN(const std::string bytes, session.Blobs().Get(blob));
  return DecodeMeshBlob(bytes);
}

absl::StatusOr<std::vector<MeshAlignment>> FetchAlignments(Session& session,
                                                           const std::vector<Digest>& blobs) {
  std::vector<MeshAlignment> alignments;
  for (const Digest& blob : blobs) {
    COHORT_ASSIGN_OR_RETURN(const std::string bytes, session.Blobs().Get(blob));
    COHORT_ASSIGN_OR_RETURN(const std::vector<MeshAlignment> some, DecodeAlignmentBlob(bytes));
    alignments.insert(alignments.end(), some.begin(), some.end());
  }
  return alignments;
}

}  // namespace

absl::StatusOr<FetchedJob> FetchJob(Session& session,
                                    const JobId& id,
                                    std::optional<Metric> metric) {
  FetchedJob fetched;
  COHORT_ASSIGN_OR_RETURN(fetched.job, session.GetJob(id));
  if (metric) {
    fetched.job.spec.metric = *metric;
  }
  COHORT_ASSIGN_OR_RETURN(const JobOutputs outputs, session.GetOutputs(id));
  COHORT_ASSIGN_OR_RETURN(fetched.meshes, session.ListJobMeshes(id));
  COHORT_ASSIGN_OR_RETURN(fetched.matrix,
                          FetchMatrix(session, id, fetched.job.spec.metric, fetched.meshes));
  fetched.unmeasured = UnmeasuredMeshes(fetched.matrix.View());
  if (fetched.job.spec.symmetrization != Symmetrization::kDirected) {
    Symmetrize(
        fetched.job.spec.symmetrization == Symmetrization::kMax ? PairRule::kMax : PairRule::kMean,
        fetched.matrix.Values());
  }
  fetched.persons = PersonsOf(fetched.matrix.Labels(), fetched.meshes);
  COHORT_ASSIGN_OR_RETURN(fetched.alignments, FetchAlignments(session, outputs.alignments));
  COHORT_ASSIGN_OR_RETURN(fetched.poses, FetchAlignments(session, outputs.poses));
  COHORT_ASSIGN_OR_RETURN(fetched.mean_shape, FetchMesh(session, outputs.mean_shape));
  fetched.variation_shape = fetched.mean_shape;
  if (!outputs.variation_shape.empty()) {
    COHORT_ASSIGN_OR_RETURN(fetched.variation_shape, FetchMesh(session, outputs.variation_shape));
  }
  COHORT_ASSIGN_OR_RETURN(const std::string summary, session.Blobs().Get(outputs.summary));
  COHORT_ASSIGN_OR_RETURN(fetched.variation, DecodeSummaryBlob(summary));
  if (!outputs.base_choice.empty()) {
    COHORT_ASSIGN_OR_RETURN(const std::string choice, session.Blobs().Get(outputs.base_choice));
    COHORT_ASSIGN_OR_RETURN(fetched.base_choice, DecodeBaseBlob(choice));
  }
  return fetched;
}

std::vector<size_t> MeshesOfRows(const FetchedJob& fetched) {
  std::vector<size_t> meshes;
  for (size_t mesh = 0; mesh < fetched.meshes.size(); ++mesh) {
    if (fetched.meshes[mesh].rejection.empty()) meshes.push_back(mesh);
  }
  return meshes;
}

std::vector<Similarity> TransformsOf(const FetchedJob& fetched) {
  std::vector<Similarity> transforms(fetched.meshes.size());
  for (const MeshAlignment& one : fetched.alignments) {
    transforms[static_cast<size_t>(one.mesh)] = one.alignment.T_target_source;
  }
  return transforms;
}

absl::StatusOr<TriangleMesh> FetchJobMesh(Session& session,
                                          const FetchedJob& fetched,
                                          size_t mesh) {
  const JobMesh& job_mesh = fetched.meshes[mesh];
  if (!job_mesh.ingested) return absl::NotFoundError("no mesh of " + job_mesh.mesh.name);
  return FetchMesh(session, job_mesh.copy ? job_mesh.copy->blob : job_mesh.ingested->blob);
}

}  // namespace cohort
