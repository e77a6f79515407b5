#include "common/metrics/metrics_endpoint.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <string>

#include <gmock/gmock.h>

#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::testing::HasSubstr;
using testing::IsOk;
using ::testing::Not;
using ::testing::StartsWith;
using testing::StatusIs;

/// The whole answer to a GET of 127.0.0.1.
std::string Fetch(const std::string& address, const std::string& path) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(static_cast<uint16_t>(std::stoi(address.substr(address.rfind(':') + 1))));
  inet_pton(AF_INET, "127.0.0.1", &to.sin_addr);
  const int fd = socket(AF_INET, SOCK_STREAM, 0);
  std::string answer;
  if (connect(fd, reinterpret_cast<const sockaddr*>(&to), sizeof(to)) == 0) {
    const std::string request = "GET " + path + " HTTP/1.0\r\n\r\n";
    EXPECT_EQ(write(fd, request.data(), request.size()), std::ssize(request));
    std::string chunk(4096, '\0');
    for (ssize_t n = 0; (n = read(fd, chunk.data(), chunk.size())) > 0;) {
      answer.append(chunk, 0, static_cast<size_t>(n));
    }
  }
  close(fd);
  return answer;
}

TEST(MetricsEndpoint, ServesThePageAsItIsAtEachRequest) {
  std::atomic<int> asked = 0;
  const auto endpoint = MetricsEndpoint::Listen("127.0.0.1:0", [&] {
    MetricPage page;
    page.AddCounter("cohort_asked_total", "How often this page was read.", ++asked);
    return page;
  });
  ASSERT_THAT(endpoint, IsOk());
  EXPECT_THAT((*endpoint)->Address(), StartsWith("127.0.0.1:"));
  const std::string first = Fetch((*endpoint)->Address(), "/metrics");
  EXPECT_THAT(first, StartsWith("HTTP/1.1 200"));
  EXPECT_THAT(first, HasSubstr("text/plain"));
  EXPECT_THAT(first, HasSubstr("# HELP cohort_asked_total How often this page was read.\n"
                               "# TYPE cohort_asked_total counter\ncohort_asked_total 1\n"));
  EXPECT_THAT(Fetch((*endpoint)->Address(), "/metrics"), HasSubstr("cohort_asked_total 2\n"));
  EXPECT_THAT(Fetch((*endpoint)->Address(), "/etc/passwd"), StartsWith("HTTP/1.0 404"));
}

TEST(MetricsEndpoint, IsGoneWithItsObject) {
  std::string address;
  {
    const auto endpoint = MetricsEndpoint::Listen("127.0.0.1:0", [] { return MetricPage(); });
    ASSERT_THAT(endpoint, IsOk());
    address = (*endpoint)->Address();
    EXPECT_THAT(Fetch(address, "/metrics"), Not(""));
  }
  EXPECT_EQ(Fetch(address, "/metrics"), "");
}

TEST(MetricsEndpoint, RefusesAddressesThatItCannotServe) {
  const auto page = [] { return MetricPage(); };
  for (const std::string bad : {"", "9464", "127.0.0.1", "127.0.0.1:", ":9464", "127.0.0.1:99999",
                                "127.0.0.1:0,9999", "127.0.0.1:94s", "127.0.0.1:-1"}) {
    EXPECT_THAT(MetricsEndpoint::Listen(bad, page),
                StatusIs(absl::StatusCode::kInvalidArgument, "--metrics-listen"))
        << bad;
  }
  const auto first = MetricsEndpoint::Listen("127.0.0.1:0", page);
  ASSERT_THAT(first, IsOk());
  EXPECT_THAT(MetricsEndpoint::Listen((*first)->Address(), page),
              StatusIs(absl::StatusCode::kUnavailable, "another program"));
}

}  // namespace
}  // namespace cohort
