#pragma once

#include <cstdint>

#include <absl/status/statusor.h>

#include "common/base/mutex.h"
#include "common/store/managed_blob_store.h"

namespace cohort {

/// Keeps what a store holds under a number of bytes: the least recently used (renewed) blobs go.
///
/// Several processes may share the store: each looks at all of it now and then, so that together
/// they exceed the limit by at most a sixteenth for each of them. Thread-safe.
class FolderLimit {
 public:
  /// @param kept  outlives this.
  FolderLimit(ManagedBlobStore& kept, int64_t max_bytes) : kept_(kept), max_bytes_(max_bytes) {}

  /// To be called once before all else: looks at what is there, makes room.
  [[nodiscard]] absl::Status Start() ABSL_LOCKS_EXCLUDED(mutex_);
  /// So much has been added by us; makes room if it may be too much. Errors are logged.
  void NoteAdded(int64_t size_bytes) ABSL_LOCKS_EXCLUDED(mutex_);
  [[nodiscard]] int64_t MaxBytes() const { return max_bytes_; }

 private:
  /// Removes the least recently used blobs until there is room. @return the bytes that are left.
  [[nodiscard]] absl::StatusOr<int64_t> MakeRoom() ABSL_LOCKS_EXCLUDED(mutex_);

  ManagedBlobStore& kept_;
  const int64_t max_bytes_;
  Mutex mutex_;
  int64_t bytes_ ABSL_GUARDED_BY(mutex_) = 0;  ///< In the store, as last seen, and ours since.
  bool is_making_room_ ABSL_GUARDED_BY(mutex_) = false;
  int64_t new_bytes_ ABSL_GUARDED_BY(mutex_) = 0;  ///< Ours since it was last seen.
};

}  // namespace cohort
