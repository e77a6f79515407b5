#pragma once

#include <functional>
#include <memory>
#include <string>

#include <absl/status/statusor.h>

#include "common/metrics/metric_page.h"

namespace cohort {

/// Serves http://ADDRESS/metrics until it is destroyed. Without authentication: what it tells are
/// counts and times, no names of meshes.
class MetricsEndpoint {
 public:
  /// @param address  HOST:PORT; port 0: a free one.
  /// @param read  called at every request, on a thread of the endpoint.
  /// @return kInvalidArgument for a bad address, kUnavailable if it cannot be listened on.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<MetricsEndpoint>> Listen(
      const std::string& address, std::function<MetricPage()> read);
  ~MetricsEndpoint();
  MetricsEndpoint(const MetricsEndpoint&) = delete;
  MetricsEndpoint& operator=(const MetricsEndpoint&) = delete;

  /// With the port that was found: "127.0.0.1:40123".
  [[nodiscard]] const std::string& Address() const { return address_; }

  /// @return kInvalidArgument naming the address and what is expected.
  [[nodiscard]] static absl::Status CheckAddress(const std::string& address);

 private:
  struct Parts;
  explicit MetricsEndpoint(std::unique_ptr<Parts> parts);

  std::unique_ptr<Parts> parts_;
  std::string address_;
};

}  // namespace cohort
