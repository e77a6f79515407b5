#include "worker/tasks/mesh_cache.h"

#include <utility>

#include "common/base/status_macros.h"
#include "common/store/mesh_blob.h"

namespace cohort {
namespace {

int64_t SizeOf(const TriangleMesh& mesh) {
  return mesh.VertexCount() * int64_t{3 * sizeof(double)} +
         mesh.FaceCount() * int64_t{3 * sizeof(int32_t)};
}

}  // namespace

absl::StatusOr<std::shared_ptr<const TriangleMesh>> MeshCache::Get(const Digest& blob) {
  {
    MutexLock lock(mutex_);
    const auto found = entries_.find(blob);
    if (found != entries_.end()) {
      uses_.splice(uses_.begin(), uses_, found->second.use);
      return found->second.mesh;
    }
  }
  // Two slots may decode the same mesh at once; that costs milliseconds, waiting would cost more.
  COHORT_ASSIGN_OR_RETURN(const std::string bytes, store_.Get(blob));
  absl::StatusOr<TriangleMesh> decoded = DecodeMeshBlob(bytes);
  if (!decoded.ok()) {
    return absl::Status(decoded.status().code(),
                        "blob " + blob.Hex() + ": " + std::string(decoded.status().message()));
  }
  auto mesh = std::make_shared<const TriangleMesh>(*std::move(decoded));
  MutexLock lock(mutex_);
  Insert(blob, mesh);
  return mesh;
}

void MeshCache::Insert(const Digest& blob, std::shared_ptr<const TriangleMesh> mesh) {
  if (entries_.contains(blob)) {
    return;
  }
  bytes_ += SizeOf(*mesh);
  uses_.push_front(blob);
  entries_[blob] = {.mesh = std::move(mesh), .use = uses_.begin()};
  while (bytes_ > max_bytes_ && uses_.size() > 1) {
    const auto oldest = entries_.find(uses_.back());
    bytes_ -= SizeOf(*oldest->second.mesh);
    entries_.erase(oldest);
    uses_.pop_back();
  }
}

}  // namespace cohort
