// Streams over the hub alone, within this process: what a watcher of a job gets to see.
#include "server/services/job_watch_hub.h"

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gmock/gmock.h>
#include <grpcpp/server_builder.h>

#include "common/rpc/channel.h"
#include "common/rpc/convert.h"

namespace cohort {
namespace {

Job JobAt(int64_t version, const std::string& stage, JobState state = JobState::kRunning) {
  Job job;
  job.id = JobId{"j-000001"};
  job.version = version;
  job.state = state;
  job.progress.stage = stage;
  job.progress.tasks_done = version;
  return job;
}

/// WatchJob of a job that is given, and nothing else.
class OneJobService final
    : public v1::JobService::WithCallbackMethod_WatchJob<v1::JobService::Service> {
 public:
  OneJobService(JobWatchHub& hub, Job job) : hub_(hub), job_(std::move(job)) {}
  grpc::ServerWriteReactor<v1::WatchJobResponse>* WatchJob(
      grpc::CallbackServerContext* /*context*/, const v1::WatchJobRequest* request) override {
    return hub_.Watch(job_, request->since_version());
  }

 private:
  JobWatchHub& hub_;
  const Job job_;
};

class JobWatchHubTest : public ::testing::Test {
 protected:
  JobWatchHubTest() {
    grpc::ServerBuilder builder;
    builder.RegisterService(&service_);
    server_ = builder.BuildAndStart();
    stub_ = v1::JobService::NewStub(server_->InProcessChannel({}));
  }
  ~JobWatchHubTest() override {
    hub_.Close();
    server_->Shutdown(std::chrono::system_clock::now() + std::chrono::seconds(5));
  }

  using Stream = grpc::ClientReader<v1::WatchJobResponse>;
  [[nodiscard]] std::unique_ptr<Stream> Watch(grpc::ClientContext& context, int64_t since) const {
    SetDeadline(context, 30);
    v1::WatchJobRequest request;
    request.set_id("j-000001");
    request.set_since_version(since);
    return stub_->WatchJob(&context, request);
  }
  /// What the stream has next; version 0 if it is over.
  [[nodiscard]] static v1::Job Next(Stream& stream) {
    v1::WatchJobResponse response;
    return stream.Read(&response) ? response.job() : v1::Job();
  }

  JobWatchHub hub_;
  OneJobService service_{hub_, JobAt(5, "ingest")};
  std::unique_ptr<grpc::Server> server_;
  std::unique_ptr<v1::JobService::Stub> stub_;
};

TEST_F(JobWatchHubTest, ProgressIsPassedOnInPartItsNewestAlways) {
  constexpr int64_t kChanges = 20'000;
  grpc::ClientContext context;
  const auto stream = Watch(context, 0);
  ASSERT_EQ(Next(*stream).version(), 5);
  const auto start = std::chrono::steady_clock::now();
  for (int64_t version = 6; version <= kChanges; ++version) {
    hub_.OnJobChanged(JobAt(version, "ingest"));
  }
  int64_t messages = 0;
  int64_t last = 5;
  while (last < kChanges) {
    const int64_t version = Next(*stream).version();
    ASSERT_GT(version, last) << "versions grow";
    last = version;
    ++messages;
  }
  const auto seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  // Ten a second, on a machine of any speed; one more for each end.
  EXPECT_LE(static_cast<double>(messages), 10 * seconds + 2);
}

TEST_F(JobWatchHubTest, EachStageAndStateIsPassedOnThoughOthersJustWere) {
  grpc::ClientContext context;
  const auto stream = Watch(context, 0);
  ASSERT_EQ(Next(*stream).version(), 5);
  int64_t version = 5;
  for (const std::string stage : {"align 1", "average 1", "align 2", "compare"}) {
    hub_.OnJobChanged(JobAt(++version, stage));
    const v1::Job seen = Next(*stream);  // Waited for: newer ones would take its place.
    EXPECT_EQ(seen.version(), version);
    EXPECT_EQ(seen.progress().stage(), stage);
  }
  hub_.OnJobChanged(JobAt(++version, "compare"));
  hub_.OnJobChanged(JobAt(++version, "compare", JobState::kSucceeded));

  v1::Job seen = Next(*stream);
  if (seen.version() < version) {  // Progress had waited long enough.
    seen = Next(*stream);
  }
  EXPECT_EQ(seen.version(), version);
  EXPECT_EQ(Next(*stream).version(), 0) << "the stream ends with the job";
  EXPECT_TRUE(stream->Finish().ok());
}

TEST_F(JobWatchHubTest, BeginsAfterTheVersionThatIsKnown) {
  grpc::ClientContext context;
  const auto stream = Watch(context, 5);
  // The stream may not be open yet: an offer that comes too early is lost, as it should be.
  std::jthread changes([&](const std::stop_token& stop) {
    for (int64_t version = 6; !stop.stop_requested(); ++version) {
      hub_.OnJobChanged(JobAt(version, "ingest"));
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  EXPECT_GT(Next(*stream).version(), 5);
}

TEST_F(JobWatchHubTest, ClosingEndsStreamsAndLaterOnes) {
  grpc::ClientContext context;
  const auto stream = Watch(context, 0);
  ASSERT_EQ(Next(*stream).version(), 5);
  hub_.OnJobChanged(JobAt(6, "ingest"));  // Waits for its turn, or is on its way.

  hub_.Close();

  while (Next(*stream).version() != 0) {
  }
  EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
  grpc::ClientContext later;
  const auto refused = Watch(later, 0);
  EXPECT_EQ(Next(*refused).version(), 0);
  EXPECT_EQ(refused->Finish().error_code(), grpc::StatusCode::UNAVAILABLE);
}

TEST_F(JobWatchHubTest, AWatcherThatGoesAwayWhileProgressWaitsDoesNoHarm) {
  for (int64_t i = 0; i < 50; ++i) {
    grpc::ClientContext context;
    const auto stream = Watch(context, 0);
    ASSERT_EQ(Next(*stream).version(), 5);
    hub_.OnJobChanged(JobAt(6 + 2 * i, "ingest"));
    context.TryCancel();
    hub_.OnJobChanged(JobAt(7 + 2 * i, "ingest"));
    EXPECT_EQ(stream->Finish().error_code(), grpc::StatusCode::CANCELLED);
  }
}

}  // namespace
}  // namespace cohort
