#include "common/store/caching_blob_store.h"

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <spdlog/spdlog.h>

#include "common/base/status_macros.h"
#include "common/store/blob_damage.h"

namespace cohort {
namespace {

constexpr int64_t kPieceBytes = 1 << 20;
/// The folder is looked at again after this part of the limit has been added by us.
constexpr int64_t kLookParts = 16;
/// Room is made down to this share of the limit, so that it is not made for every blob.
constexpr double kKeptShare = 0.9;
constexpr double kDeadWriterSeconds = 24 * 3600;

}  // namespace

CachingBlobStore::CachingBlobStore(std::unique_ptr<BlobStore> source,
                                   std::unique_ptr<DirectoryBlobStore> kept,
                                   int64_t max_bytes)
    : source_(std::move(source)), kept_(std::move(kept)), max_bytes_(max_bytes) {}

absl::StatusOr<std::unique_ptr<CachingBlobStore>> CachingBlobStore::Create(
    std::unique_ptr<BlobStore> source, const std::filesystem::path& folder, int64_t max_bytes) {
  COHORT_ASSIGN_OR_RETURN(std::unique_ptr<DirectoryBlobStore> kept,
                          DirectoryBlobStore::Create(folder, Durability::kFast));
  COHORT_RETURN_IF_ERROR(kept->SweepIncoming(kDeadWriterSeconds));
  std::unique_ptr<CachingBlobStore> store(
      new CachingBlobStore(std::move(source), std::move(kept), max_bytes));
  COHORT_ASSIGN_OR_RETURN(const int64_t bytes, store->MakeRoom());
  const MutexLock lock(store->mutex_);
  store->bytes_ = bytes;
  return store;
}

absl::StatusOr<std::unique_ptr<BlobWriter>> CachingBlobStore::StartPut() {
  return source_->StartPut();
}

absl::StatusOr<bool> CachingBlobStore::Contains(const Digest& digest) {
  return source_->Contains(digest);
}

absl::StatusOr<std::unique_ptr<BlobReader>> CachingBlobStore::Open(const Digest& digest) {
  if (std::unique_ptr<BlobReader> reader = OpenKept(digest); reader != nullptr) {
    ++hits_;
    return reader;
  }
  COHORT_ASSIGN_OR_RETURN(std::unique_ptr<BlobReader> reader, source_->Open(digest));
  if (reader->SizeBytes() > max_bytes_) {
    return reader;
  }
  COHORT_RETURN_IF_ERROR(Keep(*reader));
  if (std::unique_ptr<BlobReader> kept = OpenKept(digest); kept != nullptr) {
    return kept;
  }
  return source_->Open(digest);  // The folder does not take it, or another process needed the room.
}

std::unique_ptr<BlobReader> CachingBlobStore::OpenKept(const Digest& digest) {
  const absl::StatusOr<bool> there = kept_->Renew(digest);
  if (!there.ok() || !*there) {
    return nullptr;
  }
  // Read once before it is given out: the caller of a reader that finds damage at the end could not
  // start again. The second read comes from memory.
  if (const absl::Status read = VerifyBlob(*kept_, digest); !read.ok()) {
    spdlog::warn("event=cached_blob_dropped error=\"{}\"", std::string(read.message()));
    const absl::Status removed = kept_->Remove(digest);
    if (!removed.ok()) {  // The next Put replaces it; until then the source is asked.
      spdlog::warn("event=cached_blob_stands error=\"{}\"", std::string(removed.message()));
    }
    return nullptr;
  }
  absl::StatusOr<std::unique_ptr<BlobReader>> reader = kept_->Open(digest);
  return reader.ok() ? *std::move(reader) : nullptr;
}

absl::Status CachingBlobStore::Keep(BlobReader& reader) {
  absl::StatusOr<std::unique_ptr<BlobWriter>> writer = kept_->StartPut();
  absl::Status written = writer.status();
  while (written.ok()) {
    COHORT_ASSIGN_OR_RETURN(const std::string piece, reader.Read(kPieceBytes));
    if (piece.empty()) {
      written = (*writer)->Commit().status();
      break;
    }
    written = (*writer)->Append(piece);
  }
  if (written.ok()) {
    NoteKept(reader.SizeBytes());
  } else {
    spdlog::warn("event=blob_not_cached error=\"{}\"", std::string(written.message()));
  }
  return absl::OkStatus();
}

void CachingBlobStore::NoteKept(int64_t size_bytes) {
  {
    const MutexLock lock(mutex_);
    bytes_ += size_bytes;
    new_bytes_ += size_bytes;
    const bool is_fine = bytes_ <= max_bytes_ && new_bytes_ <= max_bytes_ / kLookParts;
    if (is_fine || is_making_room_) {
      return;
    }
    is_making_room_ = true;
    new_bytes_ = 0;
  }
  const absl::StatusOr<int64_t> left = MakeRoom();
  if (!left.ok()) {
    spdlog::warn("event=cache_not_trimmed error=\"{}\"", std::string(left.status().message()));
  }
  const MutexLock lock(mutex_);
  is_making_room_ = false;
  if (left.ok()) {
    bytes_ = *left + new_bytes_;
  }
}

absl::StatusOr<int64_t> CachingBlobStore::MakeRoom() {
  std::vector<StoredBlob> blobs;
  int64_t bytes = 0;
  COHORT_RETURN_IF_ERROR(kept_->Visit([&](const StoredBlob& blob) {
    bytes += blob.size_bytes;
    blobs.push_back(blob);
    return absl::OkStatus();
  }));
  if (bytes <= max_bytes_) {
    return bytes;
  }
  std::sort(blobs.begin(), blobs.end(),
            [](const StoredBlob& a, const StoredBlob& b) { return a.age_seconds > b.age_seconds; });
  const auto kept_bytes = static_cast<int64_t>(kKeptShare * static_cast<double>(max_bytes_));
  for (const StoredBlob& blob : blobs) {
    if (bytes <= kept_bytes) {
      break;
    }
    COHORT_RETURN_IF_ERROR(kept_->Remove(blob.digest));
    bytes -= blob.size_bytes;
  }
  return bytes;
}

}  // namespace cohort
