#pragma once

#include <cstdint>
#include <stop_token>

#include <absl/status/statusor.h>

#include "common/store/managed_blob_store.h"
#include "server/catalog/catalog.h"

namespace cohort {

struct GarbageOptions {
  /// Younger blobs stay. Must be longer than it takes from writing a blob to naming it in the
  /// catalog: a worker's last output to the end of its task, an upload to the end of `cohort add`.
  double age_seconds = 24 * 3600;
  /// What tasks have found out is remembered for this long for jobs to come, also when no job that
  /// used it is left; then its blobs are garbage.
  double remember_seconds = 90.0 * 24 * 3600;

  /// @return kInvalidArgument naming the option.
  [[nodiscard]] absl::Status Validate() const;
};

struct GarbageCount {
  int64_t blobs = 0;  ///< Removed.
  int64_t bytes = 0;
  int64_t kept_blobs = 0;
  int64_t kept_bytes = 0;
};

/// Removes the blobs that no row of the catalog names and that are old enough, and unfinished
/// uploads of that age. Others may work meanwhile.
///
/// What stays: every blob that any set, job, task or remembered result names - so all that a
/// running job has done and reads - and every young one. What a worker has written and not
/// reported is kept by its age only: if `age_seconds` is too short, its report is refused
/// (BLOB_MISSING) and the task done again.
/// @return kCancelled after `stop`; as Catalog::VisitBlobs and ManagedBlobStore.
[[nodiscard]] absl::StatusOr<GarbageCount> CollectGarbage(Catalog& catalog,
                                                          ManagedBlobStore& store,
                                                          double age_seconds,
                                                          const std::stop_token& stop = {});

}  // namespace cohort
