#pragma once

#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <string>
#include <unordered_map>

#include <absl/status/statusor.h>

#include "common/base/mutex.h"
#include "common/base/sha256.h"
#include "common/geometry/mesh/triangle_mesh.h"
#include "common/geometry/nearest/correspondence.h"
#include "common/geometry/nearest/packed_mesh.h"
#include "common/geometry/nearest/packed_surface.h"
#include "common/geometry/registration/coarse_pose.h"
#include "common/geometry/registration/icp_mesh.h"
#include "common/geometry/registration/similarity.h"
#include "common/geometry/registration/undersampling.h"
#include "common/jobs/landmark_blob.h"
#include "common/store/blob_store.h"
#include "worker/tasks/shared_meshes.h"

namespace cohort {

/// Decoded meshes, their packed forms and landmark tables, shared by the slots of a worker; the
/// least recently used go first when the limit is reached. Thread-safe.
class MeshCache {
 public:
  /// @param max_bytes  kept; what is in use may exceed it.
  /// @param shared     what the workers of this machine share; may be null.
  MeshCache(BlobStore& store, int64_t max_bytes, SharedMeshes* shared = nullptr)
      : store_(store), max_bytes_(max_bytes), shared_(shared) {}

  /// @return as BlobStore::Get and DecodeMeshBlob, naming the blob.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<const TriangleMesh>> Get(const Digest& blob);
  /// All landmarks of a job: fetched and decoded once, not for each of its tasks.
  /// @return as BlobStore::Get and DecodeLandmarkBlob.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<const LandmarkTable>> GetLandmarks(
      const Digest& blob);
  /// Keeps a mesh that this worker has just made, so that it need not decode its blob.
  void Keep(const Digest& blob, TriangleMesh mesh);
  /// The mesh as the target of coarse poses.
  /// @return also as PoseShape::Create.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<const PoseShape>> GetPoseShape(const Digest& blob);
  /// The mesh as registration reads it, with its open boundary.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<const IcpMesh>> GetIcpMesh(const Digest& blob);
  /// The same as a target of these correspondences: with its surface if they need it.
  /// @return also kFailedPrecondition for a point cloud where a surface is needed.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<const IcpMesh>> GetIcpTarget(
      const Digest& blob, Correspondence correspondence);
  /// The vertices that take part in alignments as the source: all of them, or a selection.
  /// @return also as SelectVertices.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<const IcpMesh>> GetSampled(
      const Digest& blob, const UndersamplingOptions& undersampling);
  /// The vertices T_frame_mesh * x - frame_center in packets.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<const PackedMesh>> GetPlaced(
      const Digest& blob, const Similarity& T_frame_mesh, const Eigen::Vector3d& frame_center);

  /// Makes those vertices ready for the other workers of this machine, if there are any: who has
  /// the mesh at hand can do it, the others would have to decode it.
  /// @return as GetPlaced.
  [[nodiscard]] absl::Status SharePlaced(const Digest& blob,
                                         const Similarity& T_frame_mesh,
                                         const Eigen::Vector3d& frame_center);

  /// The same vertices with the faces.
  /// @return also kFailedPrecondition for a point cloud.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<const PackedSurface>> GetPlacedSurface(
      const Digest& blob, const Similarity& T_frame_mesh, const Eigen::Vector3d& frame_center);

  /// Kept now, decoded.
  [[nodiscard]] int64_t Bytes() {
    const MutexLock lock(mutex_);
    return bytes_;
  }

 private:
  struct Entry {
    std::shared_ptr<const void> value;
    int64_t bytes = 0;
    std::list<std::string>::iterator use;
  };
  template <typename T>
  struct Made {
    std::shared_ptr<const T> value;
    int64_t bytes = 0;
  };
  /// The value under `key`; made by `make` (which returns a StatusOr<Made<T>>) if it is not there.
  template <typename T, typename Make>
  absl::StatusOr<std::shared_ptr<const T>> GetOrMake(const std::string& key, Make make);
  absl::StatusOr<TriangleMesh> Decode(const Digest& blob);
  std::shared_ptr<const void> Find(const std::string& key) ABSL_LOCKS_EXCLUDED(mutex_);
  void Insert(const std::string& key, std::shared_ptr<const void> value, int64_t bytes)
      ABSL_LOCKS_EXCLUDED(mutex_);

  BlobStore& store_;
  const int64_t max_bytes_;
  SharedMeshes* const shared_;
  Mutex mutex_;
  std::unordered_map<std::string, Entry> entries_ ABSL_GUARDED_BY(mutex_);
  std::list<std::string> uses_ ABSL_GUARDED_BY(mutex_);  ///< Most recent first.
  int64_t bytes_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace cohort
