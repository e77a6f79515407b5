// Uploads through a bad network and over a restart of the server, to a real server in this process.
#include "client/upload.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>

#include <gmock/gmock.h>

#include "client/files.h"
#include "cohort/v1/blob_service.grpc.pb.h"
#include "common/base/error_reason.h"
#include "common/rpc/channel.h"
#include "common/rpc/grpc_status.h"
#include "server/server.h"
#include "tests/testing/cutting_relay.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

namespace fs = std::filesystem;

using testing::CuttingRelay;
using testing::IsOk;
using testing::IsOkAndHolds;
using testing::StatusIs;

constexpr int64_t kMegabyte = 1'000'000;

class UploadTest : public ::testing::Test {
 protected:
  UploadTest() {
    std::string name = (fs::temp_directory_path() / "upload-test-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    options_.data_dir = (folder_ / "data").string();
    options_.listen = {"unix:" + (folder_ / "s").string()};
    options_.min_free_gb = 0;
    options_.min_free_percent = 0;
    StartServer();
  }
  ~UploadTest() override {
    server_.reset();
    fs::remove_all(folder_);
  }

  void StartServer() {
    server_.reset();
    auto started = Server::Start(options_);
    ASSERT_THAT(started, IsOk());
    server_ = *std::move(started);
  }

  /// A file of `size` bytes that do not repeat.
  MeshFile MakeFile(const std::string& name, int64_t size) {
    std::string bytes(static_cast<size_t>(size), '\0');
    uint64_t state = 7;
    for (char& byte : bytes) {
      state = state * 6364136223846793005U + 1442695040888963407U;
      byte = static_cast<char>(state >> 56);
    }
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    MeshFile file{.path = folder_ / name, .mesh = {}};
    file.mesh.name = name;
    file.mesh.raw = Sha256::Of(bytes);
    file.mesh.size_bytes = size;
    return file;
  }

  std::unique_ptr<Session> Connect(const std::string& socket) {
    return Session::Open("unix:" + (folder_ / socket).string()).value();
  }
  std::unique_ptr<v1::BlobService::Stub> Blobs() {
    return v1::BlobService::NewStub(OpenChannel("unix:" + (folder_ / "s").string()));
  }
  int64_t Committed(const Digest& digest) {
    v1::QueryWriteRequest request;
    request.set_sha256(digest.Hex());
    v1::QueryWriteResponse response;
    grpc::ClientContext context;
    SetDeadline(context, 10);
    EXPECT_TRUE(Blobs()->QueryWrite(&context, request, &response).ok());
    return response.complete() ? -1 : response.committed_bytes();
  }
  /// One WriteBlob call by hand.
  absl::Status Write(const Digest& digest, int64_t offset, int64_t size, const std::string& bytes) {
    const auto stub = Blobs();
    grpc::ClientContext context;
    SetDeadline(context, 10);
    v1::WriteBlobResponse response;
    const auto writer = stub->WriteBlob(&context, &response);
    v1::WriteBlobRequest message;
    message.set_sha256(digest.Hex());
    message.set_offset(offset);
    message.set_size_bytes(size);
    message.set_chunk(bytes);
    writer->Write(message);
    writer->WritesDone();
    return FromGrpcStatus(writer->Finish(), "server");
  }

  fs::path folder_;
  ServerOptions options_;
  std::unique_ptr<Server> server_;
};

TEST_F(UploadTest, GoesOnWhereTheNetworkCutItOff) {
  const CuttingRelay relay(folder_ / "bad", folder_ / "s", 3, 12 * kMegabyte);
  ASSERT_TRUE(relay.Ok());
  const MeshFile file = MakeFile("a.ply", 40 * kMegabyte);
  const auto session = Connect("bad");

  const absl::StatusOr<UploadCounts> counts = Upload(*session, "set", {file});

  ASSERT_THAT(counts, IsOk());
  EXPECT_EQ(counts->sent, 1);
  EXPECT_EQ(relay.Cuts(), 3);
  // What was on its way at a cut is sent again, nothing else.
  EXPECT_LT(relay.Bytes(), 40 * kMegabyte + int64_t{3} * 8 * kMegabyte);
  EXPECT_EQ(Committed(file.mesh.raw), -1);
  const auto direct = Connect("s");
  EXPECT_THAT(direct->Blobs().Get(file.mesh.raw), IsOk());
  EXPECT_EQ(direct->ListMeshes("set")->size(), 1U);
}

TEST_F(UploadTest, GoesOnAfterTheServerWasStartedAgain) {
  const MeshFile file = MakeFile("a.ply", 3 * kMegabyte);
  const std::string bytes = ReadWholeFile(file.path).value();
  const auto cut = Write(file.mesh.raw, 0, 3 * kMegabyte, bytes.substr(0, kMegabyte));
  EXPECT_THAT(cut, StatusIs(absl::StatusCode::kUnavailable, "cut off at byte 1000000 of 3000000"));
  EXPECT_EQ(ErrorReason(cut), "UPLOAD_INCOMPLETE");
  const auto session = Connect("s");
  server_.reset();
  absl::Status uploaded;
  std::thread client([&] { uploaded = session->UploadFile(file.mesh, file.path.string(), 60); });
  std::this_thread::sleep_for(std::chrono::milliseconds(500));  // It finds nobody.
  StartServer();
  client.join();

  EXPECT_THAT(uploaded, IsOk());
  EXPECT_EQ(Committed(file.mesh.raw), -1);
  EXPECT_THAT(session->Blobs().Get(file.mesh.raw), IsOkAndHolds(bytes));
}

TEST_F(UploadTest, RefusesAWrongOffsetAndKeepsWhatItHas) {
  const MeshFile file = MakeFile("a.ply", 2000);
  const std::string bytes = ReadWholeFile(file.path).value();
  ASSERT_FALSE(Write(file.mesh.raw, 0, 2000, bytes.substr(0, 500)).ok());
  ASSERT_EQ(Committed(file.mesh.raw), 500);

  for (const int64_t offset : {0, 499, 501, 2000}) {
    const auto refused = Write(file.mesh.raw, offset, 2000, bytes.substr(0, 10));
    EXPECT_THAT(refused, StatusIs(absl::StatusCode::kOutOfRange, "at byte 500"));
    EXPECT_EQ(ErrorReason(refused), "WRONG_OFFSET");
  }
  EXPECT_EQ(Committed(file.mesh.raw), 500);
  EXPECT_THAT(Write(file.mesh.raw, 500, 2000, bytes.substr(500)), IsOk());
  EXPECT_EQ(Committed(file.mesh.raw), -1);
}

TEST_F(UploadTest, RefusesBytesOfAnotherDigestAndMoreThanAnnounced) {
  const MeshFile file = MakeFile("a.ply", 2000);
  EXPECT_EQ(ErrorReason(Write(file.mesh.raw, 0, 2000, std::string(2000, 'x'))), "UPLOAD_DAMAGED");
  EXPECT_EQ(Committed(file.mesh.raw), 0) << "nothing is kept";
  EXPECT_THAT(Write(file.mesh.raw, 0, 2000, std::string(2001, 'x')),
              StatusIs(absl::StatusCode::kInvalidArgument, "2001 bytes of 2000"));
}

TEST_F(UploadTest, BeginsAnewWhenWhatTheServerKeptIsDamaged) {
  const MeshFile file = MakeFile("a.ply", 2 * kMegabyte);
  ASSERT_FALSE(Write(file.mesh.raw, 0, 2 * kMegabyte, std::string(1000, 'x')).ok());
  ASSERT_EQ(Committed(file.mesh.raw), 1000);
  EXPECT_THAT(Connect("s")->UploadFile(file.mesh, file.path.string()), IsOk());
  EXPECT_EQ(Committed(file.mesh.raw), -1);
}

TEST_F(UploadTest, SaysWhenAFileChangesWhileItIsSent) {
  const MeshFile file = MakeFile("a.ply", 2000);
  std::ofstream(file.path, std::ios::binary) << std::string(2000, 'x');
  EXPECT_THAT(Connect("s")->UploadFile(file.mesh, file.path.string()),
              StatusIs(absl::StatusCode::kDataLoss, "has changed"));
  fs::resize_file(file.path, 10);
  EXPECT_THAT(Connect("s")->UploadFile(file.mesh, file.path.string()),
              StatusIs(absl::StatusCode::kDataLoss, "shorter"));
}

TEST_F(UploadTest, EndsItsPatienceWithAServerThatStaysAway) {
  const MeshFile file = MakeFile("a.ply", 2000);
  const auto session = Connect("s");
  server_.reset();
  EXPECT_THAT(session->UploadFile(file.mesh, file.path.string(), 0.5),
              StatusIs(absl::StatusCode::kUnavailable, "cannot reach the server"));
}

TEST_F(UploadTest, AStoreShortOfSpaceRefusesUploadsWithNumbers) {
  options_.min_free_percent = 90;
  options_.min_free_gb = 1e6;
  StartServer();
  const MeshFile file = MakeFile("a.ply", 2000);
  const auto session = Connect("s");
  const auto refused = Upload(*session, "set", {file});
  EXPECT_THAT(refused,
              StatusIs(absl::StatusCode::kResourceExhausted, "keeps 1000000.00 GB in reserve"));
  EXPECT_EQ(ErrorReason(refused.status()), "STORE_FULL");
  // What workers write is not refused.
  EXPECT_THAT(session->Blobs().Put("a result"), IsOk());
}

TEST_F(UploadTest, AThousandFilesAreAskedForInPagesAndKnownOnesStayHere) {
  std::vector<MeshFile> files;
  for (int i = 0; i < 1050; ++i) {
    const std::string name = "mesh " + std::to_string(i);
    std::ofstream(folder_ / name) << name;
    MeshFile file{.path = folder_ / name, .mesh = {}};
    file.mesh.name = name;
    file.mesh.raw = Sha256::Of(name);
    file.mesh.size_bytes = std::ssize(name);
    files.push_back(std::move(file));
  }
  const auto session = Connect("s");
  const std::vector<MeshFile> some(files.begin() + 990, files.begin() + 1010);
  ASSERT_THAT(Upload(*session, "set", some), IsOk());

  const auto counts = Upload(*session, "set", files);

  ASSERT_THAT(counts, IsOk());
  EXPECT_EQ(counts->known, 20);
  EXPECT_EQ(counts->sent, 1030);
  EXPECT_EQ(session->ListMeshes("set")->size(), 1050U);
}

TEST_F(UploadTest, ADamagedBlobIsReportedOnceAndThenMissing) {
  const MeshFile file = MakeFile("a.ply", 2000);
  const auto session = Connect("s");
  ASSERT_THAT(Upload(*session, "set", {file}), IsOk());
  const std::string hex = file.mesh.raw.Hex();
  const fs::path blob = folder_ / "data" / "blobs" / "sha256" / hex.substr(0, 2) / hex;
  fs::permissions(blob, fs::perms(0644));
  fs::resize_file(blob, 1999);

  const auto read = session->Blobs().Get(file.mesh.raw);

  EXPECT_THAT(read, StatusIs(absl::StatusCode::kDataLoss, "cohort retry JOB"));
  EXPECT_EQ(ErrorReason(read.status()), "BLOB_DAMAGED");
  EXPECT_THAT(session->Blobs().Get(file.mesh.raw), StatusIs(absl::StatusCode::kNotFound, hex));
  const auto counts = Upload(*session, "set", {file});
  EXPECT_EQ(counts->sent, 1) << "cohort add mends it";
  EXPECT_THAT(session->Blobs().Get(file.mesh.raw), IsOk());
}

TEST_F(UploadTest, GarbageCanBeCollectedOnRequest) {
  const MeshFile file = MakeFile("a.ply", 2000);
  const auto session = Connect("s");
  ASSERT_THAT(Upload(*session, "set", {file}), IsOk());
  ASSERT_THAT(session->Blobs().Put("garbage"), IsOk());
  EXPECT_EQ(session->CollectGarbage({}, {})->blobs(), 0) << "it is young";
  const auto count = session->CollectGarbage(0, {});
  EXPECT_EQ(count->blobs(), 1);
  EXPECT_EQ(count->bytes(), 7);
  EXPECT_EQ(count->kept_bytes(), 2000);
}

}  // namespace
}  // namespace cohort
