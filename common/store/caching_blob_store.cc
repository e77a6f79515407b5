#include "common/store/caching_blob_store.h"

#include <string>
#include <utility>

#include <spdlog/spdlog.h>

#include "common/base/status_macros.h"
#include "common/store/blob_damage.h"

namespace cohort {
namespace {

constexpr int64_t kPieceBytes = 1 << 20;
constexpr double kDeadWriterSeconds = 24 * 3600;

}  // namespace

CachingBlobStore::CachingBlobStore(std::unique_ptr<BlobStore> source,
                                   std::unique_ptr<DirectoryBlobStore> kept,
                                   int64_t max_bytes)
    : source_(std::move(source)), kept_(std::move(kept)), limit_(*kept_, max_bytes) {}

absl::StatusOr<std::unique_ptr<CachingBlobStore>> CachingBlobStore::Create(
    std::unique_ptr<BlobStore> source, const std::filesystem::path& folder, int64_t max_bytes) {
  COHORT_ASSIGN_OR_RETURN(std::unique_ptr<DirectoryBlobStore> kept,
                          DirectoryBlobStore::Create(folder, Durability::kFast));
  COHORT_RETURN_IF_ERROR(kept->SweepIncoming(kDeadWriterSeconds));
  std::unique_ptr<CachingBlobStore> store(
      new CachingBlobStore(std::move(source), std::move(kept), max_bytes));
  COHORT_RETURN_IF_ERROR(store->limit_.Start());
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
  if (reader->SizeBytes() > limit_.MaxBytes()) {
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
    limit_.NoteAdded(reader.SizeBytes());
  } else {
    spdlog::warn("event=blob_not_cached error=\"{}\"", std::string(written.message()));
  }
  return absl::OkStatus();
}

}  // namespace cohort
