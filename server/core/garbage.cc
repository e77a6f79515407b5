#include "server/core/garbage.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <vector>

#include <absl/strings/str_cat.h>

#include "common/base/status_macros.h"

namespace cohort {
namespace {

/// The first 64 bits of a digest: eight bytes for each of millions of blobs in use. Two that are
/// alike cost a piece of garbage, not a blob.
uint64_t Mark(const Digest& digest) {
  uint64_t mark = 0;
  const char* begin = digest.Hex().data();
  std::from_chars(begin, begin + 16, mark, 16);
  return mark;
}

absl::StatusOr<std::vector<uint64_t>> MarksInUse(Catalog& catalog) {
  std::vector<uint64_t> marks;
  const auto compact = [&marks] {
    std::sort(marks.begin(), marks.end());
    marks.erase(std::unique(marks.begin(), marks.end()), marks.end());
  };
  size_t compact_at = 1 << 20;  // A blob may be told many times.
  COHORT_RETURN_IF_ERROR(catalog.VisitBlobs([&](const Digest& digest) {
    marks.push_back(Mark(digest));
    if (marks.size() >= compact_at) {
      compact();
      compact_at = std::max(compact_at, 2 * marks.size());
    }
    return absl::OkStatus();
  }));
  compact();
  return marks;
}

}  // namespace

absl::Status GarbageOptions::Validate() const {
  if (!(age_seconds >= 0) || !std::isfinite(age_seconds)) {
    return absl::InvalidArgumentError(
        absl::StrCat("garbage collection: an age of ", age_seconds, " s is no age"));
  }
  if (!(remember_seconds >= 0)) {
    return absl::InvalidArgumentError(absl::StrCat("garbage collection: to remember results for ",
                                                   remember_seconds, " s is no time"));
  }
  return absl::OkStatus();
}

absl::StatusOr<GarbageCount> CollectGarbage(Catalog& catalog,
                                            ManagedBlobStore& store,
                                            double age_seconds,
                                            const std::stop_token& stop) {
  // First what is in use, then what is there: a blob that is written and named in between is young.
  COHORT_ASSIGN_OR_RETURN(const std::vector<uint64_t> in_use, MarksInUse(catalog));
  GarbageCount count;
  COHORT_RETURN_IF_ERROR(store.Visit([&](const StoredBlob& blob) -> absl::Status {
    if (stop.stop_requested()) {
      return absl::CancelledError("the collection of garbage was stopped");
    }
    bool is_removed = false;
    if (!std::binary_search(in_use.begin(), in_use.end(), Mark(blob.digest))) {
      COHORT_ASSIGN_OR_RETURN(is_removed, store.RemoveIfOlder(blob.digest, age_seconds));
    }
    (is_removed ? count.blobs : count.kept_blobs) += 1;
    (is_removed ? count.bytes : count.kept_bytes) += blob.size_bytes;
    return absl::OkStatus();
  }));
  COHORT_RETURN_IF_ERROR(store.SweepIncoming(age_seconds));
  return count;
}

}  // namespace cohort
