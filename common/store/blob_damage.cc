#include "common/store/blob_damage.h"

#include <memory>
#include <string>

#include <absl/status/statusor.h>
#include <absl/strings/cord.h>

#include "common/base/status_macros.h"

namespace cohort {
namespace {

constexpr int64_t kPieceBytes = 1 << 20;
constexpr char kUnreadableBlobUrl[] = "cohort/unreadable-blob";

}  // namespace

absl::Status WithUnreadableBlob(absl::Status status, const Digest& digest) {
  const bool is_about_the_blob = absl::IsNotFound(status) || absl::IsDataLoss(status);
  if (is_about_the_blob && !digest.empty()) {
    status.SetPayload(kUnreadableBlobUrl, absl::Cord(digest.Hex()));
  }
  return status;
}

std::optional<Digest> UnreadableBlob(const absl::Status& status) {
  const auto payload = status.GetPayload(kUnreadableBlobUrl);
  if (!payload) {
    return std::nullopt;
  }
  const absl::StatusOr<Digest> digest = Digest::FromHex(std::string(*payload));
  return digest.ok() ? std::optional<Digest>(*digest) : std::nullopt;
}

absl::Status VerifyBlob(BlobStore& store, const Digest& digest) {
  COHORT_ASSIGN_OR_RETURN(const std::unique_ptr<BlobReader> reader, store.Open(digest));
  while (true) {
    COHORT_ASSIGN_OR_RETURN(const std::string piece, reader->Read(kPieceBytes));
    if (piece.empty()) {
      return absl::OkStatus();
    }
  }
}

}  // namespace cohort
