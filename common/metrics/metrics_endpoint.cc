#include "common/metrics/metrics_endpoint.h"

#include <algorithm>
#include <cctype>
#include <exception>
#include <utility>
#include <vector>

#include <absl/strings/numbers.h>
#include <absl/strings/str_cat.h>
#include <prometheus/collectable.h>
#include <prometheus/exposer.h>

#include "common/base/status_macros.h"

namespace cohort {
namespace {

class Page final : public prometheus::Collectable {
 public:
  explicit Page(std::function<MetricPage()> read) : read_(std::move(read)) {}
  [[nodiscard]] std::vector<prometheus::MetricFamily> Collect() const override {
    return read_().Families();
  }

 private:
  std::function<MetricPage()> read_;
};

}  // namespace

struct MetricsEndpoint::Parts {
  Parts(const std::string& address, std::function<MetricPage()> read)
      : page(std::make_shared<Page>(std::move(read))), exposer(address) {
    exposer.RegisterCollectable(page);
  }
  std::shared_ptr<Page> page;
  prometheus::Exposer exposer;  // Last: its threads end before the page does.
};

MetricsEndpoint::MetricsEndpoint(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}

MetricsEndpoint::~MetricsEndpoint() = default;

absl::Status MetricsEndpoint::CheckAddress(const std::string& address) {
  const size_t colon = address.rfind(':');
  int port = -1;
  const bool has_port =
      colon != std::string::npos && absl::SimpleAtoi(address.substr(colon + 1), &port);
  // The library would take a comma, a suffix "s" and more for options of its own.
  const bool is_host =
      colon != std::string::npos && colon > 0 &&
      std::all_of(
          address.begin(), address.begin() + static_cast<int64_t>(colon), [](unsigned char c) {
            return std::isalnum(c) != 0 || c == '.' || c == '-' || c == ':' || c == '[' || c == ']';
          });
  if (!has_port || !is_host || port < 0 || port > 65535) {
    return absl::InvalidArgumentError(
        absl::StrCat("--metrics-listen ", address, ": expected HOST:PORT, port 0 for a free one"));
  }
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<MetricsEndpoint>> MetricsEndpoint::Listen(
    const std::string& address, std::function<MetricPage()> read) {
  COHORT_RETURN_IF_ERROR(CheckAddress(address));
  try {
    std::unique_ptr<MetricsEndpoint> endpoint(
        new MetricsEndpoint(std::make_unique<Parts>(address, std::move(read))));
    const std::vector<int> ports = endpoint->parts_->exposer.GetListeningPorts();
    if (!ports.empty()) {
      endpoint->address_ = absl::StrCat(address.substr(0, address.rfind(':') + 1), ports.front());
      return endpoint;
    }
  } catch (const std::exception&) {  // Says no more than what is said below.
  }
  return absl::UnavailableError(
      absl::StrCat("cannot serve metrics on ", address,
                   ": no address of this machine, or is another program using it?"));
}

}  // namespace cohort
