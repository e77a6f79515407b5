#include "common/store/managed_blob_store.h"

#include <limits>

#include "common/base/status_macros.h"
#include "common/store/blob_damage.h"

namespace cohort {
absl::Status ManagedBlobStore::Remove(const Digest& digest) {
  return RemoveIfOlder(digest, -std::numeric_limits<double>::infinity()).status();
}

absl::StatusOr<bool> ManagedBlobStore::QuarantineIfUnreadable(const Digest& digest) {
  const absl::Status read = VerifyBlob(*this, digest);
  if (absl::IsNotFound(read)) {
    return true;
  }
  if (!absl::IsDataLoss(read)) {
    COHORT_RETURN_IF_ERROR(read);
    return false;
  }
  COHORT_RETURN_IF_ERROR(Quarantine(digest));
  return true;
}

}  // namespace cohort
