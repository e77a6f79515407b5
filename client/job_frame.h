#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include <absl/status/statusor.h>

#include "client/session.h"
#include "common/base/executor.h"
#include "common/jobs/blobs.h"
#include "common/pairs/pair_mesh.h"
#include "common/pairs/vertex_weights.h"

namespace cohort {

/// A mesh of a finished job, where it was measured.
struct FramedMesh {
  TriangleMesh mesh;        ///< As it was compared: the canonical mesh or its symmetric copy.
  Similarity T_frame_mesh;  ///< Identity for method none.
  PairMesh placed;
};

/// A finished job, and its meshes where they were measured, so that pairs can be measured once more
/// on this machine. Thread-safe after Open.
class JobFrame {
 public:
  /// @param blobs  of the session's server; must outlive this.
  /// @return kFailedPrecondition if the job has not succeeded; as Session's calls.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<JobFrame>> Open(Session& session,
                                                                      BlobStore& blobs,
                                                                      const JobId& id);

  [[nodiscard]] const Job& GetJob() const { return job_; }
  /// All meshes of the job, rejected ones too.
  [[nodiscard]] const std::vector<JobMesh>& Meshes() const { return meshes_; }
  [[nodiscard]] const JobOutputs& Outputs() const { return outputs_; }
  /// Indices of the meshes that were not rejected, ascending.
  [[nodiscard]] const std::vector<int32_t>& Active() const { return active_; }
  [[nodiscard]] Eigen::Vector3d Center() const {
    return Eigen::Vector3d(outputs_.frame.center.data());
  }
  /// Whether the pairs were measured in one frame, by our arithmetic; what loads meshes below needs
  /// it. @return kFailedPrecondition for method each and for the preset fidentis.
  [[nodiscard]] absl::Status CheckHasFrame() const;
  /// @return kNotFound if the job has no such mesh, kFailedPrecondition if it was rejected.
  [[nodiscard]] absl::StatusOr<int32_t> IndexOf(const std::string& name) const;
  /// What is fetched is checked against its digest.
  [[nodiscard]] absl::StatusOr<FramedMesh> Load(int32_t index,
                                                const PairMeshOptions& options) const;
  /// The same for all active meshes, in the order of Active().
  [[nodiscard]] absl::StatusOr<std::vector<FramedMesh>> LoadAll(const PairMeshOptions& options,
                                                                Executor& executor) const;
  /// What the meshes were aligned to. @return kFailedPrecondition for method none.
  [[nodiscard]] absl::StatusOr<TriangleMesh> LoadReference() const;
  /// `weights`, one per vertex of the mean shape, as a region.
  [[nodiscard]] absl::StatusOr<RegionMask> MakeRegion(std::vector<double> weights) const;
  [[nodiscard]] absl::StatusOr<TriangleMesh> LoadMeanShape() const;
  [[nodiscard]] BlobStore& Blobs() const { return *blobs_; }

 private:
  JobFrame() = default;
  absl::Status LoadAlignments();

  BlobStore* blobs_ = nullptr;
  Job job_;
  std::vector<JobMesh> meshes_;
  JobOutputs outputs_;
  std::vector<int32_t> active_;
  std::map<int32_t, Similarity> T_frame_mesh_;
};

/// The first error by index, if any.
[[nodiscard]] absl::Status FirstError(const std::vector<absl::Status>& statuses);

/// Threads for work on this machine: all processors.
[[nodiscard]] int LocalThreads();

}  // namespace cohort
