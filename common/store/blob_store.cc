#include "common/store/blob_store.h"

#include <iterator>

#include "common/base/status_macros.h"

namespace cohort {
namespace {

constexpr int64_t kPieceBytes = 1 << 20;

}  // namespace

absl::StatusOr<Digest> BlobStore::Put(std::string_view bytes) {
  COHORT_ASSIGN_OR_RETURN(const std::unique_ptr<BlobWriter> writer, StartPut());
  COHORT_RETURN_IF_ERROR(writer->Append(bytes));
  return writer->Commit();
}

absl::StatusOr<std::vector<Digest>> BlobStore::PutAll(std::span<const std::string_view> blobs) {
  std::vector<Digest> digests;
  for (const std::string_view blob : blobs) {
    COHORT_ASSIGN_OR_RETURN(digests.emplace_back(), Put(blob));
  }
  return digests;
}

absl::StatusOr<std::string> BlobStore::Get(const Digest& digest) {
  COHORT_ASSIGN_OR_RETURN(const std::unique_ptr<BlobReader> reader, Open(digest));
  std::string bytes;
  bytes.reserve(reader->SizeBytes() > kPieceBytes ? static_cast<size_t>(reader->SizeBytes()) : 0);
  while (true) {
    COHORT_ASSIGN_OR_RETURN(std::string piece, reader->Read(kPieceBytes));
    if (piece.empty()) {
      return bytes;
    }
    if (std::ssize(piece) == reader->SizeBytes()) {
      return piece;  // Whole, and checked: spares a copy.
    }
    bytes += piece;
  }
}

}  // namespace cohort
