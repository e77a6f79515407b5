#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <unordered_map>

#include <absl/status/statusor.h>

#include "common/base/mutex.h"
#include "common/base/sha256.h"
#include "common/geometry/mesh/triangle_mesh.h"
#include "common/store/blob_store.h"

namespace cohort {

/// Decoded meshes shared by the slots of a worker; the least recently used go first when the limit
/// is reached. Thread-safe.
class MeshCache {
 public:
  /// @param max_bytes  of decoded meshes kept; meshes in use may exceed it.
  MeshCache(BlobStore& store, int64_t max_bytes) : store_(store), max_bytes_(max_bytes) {}

  /// @return as BlobStore::Get and DecodeMeshBlob, naming the blob.
  [[nodiscard]] absl::StatusOr<std::shared_ptr<const TriangleMesh>> Get(const Digest& blob);

 private:
  struct Entry {
    std::shared_ptr<const TriangleMesh> mesh;
    std::list<Digest>::iterator use;
  };
  void Insert(const Digest& blob, std::shared_ptr<const TriangleMesh> mesh)
      ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  BlobStore& store_;
  const int64_t max_bytes_;
  Mutex mutex_;
  std::unordered_map<Digest, Entry> entries_ ABSL_GUARDED_BY(mutex_);
  std::list<Digest> uses_ ABSL_GUARDED_BY(mutex_);  ///< Most recent first.
  int64_t bytes_ ABSL_GUARDED_BY(mutex_) = 0;
};

}  // namespace cohort
