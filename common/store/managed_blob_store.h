#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include <absl/status/statusor.h>

#include "common/store/blob_store.h"

namespace cohort {

/// A blob as a listing of the store tells it.
struct StoredBlob {
  Digest digest;
  int64_t size_bytes = 0;
  double age_seconds = 0;  ///< Since it was written, put again, or renewed.
};

/// Of what holds the store.
struct StoreSpace {
  int64_t free_bytes = 0;
  int64_t total_bytes = 0;
};

/// A blob store as the one who owns it sees it: what is in it, how much more fits, what is thrown
/// away, and uploads that go on after a broken connection. Only the server has one; workers and
/// clients see a BlobStore. Thread-safe.
class ManagedBlobStore : public BlobStore {
 public:
  /// Tells every blob, in no order and in bounded memory, while others write and remove: a blob
  /// that comes or goes meanwhile may be told or not.
  /// @param visit  called without any lock held, may remove blobs; its error ends the walk and is
  ///               returned.
  [[nodiscard]] virtual absl::Status Visit(
      const std::function<absl::Status(const StoredBlob&)>& visit) = 0;
  [[nodiscard]] virtual absl::StatusOr<StoreSpace> Space() = 0;

  /// As Contains, and the blob is young again: a collection of garbage leaves it alone for as long
  /// as a new one. For all who are told that they need not send it. (Put does the same.)
  [[nodiscard]] virtual absl::StatusOr<bool> Renew(const Digest& digest) = 0;
  /// Removes the blob if it is at least that old, also if that has just changed: a blob that is put
  /// again at the same moment is there afterwards.
  /// @return whether it was removed.
  [[nodiscard]] virtual absl::StatusOr<bool> RemoveIfOlder(const Digest& digest,
                                                           double age_seconds) = 0;
  /// Removes the blob, whatever its age; one that is not there, too.
  [[nodiscard]] absl::Status Remove(const Digest& digest);

  /// Reads the blob. If it is damaged it is moved aside, kept for people and never served again.
  /// @return true: the blob is not in the store (any more). Other errors of reading are returned
  ///         and leave it where it is.
  [[nodiscard]] absl::StatusOr<bool> QuarantineIfUnreadable(const Digest& digest);

  /// How many bytes of an upload that was cut off are kept.
  [[nodiscard]] virtual absl::StatusOr<int64_t> UploadedBytes(const Digest& digest) = 0;
  /// Goes on with an upload. What is appended stays for the next try if the writer is destroyed
  /// before Commit.
  /// Commit @return also kDataLoss (UPLOAD_DAMAGED) if the bytes do not have that digest; nothing
  /// of
  ///         them is kept then.
  /// @param offset  UploadedBytes.
  /// @return kOutOfRange (WRONG_OFFSET) naming what is kept if that is not `offset`; kAborted
  ///         (UPLOAD_BUSY) while another writer has the upload.
  [[nodiscard]] virtual absl::StatusOr<std::unique_ptr<BlobWriter>> ResumePut(const Digest& digest,
                                                                              int64_t offset) = 0;
  /// Removes what unfinished writers and uploads left that went on last before `age_seconds` ago.
  [[nodiscard]] virtual absl::Status SweepIncoming(double age_seconds) = 0;

 protected:
  /// Moves the bytes of a blob out of the store, to where people find them; none is no error.
  [[nodiscard]] virtual absl::Status Quarantine(const Digest& digest) = 0;
};

}  // namespace cohort
