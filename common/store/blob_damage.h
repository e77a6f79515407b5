#pragma once

#include <optional>

#include <absl/status/status.h>

#include "common/base/sha256.h"
#include "common/store/blob_store.h"

namespace cohort {

/// Marks an error of reading a blob with the blob's name, so that whoever can mend the blob (the
/// server, by making it again) need not guess it from the message. Only kNotFound and kDataLoss
/// are marked: other errors say nothing about the blob.
[[nodiscard]] absl::Status WithUnreadableBlob(absl::Status status, const Digest& digest);

/// The blob that could not be read because it is missing or damaged.
[[nodiscard]] std::optional<Digest> UnreadableBlob(const absl::Status& status);

/// Reads all of a blob. @return as BlobStore::Get: OK only if it is there and has its digest.
[[nodiscard]] absl::Status VerifyBlob(BlobStore& store, const Digest& digest);

}  // namespace cohort
