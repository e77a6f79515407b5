#include "common/rpc/rpc_blob_store.h"

#include <utility>

#include <grpcpp/client_context.h>

#include "cohort/v1/blob_service.grpc.pb.h"
#include "common/base/status_macros.h"
#include "common/rpc/channel.h"
#include "common/rpc/grpc_status.h"
#include "common/store/blob_damage.h"

namespace cohort {
namespace {

/// A blob moves at 1 MB/s at the very least, or something is wrong.
constexpr double kTransferDeadlineSeconds = 1200;

class RpcBlobWriter final : public BlobWriter {
 public:
  RpcBlobWriter(const std::shared_ptr<grpc::Channel>& channel, std::string peer)
      : peer_(std::move(peer)), stub_(v1::BlobService::NewStub(channel)) {
    SetDeadline(context_, kTransferDeadlineSeconds);
    stream_ = stub_->WriteBlob(&context_, &response_);
  }
  RpcBlobWriter(const RpcBlobWriter&) = delete;
  RpcBlobWriter& operator=(const RpcBlobWriter&) = delete;
  ~RpcBlobWriter() override {
    if (!finished_) {
      context_.TryCancel();
      (void)stream_->Finish();  // The blob is abandoned; how the call ends does not matter.
    }
  }

  absl::Status Append(std::string_view bytes) override {
    hash_.Update(bytes);
    while (!bytes.empty()) {
      v1::WriteBlobRequest request;
      request.set_chunk(std::string(bytes.substr(0, kChunkBytes)));
      bytes.remove_prefix(request.chunk().size());
      if (!stream_->Write(request)) {
        const absl::Status status = Finish();
        return status.ok() ? absl::UnavailableError("blob upload to " + peer_ + " was cut off")
                           : status;
      }
    }
    return absl::OkStatus();
  }

  absl::StatusOr<Digest> Commit() override {
    COHORT_RETURN_IF_ERROR(Finish());
    const Digest digest = hash_.Finish();
    if (response_.sha256() != digest.Hex()) {
      return absl::DataLossError("blob " + digest.Hex() + " reached " + peer_ + " as " +
                                 response_.sha256());
    }
    return digest;
  }

 private:
  absl::Status Finish() {
    finished_ = true;
    stream_->WritesDone();
    return FromGrpcStatus(stream_->Finish(), peer_);
  }

  std::string peer_;
  std::unique_ptr<v1::BlobService::Stub> stub_;
  grpc::ClientContext context_;
  v1::WriteBlobResponse response_;
  std::unique_ptr<grpc::ClientWriter<v1::WriteBlobRequest>> stream_;
  Sha256 hash_;
  bool finished_ = false;
};

class RpcBlobReader final : public BlobReader {
 public:
  RpcBlobReader(const std::shared_ptr<grpc::Channel>& channel, std::string peer, Digest digest)
      : peer_(std::move(peer)),
        digest_(std::move(digest)),
        stub_(v1::BlobService::NewStub(channel)) {}
  RpcBlobReader(const RpcBlobReader&) = delete;
  RpcBlobReader& operator=(const RpcBlobReader&) = delete;
  ~RpcBlobReader() override {
    if (stream_ != nullptr && !ended_) {
      context_.TryCancel();
      (void)stream_->Finish();  // Nobody wants the rest.
    }
  }

  /// Fetches the first piece, which tells the size.
  absl::Status Start() {
    SetDeadline(context_, kTransferDeadlineSeconds);
    v1::ReadBlobRequest request;
    request.set_sha256(digest_.Hex());
    stream_ = stub_->ReadBlob(&context_, request);
    if (!stream_->Read(&piece_)) {
      ended_ = true;
      const absl::Status status = FromGrpcStatus(stream_->Finish(), peer_);
      return WithUnreadableBlob(
          status.ok() ? absl::DataLossError("blob " + digest_.Hex() + ": empty answer") : status,
          digest_);
    }
    size_bytes_ = piece_.size_bytes();
    return absl::OkStatus();
  }

  [[nodiscard]] int64_t SizeBytes() const override { return size_bytes_; }

  absl::StatusOr<std::string> Read(int64_t max_bytes) override {
    while (offset_ == piece_.chunk().size()) {
      if (ended_) {
        return std::string();
      }
      offset_ = 0;
      if (!stream_->Read(&piece_)) {
        piece_.clear_chunk();
        COHORT_RETURN_IF_ERROR(WithUnreadableBlob(End(), digest_));
        return std::string();
      }
    }
    std::string bytes = piece_.chunk().substr(offset_, static_cast<size_t>(max_bytes));
    offset_ += bytes.size();
    hash_.Update(bytes);
    return bytes;
  }

 private:
  absl::Status End() {
    ended_ = true;
    COHORT_RETURN_IF_ERROR(FromGrpcStatus(stream_->Finish(), peer_));
    const Digest read = hash_.Finish();
    if (read != digest_) {
      return absl::DataLossError("blob " + digest_.Hex() + " arrived from " + peer_ + " as " +
                                 read.Hex());
    }
    return absl::OkStatus();
  }

  std::string peer_;
  Digest digest_;
  std::unique_ptr<v1::BlobService::Stub> stub_;
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReader<v1::ReadBlobResponse>> stream_;
  v1::ReadBlobResponse piece_;
  size_t offset_ = 0;
  int64_t size_bytes_ = 0;
  Sha256 hash_;
  bool ended_ = false;
};

}  // namespace

RpcBlobStore::RpcBlobStore(std::shared_ptr<grpc::Channel> channel, std::string peer)
    : channel_(std::move(channel)), peer_(std::move(peer)) {}

absl::StatusOr<std::unique_ptr<BlobWriter>> RpcBlobStore::StartPut() {
  return std::make_unique<RpcBlobWriter>(channel_, peer_);
}

absl::StatusOr<std::unique_ptr<BlobReader>> RpcBlobStore::Open(const Digest& digest) {
  auto reader = std::make_unique<RpcBlobReader>(channel_, peer_, digest);
  COHORT_RETURN_IF_ERROR(reader->Start());
  return reader;
}

absl::StatusOr<bool> RpcBlobStore::Contains(const Digest& digest) {
  grpc::ClientContext context;
  SetDeadline(context, kUnaryDeadlineSeconds);
  v1::StatBlobRequest request;
  request.set_sha256(digest.Hex());
  v1::StatBlobResponse response;
  const auto stub = v1::BlobService::NewStub(channel_);
  COHORT_RETURN_IF_ERROR(FromGrpcStatus(stub->StatBlob(&context, request, &response), peer_));
  return response.exists();
}

}  // namespace cohort
