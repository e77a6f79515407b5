#include "common/rpc/grpc_status.h"

#include <gmock/gmock.h>

#include "common/base/error_reason.h"
#include "common/rpc/channel.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::IsOk;
using testing::IsOkAndHolds;
using testing::StatusIs;

TEST(GrpcStatus, CodeMessageAndReasonSurviveTheWay) {
  const absl::Status status =
      WithReason(absl::NotFoundError("job j-9: not known"), "JOB_NOT_FOUND");
  const absl::Status back = FromGrpcStatus(ToGrpcStatus(status), "host:1");
  EXPECT_THAT(back, StatusIs(absl::StatusCode::kNotFound, "job j-9: not known"));
  EXPECT_EQ(ErrorReason(back), "JOB_NOT_FOUND");
  EXPECT_THAT(FromGrpcStatus(ToGrpcStatus(absl::OkStatus()), "host:1"), IsOk());
}

TEST(GrpcStatus, AnErrorWithoutAReasonCarriesItsCodesName) {
  const grpc::Status wire = ToGrpcStatus(absl::DataLossError("blob damaged"));
  EXPECT_EQ(ErrorReason(FromGrpcStatus(wire, "host:1")), "DATA_LOSS");
}

TEST(GrpcStatus, ATransportFailureNamesTheServer) {
  const grpc::Status wire(grpc::StatusCode::UNAVAILABLE, "failed to connect to all addresses");
  EXPECT_THAT(FromGrpcStatus(wire, "host:7450"),
              StatusIs(absl::StatusCode::kUnavailable, "host:7450"));
}

TEST(NormalizeAddress, TakesHostsAndSockets) {
  EXPECT_THAT(NormalizeAddress("host:7450"), IsOkAndHolds(std::string("host:7450")));
  EXPECT_THAT(NormalizeAddress("127.0.0.1:0"), IsOkAndHolds(std::string("127.0.0.1:0")));
  EXPECT_THAT(NormalizeAddress("[::1]:80"), IsOkAndHolds(std::string("[::1]:80")));
  EXPECT_THAT(NormalizeAddress("unix:/run/s"), IsOkAndHolds(std::string("unix:/run/s")));
  EXPECT_THAT(NormalizeAddress("/run/s"), IsOkAndHolds(std::string("unix:/run/s")));
}

TEST(NormalizeAddress, RefusesTheRest) {
  for (const char* address : {"", "host", "host:", ":80", "host:x", "host:99999", "unix:"}) {
    EXPECT_THAT(NormalizeAddress(address),
                StatusIs(absl::StatusCode::kInvalidArgument, "HOST:PORT"))
        << address;
  }
}

}  // namespace
}  // namespace cohort
