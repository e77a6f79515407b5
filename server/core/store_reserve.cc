#include "server/core/store_reserve.h"

#include <algorithm>

#include <absl/strings/str_format.h>

#include "common/base/error_reason.h"

namespace cohort {
namespace {

constexpr double kGigabyte = 1e9;

}  // namespace

absl::Status StoreReserve::Validate() const {
  if (bytes < 0) {
    return absl::InvalidArgumentError("free space reserve: must not be negative");
  }
  if (!(share >= 0 && share < 1)) {
    return absl::InvalidArgumentError("free space reserve: the share must be at least 0 and < 1");
  }
  return absl::OkStatus();
}

double StoreReserve::Wanted(const StoreSpace& space) const {
  return std::max(static_cast<double>(bytes), share * static_cast<double>(space.total_bytes));
}

int64_t StoreReserve::Available(const StoreSpace& space) const {
  return std::max<int64_t>(0, space.free_bytes - static_cast<int64_t>(Wanted(space)));
}

absl::Status StoreReserve::Check(const StoreSpace& space) const {
  const double wanted = Wanted(space);
  const auto free = static_cast<double>(space.free_bytes);
  if (free >= wanted) {
    return absl::OkStatus();
  }
  return WithReason(
      absl::ResourceExhaustedError(absl::StrFormat(
          "the server's store has %.2f GB free of %.2f GB and keeps %.2f GB in reserve: make "
          "space (delete jobs and sets, cohort gc) and the work goes on by itself",
          free / kGigabyte, static_cast<double>(space.total_bytes) / kGigabyte,
          wanted / kGigabyte)),
      "STORE_FULL");
}

}  // namespace cohort
