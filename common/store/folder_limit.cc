#include "common/store/folder_limit.h"

#include <algorithm>
#include <string>
#include <vector>

#include <spdlog/spdlog.h>

#include "common/base/status_macros.h"

namespace cohort {
namespace {

/// The store is looked at again after this part of the limit has been added by us.
constexpr int64_t kLookParts = 16;
/// Room is made down to this share of the limit, so that it is not made for every blob.
constexpr double kKeptShare = 0.9;

}  // namespace

absl::Status FolderLimit::Start() {
  COHORT_ASSIGN_OR_RETURN(const int64_t bytes, MakeRoom());
  const MutexLock lock(mutex_);
  bytes_ = bytes;
  return absl::OkStatus();
}

void FolderLimit::NoteAdded(int64_t size_bytes) {
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

absl::StatusOr<int64_t> FolderLimit::MakeRoom() {
  std::vector<StoredBlob> blobs;
  int64_t bytes = 0;
  COHORT_RETURN_IF_ERROR(kept_.Visit([&](const StoredBlob& blob) {
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
    COHORT_RETURN_IF_ERROR(kept_.Remove(blob.digest));
    bytes -= blob.size_bytes;
  }
  return bytes;
}

}  // namespace cohort
