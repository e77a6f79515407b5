#include "common/store/blob_store.h"

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

absl::StatusOr<std::string> BlobStore::Get(const Digest& digest) {
  COHORT_ASSIGN_OR_RETURN(const std::unique_ptr<BlobReader> reader, Open(digest));
  std::string bytes;
  bytes.reserve(static_cast<size_t>(reader->SizeBytes()));
  while (true) {
    COHORT_ASSIGN_OR_RETURN(const std::string piece, reader->Read(kPieceBytes));
    if (piece.empty()) {
      return bytes;
    }
    bytes += piece;
  }
}

}  // namespace cohort
