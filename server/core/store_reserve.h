#pragma once

#include <cstdint>

#include <absl/status/status.h>

#include "common/store/managed_blob_store.h"

namespace cohort {

/// Free space that the store must have for new work: what is being written when the limit is
/// reached must still fit.
struct StoreReserve {
  int64_t bytes = int64_t{1} << 30;
  double share = 0.05;  ///< Of the whole disk; the larger of the two counts.

  /// @return kInvalidArgument naming the field.
  [[nodiscard]] absl::Status Validate() const;
  /// What may be written before the reserve is reached; never negative.
  [[nodiscard]] int64_t Available(const StoreSpace& space) const;
  /// @return kResourceExhausted (STORE_FULL) naming the numbers if there is less.
  [[nodiscard]] absl::Status Check(const StoreSpace& space) const;

 private:
  [[nodiscard]] double Wanted(const StoreSpace& space) const;
};

}  // namespace cohort
