#include "common/store/retrying_blob_store.h"

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include "common/base/mutex.h"
#include "common/base/status_macros.h"
#include "common/store/whole_blob_reader.h"

namespace cohort {
namespace {

using std::chrono::steady_clock;

bool IsTransient(const absl::Status& status) {
  return status.code() == absl::StatusCode::kUnavailable ||
         status.code() == absl::StatusCode::kDeadlineExceeded;
}

steady_clock::duration Seconds(double seconds) {
  return std::chrono::duration_cast<steady_clock::duration>(std::chrono::duration<double>(seconds));
}

/// Sleeps, at most until `stop`.
void Pause(double seconds, const std::stop_token& stop) {
  Mutex mutex;
  CondVar stopped;
  const std::stop_callback wake(stop, [&] {
    const MutexLock lock(mutex);
    stopped.NotifyAll();
  });
  const auto deadline = steady_clock::now() + Seconds(seconds);
  const MutexLock lock(mutex);
  while (!stop.stop_requested() && stopped.WaitUntil(mutex, deadline)) {
  }
}

}  // namespace

/// Gathers the blob, so that it can be written again.
class RetryingBlobWriter final : public BlobWriter {
 public:
  explicit RetryingBlobWriter(RetryingBlobStore& store) : store_(store) {}
  [[nodiscard]] absl::Status Append(std::string_view bytes) override {
    bytes_ += bytes;
    return absl::OkStatus();
  }
  [[nodiscard]] absl::StatusOr<Digest> Commit() override {
    Digest digest;
    COHORT_RETURN_IF_ERROR(store_.Insist([&]() -> absl::Status {
      COHORT_ASSIGN_OR_RETURN(digest, store_.source_->Put(bytes_));
      return absl::OkStatus();
    }));
    return digest;
  }

 private:
  RetryingBlobStore& store_;
  std::string bytes_;
};

RetryingBlobStore::RetryingBlobStore(std::unique_ptr<BlobStore> source,
                                     const Patience& patience,
                                     std::stop_token stop)
    : source_(std::move(source)), patience_(patience), stop_(std::move(stop)) {}

absl::StatusOr<std::unique_ptr<BlobWriter>> RetryingBlobStore::StartPut() {
  return std::make_unique<RetryingBlobWriter>(*this);
}

absl::StatusOr<std::unique_ptr<BlobReader>> RetryingBlobStore::Open(const Digest& digest) {
  std::string bytes;
  COHORT_RETURN_IF_ERROR(Insist([&]() -> absl::Status {
    COHORT_ASSIGN_OR_RETURN(bytes, source_->Get(digest));
    return absl::OkStatus();
  }));
  return std::make_unique<WholeBlobReader>(std::move(bytes));
}

absl::StatusOr<bool> RetryingBlobStore::Contains(const Digest& digest) {
  bool exists = false;
  COHORT_RETURN_IF_ERROR(Insist([&]() -> absl::Status {
    COHORT_ASSIGN_OR_RETURN(exists, source_->Contains(digest));
    return absl::OkStatus();
  }));
  return exists;
}

absl::StatusOr<std::vector<Digest>> RetryingBlobStore::PutAll(
    std::span<const std::string_view> blobs) {
  std::vector<Digest> digests;
  COHORT_RETURN_IF_ERROR(Insist([&]() -> absl::Status {
    COHORT_ASSIGN_OR_RETURN(digests, source_->PutAll(blobs));
    return absl::OkStatus();
  }));
  return digests;
}

absl::Status RetryingBlobStore::Insist(const std::function<absl::Status()>& call) const {
  const auto give_up = steady_clock::now() + Seconds(patience_.total_seconds);
  double pause_seconds = patience_.first_pause_seconds;
  while (true) {
    absl::Status status = call();
    if (status.ok() || !IsTransient(status) || stop_.stop_requested() ||
        steady_clock::now() + Seconds(pause_seconds) > give_up) {
      return status;
    }
    Pause(pause_seconds, stop_);
    pause_seconds = std::min(2 * pause_seconds, patience_.longest_pause_seconds);
  }
}

}  // namespace cohort
