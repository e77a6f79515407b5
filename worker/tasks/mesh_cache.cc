#include "worker/tasks/mesh_cache.h"

#include <cstddef>
#include <utility>
#include <vector>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"
#include "common/geometry/mesh/boundary.h"
#include "common/pairs/pair_mesh.h"
#include "common/store/mesh_blob.h"

namespace cohort {
namespace {

int64_t SizeOf(const TriangleMesh& mesh) {
  return mesh.VertexCount() * int64_t{3 * sizeof(double)} +
         mesh.FaceCount() * int64_t{3 * sizeof(int32_t)};
}

std::string MeshKey(const Digest& blob) {
  return "mesh " + blob.Hex();
}

/// The bytes of a similarity and a point: what they place is the same if these are.
std::string PlaceKey(const Similarity& T, const Eigen::Vector3d& center) {
  Eigen::Matrix<double, 16, 1> numbers;
  numbers << T.scale, T.rotation.reshaped(), T.translation, center;
  return {reinterpret_cast<const char*>(numbers.data()), sizeof(double) * 16};
}

absl::Status CheckHasFaces(const TriangleMesh& mesh, const Digest& blob) {
  if (mesh.IsPointCloud()) {
    return absl::FailedPreconditionError("mesh " + blob.Hex() +
                                         " is a point cloud: a surface is needed");
  }
  return absl::OkStatus();
}

}  // namespace

template <typename T, typename Make>
absl::StatusOr<std::shared_ptr<const T>> MeshCache::GetOrMake(const std::string& key, Make make) {
  if (std::shared_ptr<const void> found = Find(key); found != nullptr) {
    return std::static_pointer_cast<const T>(std::move(found));
  }
  // Two slots may make the same value at once; that costs milliseconds, waiting would cost more.
  absl::StatusOr<Made<T>> made = make();
  COHORT_RETURN_IF_ERROR(made.status());
  Insert(key, made->value, made->bytes);
  return std::move(made->value);
}

absl::StatusOr<TriangleMesh> MeshCache::Decode(const Digest& blob) {
  COHORT_ASSIGN_OR_RETURN(const std::string bytes, store_.Get(blob));
  absl::StatusOr<TriangleMesh> mesh = DecodeMeshBlob(bytes);
  if (!mesh.ok()) {
    return absl::Status(mesh.status().code(),
                        "blob " + blob.Hex() + ": " + std::string(mesh.status().message()));
  }
  return mesh;
}

absl::StatusOr<std::shared_ptr<const TriangleMesh>> MeshCache::Get(const Digest& blob) {
  return GetOrMake<TriangleMesh>(MeshKey(blob), [&]() -> absl::StatusOr<Made<TriangleMesh>> {
    COHORT_ASSIGN_OR_RETURN(TriangleMesh decoded, Decode(blob));
    auto mesh = std::make_shared<const TriangleMesh>(std::move(decoded));
    return Made<TriangleMesh>{.value = mesh, .bytes = SizeOf(*mesh)};
  });
}

void MeshCache::Keep(const Digest& blob, TriangleMesh mesh) {
  auto kept = std::make_shared<const TriangleMesh>(std::move(mesh));
  Insert(MeshKey(blob), kept, SizeOf(*kept));
}

absl::StatusOr<std::shared_ptr<const PoseShape>> MeshCache::GetPoseShape(const Digest& blob) {
  return GetOrMake<PoseShape>("pose " + blob.Hex(), [&]() -> absl::StatusOr<Made<PoseShape>> {
    COHORT_ASSIGN_OR_RETURN(const auto mesh, Get(blob));
    COHORT_ASSIGN_OR_RETURN(PoseShape made, PoseShape::Create(*mesh));
    auto shape = std::make_shared<const PoseShape>(std::move(made));
    return Made<PoseShape>{.value = shape, .bytes = shape->ByteCount()};
  });
}

absl::StatusOr<std::shared_ptr<const LandmarkTable>> MeshCache::GetLandmarks(const Digest& blob) {
  return GetOrMake<LandmarkTable>(
      "landmarks " + blob.Hex(), [&]() -> absl::StatusOr<Made<LandmarkTable>> {
        COHORT_ASSIGN_OR_RETURN(const std::string bytes, store_.Get(blob));
        COHORT_ASSIGN_OR_RETURN(LandmarkTable decoded, DecodeLandmarkBlob(bytes));
        auto table = std::make_shared<const LandmarkTable>(std::move(decoded));
        return Made<LandmarkTable>{.value = table, .bytes = SizeOf(*table)};
      });
}

absl::StatusOr<std::shared_ptr<const IcpMesh>> MeshCache::GetIcpMesh(const Digest& blob) {
  return GetOrMake<IcpMesh>("icp " + blob.Hex(), [&]() -> absl::StatusOr<Made<IcpMesh>> {
    COHORT_ASSIGN_OR_RETURN(const auto mesh, Get(blob));
    auto packed = std::make_shared<const IcpMesh>(mesh->vertices, BoundaryVertices(*mesh));
    return Made<IcpMesh>{.value = packed,
                         .bytes = packed->Packed().ByteCount() + mesh->VertexCount()};
  });
}

absl::StatusOr<std::shared_ptr<const IcpMesh>> MeshCache::GetIcpTarget(
    const Digest& blob, Correspondence correspondence) {
  if (correspondence == Correspondence::kVertex) {
    return GetIcpMesh(blob);
  }
  return GetOrMake<IcpMesh>("icp surface " + blob.Hex(), [&]() -> absl::StatusOr<Made<IcpMesh>> {
    COHORT_ASSIGN_OR_RETURN(const auto mesh, Get(blob));
    COHORT_RETURN_IF_ERROR(CheckHasFaces(*mesh, blob));
    auto packed =
        std::make_shared<const IcpMesh>(IcpMesh::WithSurface(*mesh, BoundaryVertices(*mesh)));
    return Made<IcpMesh>{.value = packed,
                         .bytes = packed->Packed().ByteCount() + mesh->VertexCount() +
                                  packed->Surface()->ByteCount()};
  });
}

absl::StatusOr<std::shared_ptr<const IcpMesh>> MeshCache::GetSampled(
    const Digest& blob, const UndersamplingOptions& undersampling) {
  if (undersampling.method == UndersamplingMethod::kNone) {
    return GetIcpMesh(blob);
  }
  const std::string key = absl::StrCat(
      "sampled ", blob.Hex(), " ", static_cast<int>(undersampling.method), " ", undersampling.count,
      " ", undersampling.share, " ", undersampling.radius, " ", undersampling.seed);
  return GetOrMake<IcpMesh>(key, [&]() -> absl::StatusOr<Made<IcpMesh>> {
    COHORT_ASSIGN_OR_RETURN(const auto mesh, Get(blob));
    COHORT_ASSIGN_OR_RETURN(const std::vector<int32_t> kept, SelectVertices(*mesh, undersampling));
    const Eigen::Matrix3Xd vertices = mesh->vertices(Eigen::all, kept);
    auto sampled = std::make_shared<const IcpMesh>(vertices);
    return Made<IcpMesh>{.value = sampled, .bytes = sampled->Packed().ByteCount()};
  });
}

absl::StatusOr<std::shared_ptr<const PackedMesh>> MeshCache::GetPlaced(
    const Digest& blob, const Similarity& T_frame_mesh, const Eigen::Vector3d& frame_center) {
  const std::string key = "placed " + blob.Hex() + PlaceKey(T_frame_mesh, frame_center);
  return GetOrMake<PackedMesh>(key, [&]() -> absl::StatusOr<Made<PackedMesh>> {
    std::shared_ptr<const PackedMesh> packed = shared_ == nullptr ? nullptr : shared_->Get(key);
    if (packed == nullptr) {
      COHORT_ASSIGN_OR_RETURN(const auto mesh, Get(blob));
      packed = std::make_shared<const PackedMesh>(PlaceVertices(*mesh, T_frame_mesh, frame_center));
      if (shared_ != nullptr) {
        shared_->Keep(key, *packed);
      }
    }
    return Made<PackedMesh>{.value = packed, .bytes = packed->ByteCount()};
  });
}

absl::Status MeshCache::SharePlaced(const Digest& blob,
                                    const Similarity& T_frame_mesh,
                                    const Eigen::Vector3d& frame_center) {
  return shared_ == nullptr ? absl::OkStatus()
                            : GetPlaced(blob, T_frame_mesh, frame_center).status();
}

absl::StatusOr<std::shared_ptr<const PackedSurface>> MeshCache::GetPlacedSurface(
    const Digest& blob, const Similarity& T_frame_mesh, const Eigen::Vector3d& frame_center) {
  const std::string key = "placed surface " + blob.Hex() + PlaceKey(T_frame_mesh, frame_center);
  return GetOrMake<PackedSurface>(key, [&]() -> absl::StatusOr<Made<PackedSurface>> {
    COHORT_ASSIGN_OR_RETURN(const auto mesh, Get(blob));
    COHORT_RETURN_IF_ERROR(CheckHasFaces(*mesh, blob));
    auto packed = std::make_shared<const PackedSurface>(
        PlaceVertices(*mesh, T_frame_mesh, frame_center), mesh->faces);
    return Made<PackedSurface>{.value = packed, .bytes = packed->ByteCount()};
  });
}

std::shared_ptr<const void> MeshCache::Find(const std::string& key) {
  MutexLock lock(mutex_);
  const auto found = entries_.find(key);
  if (found == entries_.end()) {
    return nullptr;
  }
  uses_.splice(uses_.begin(), uses_, found->second.use);
  return found->second.value;
}

void MeshCache::Insert(const std::string& key, std::shared_ptr<const void> value, int64_t bytes) {
  MutexLock lock(mutex_);
  if (entries_.contains(key)) {
    return;
  }
  bytes_ += bytes;
  uses_.push_front(key);
  entries_[key] = {.value = std::move(value), .bytes = bytes, .use = uses_.begin()};
  while (bytes_ > max_bytes_ && uses_.size() > 1) {
    const auto oldest = entries_.find(uses_.back());
    bytes_ -= oldest->second.bytes;
    entries_.erase(oldest);
    uses_.pop_back();
  }
}

}  // namespace cohort
