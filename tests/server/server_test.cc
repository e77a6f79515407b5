// The whole server process in this one, spoken to over a unix socket by generated and by generic
// stubs: what any gRPC client can rely on.
#include "server/server.h"

#include <filesystem>
#include <memory>
#include <string>

#include <gmock/gmock.h>
#include <grpcpp/create_channel.h>
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/support/byte_buffer.h>
#include <unistd.h>

#include "cohort/v1/errors.pb.h"
#include "cohort/v1/job_service.grpc.pb.h"
#include "cohort/v1/worker_service.grpc.pb.h"
#include "common/jobs/worker_build.h"
#include "common/rpc/channel.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using ::testing::HasSubstr;
using testing::IsOk;
using testing::StatusIs;

class ServerTest : public ::testing::Test {
 protected:
  ServerTest() {
    folder_ = std::filesystem::temp_directory_path() / ("server_test-" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
    options_.data_dir = (folder_ / "data").string();
    options_.listen = {"unix:" + (folder_ / "s").string(), "127.0.0.1:0"};
  }
  ~ServerTest() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_;
  ServerOptions options_;
};

/// One call with raw bytes, as a client of another language would make it.
std::string CallRaw(const std::shared_ptr<grpc::Channel>& channel,
                    const std::string& method,
                    const std::string& request) {
  grpc::GenericStub stub(channel);
  grpc::ClientContext context;
  SetDeadline(context, 10);
  grpc::CompletionQueue queue;
  void* tag = nullptr;
  bool ok = false;
  const auto call = stub.PrepareCall(&context, method, &queue);
  call->StartCall(nullptr);
  queue.Next(&tag, &ok);
  const grpc::Slice slice(request);
  call->Write(grpc::ByteBuffer(&slice, 1), nullptr);
  queue.Next(&tag, &ok);
  grpc::ByteBuffer reply;
  call->Read(&reply, nullptr);
  queue.Next(&tag, &ok);
  std::string bytes;
  grpc::Slice flat;
  if (ok && reply.DumpToSingleSlice(&flat).ok()) {
    bytes.assign(reinterpret_cast<const char*>(flat.begin()), flat.size());
  }
  context.TryCancel();
  grpc::Status status;
  call->Finish(&status, nullptr);
  queue.Next(&tag, &ok);
  queue.Shutdown();
  while (queue.Next(&tag, &ok)) {
  }
  return bytes;
}

TEST_F(ServerTest, ServesHealthAndReflectionOnEveryAddress) {
  const auto server = Server::Start(options_);
  ASSERT_THAT(server, IsOk());
  ASSERT_EQ((*server)->Addresses().size(), 2U);
  for (const std::string& address : (*server)->Addresses()) {
    const auto channel = OpenChannel(address);
    // HealthCheckResponse { status: SERVING }.
    EXPECT_EQ(CallRaw(channel, "/grpc.health.v1.Health/Check", ""), std::string("\x08\x01"));
    // ServerReflectionRequest { list_services: "" }.
    const std::string services =
        CallRaw(channel, "/grpc.reflection.v1alpha.ServerReflection/ServerReflectionInfo",
                std::string("\x3a\x00", 2));
    for (const char* service :
         {"JobService", "MeshService", "ResultService", "BlobService", "WorkerService"}) {
      EXPECT_THAT(services, HasSubstr(std::string("cohort.v1.") + service));
    }
  }
}

TEST_F(ServerTest, EveryErrorCarriesOneErrorInfo) {
  const auto server = Server::Start(options_);
  ASSERT_THAT(server, IsOk());
  const auto stub = v1::JobService::NewStub(OpenChannel((*server)->Addresses()[0]));
  grpc::ClientContext context;
  SetDeadline(context, 10);
  v1::GetJobRequest request;
  request.set_id("j-000404");
  v1::GetJobResponse response;
  const grpc::Status status = stub->GetJob(&context, request, &response);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_THAT(status.error_message(), HasSubstr("j-000404"));
  v1::ErrorStatus details;
  ASSERT_TRUE(details.ParseFromString(status.error_details()));
  ASSERT_EQ(details.details_size(), 1);
  EXPECT_EQ(details.details(0).type_url(), "type.googleapis.com/google.rpc.ErrorInfo");
  v1::ErrorInfo error;
  ASSERT_TRUE(error.ParseFromString(details.details(0).value()));
  EXPECT_EQ(error.domain(), "cohort");
  EXPECT_FALSE(error.reason().empty());
}

TEST_F(ServerTest, WatchingAnUnknownJobEndsAtOnce) {
  const auto server = Server::Start(options_);
  ASSERT_THAT(server, IsOk());
  const auto stub = v1::JobService::NewStub(OpenChannel((*server)->Addresses()[0]));
  grpc::ClientContext context;
  SetDeadline(context, 10);
  v1::WatchJobRequest request;
  request.set_id("j-000404");
  const auto reader = stub->WatchJob(&context, request);
  v1::WatchJobResponse message;
  EXPECT_FALSE(reader->Read(&message));
  EXPECT_EQ(reader->Finish().error_code(), grpc::StatusCode::NOT_FOUND);
}

TEST_F(ServerTest, AnswersTheReportThatComesWithAResult) {
  const auto server = Server::Start(options_);
  ASSERT_THAT(server, IsOk());
  const auto stub = v1::WorkerService::NewStub(OpenChannel((*server)->Addresses()[0]));
  v1::CompleteTaskRequest request;
  request.set_worker("w");
  request.mutable_lease()->set_job("j-000404");  // Of a job that was deleted meanwhile.
  request.mutable_lease()->set_epoch(1);
  v1::SynchronizeRequest& report = *request.mutable_report();
  report.set_worker("w");
  report.set_slots(1);
  report.set_free_slots(1);
  report.set_wait_ms(60'000);
  *report.add_held()->mutable_lease() = request.lease();
  const auto complete = [&] {
    grpc::ClientContext context;
    SetDeadline(context, 10);  // It does not wait for tasks.
    v1::CompleteTaskResponse response;
    const grpc::Status status = stub->CompleteTask(&context, request, &response);
    EXPECT_TRUE(status.ok()) << status.error_message();
    EXPECT_TRUE(response.superseded());
    return response;
  };
  report.set_build("0.0.1 (results 1)");
  EXPECT_FALSE(complete().has_orders()) << "the result is heard, the worker is not one of ours";
  report.set_build(WorkerBuild());
  const v1::CompleteTaskResponse response = complete();
  ASSERT_TRUE(response.has_orders());
  ASSERT_EQ(response.orders().lost_size(), 1);
  EXPECT_EQ(response.orders().lost(0).job(), "j-000404");
  EXPECT_GT(response.orders().lease_ms(), 0);
}

TEST_F(ServerTest, RefusesOptionsByName) {
  options_.lease_seconds = 0;
  EXPECT_THAT(Server::Start(options_),
              StatusIs(absl::StatusCode::kInvalidArgument, "--lease-seconds"));
  options_.lease_seconds = 60;
  options_.listen = {"nowhere"};
  EXPECT_THAT(Server::Start(options_), StatusIs(absl::StatusCode::kInvalidArgument, "nowhere"));
}

}  // namespace
}  // namespace cohort
