#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <absl/status/statusor.h>

#include "common/base/sha256.h"

namespace cohort {

/// One blob being written, piece by piece. Destroyed before Commit, it leaves nothing behind.
/// Not thread-safe.
class BlobWriter {
 public:
  virtual ~BlobWriter() = default;
  /// @return kResourceExhausted if the store is full, kUnavailable for other I/O failures.
  [[nodiscard]] virtual absl::Status Append(std::string_view bytes) = 0;
  /// Makes the blob durable and visible under its digest. A blob that is there already is kept.
  /// @return as Append.
  [[nodiscard]] virtual absl::StatusOr<Digest> Commit() = 0;
};

/// One blob being read, piece by piece. Not thread-safe.
class BlobReader {
 public:
  virtual ~BlobReader() = default;
  [[nodiscard]] virtual int64_t SizeBytes() const = 0;
  /// The next piece, at most `max_bytes`; empty at the end.
  /// @return kDataLoss at the end if the bytes read do not have the digest they were asked under.
  [[nodiscard]] virtual absl::StatusOr<std::string> Read(int64_t max_bytes) = 0;
};

/// Bytes named by their SHA-256. What Commit acknowledged survives a crash; what Get returns has
/// the digest asked for. Thread-safe.
class BlobStore {
 public:
  virtual ~BlobStore() = default;

  [[nodiscard]] virtual absl::StatusOr<std::unique_ptr<BlobWriter>> StartPut() = 0;
  /// @return kNotFound naming the digest.
  [[nodiscard]] virtual absl::StatusOr<std::unique_ptr<BlobReader>> Open(const Digest& digest) = 0;
  [[nodiscard]] virtual absl::StatusOr<bool> Contains(const Digest& digest) = 0;

  /// Writes a whole blob. @return as BlobWriter.
  [[nodiscard]] absl::StatusOr<Digest> Put(std::string_view bytes);
  /// Writes whole blobs; where syncing is dear, it is done once for all of them.
  /// @return their digests, in the order of `blobs`; as BlobWriter, and some may be written then.
  [[nodiscard]] virtual absl::StatusOr<std::vector<Digest>> PutAll(
      std::span<const std::string_view> blobs);
  /// Reads a whole blob. @return as Open and BlobReader.
  [[nodiscard]] absl::StatusOr<std::string> Get(const Digest& digest);
};

}  // namespace cohort
