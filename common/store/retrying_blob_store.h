#pragma once

#include <functional>
#include <memory>
#include <stop_token>

#include <absl/status/statusor.h>

#include "common/store/blob_store.h"

namespace cohort {

/// How long to go on with what may succeed later.
struct Patience {
  double first_pause_seconds = 0.1;  ///< Doubles after every try,
  double longest_pause_seconds = 5;  ///< up to this.
  double total_seconds = 600;
};

/// Another store whose calls are made again while it cannot be reached: a server that is started
/// again costs its workers a wait, not their work. Whole blobs pass through memory. Thread-safe.
class RetryingBlobStore final : public BlobStore {
 public:
  /// @param stop  ends all waiting: the last error is returned then.
  RetryingBlobStore(std::unique_ptr<BlobStore> source,
                    const Patience& patience,
                    std::stop_token stop);

  [[nodiscard]] absl::StatusOr<std::unique_ptr<BlobWriter>> StartPut() override;
  /// Reads and checks the whole blob.
  [[nodiscard]] absl::StatusOr<std::unique_ptr<BlobReader>> Open(const Digest& digest) override;
  [[nodiscard]] absl::StatusOr<bool> Contains(const Digest& digest) override;
  [[nodiscard]] absl::StatusOr<std::vector<Digest>> PutAll(
      std::span<const std::string_view> blobs) override;

 private:
  friend class RetryingBlobWriter;
  /// Calls until it is OK or cannot become so, or until patience ends.
  absl::Status Insist(const std::function<absl::Status()>& call) const;

  const std::unique_ptr<BlobStore> source_;
  const Patience patience_;
  const std::stop_token stop_;
};

}  // namespace cohort
