// Uploads that survive broken connections.
#include <algorithm>
#include <chrono>
#include <fstream>
#include <string>
#include <thread>

#include "client/session.h"
#include "cohort/v1/blob_service.grpc.pb.h"
#include "common/base/error_reason.h"
#include "common/base/status_macros.h"
#include "common/rpc/channel.h"
#include "common/rpc/grpc_status.h"

namespace cohort {
namespace {

constexpr double kUploadDeadlineSeconds = 3600;
constexpr int64_t kWhole = -1;
constexpr double kFirstPauseSeconds = 0.2;
constexpr double kLastPauseSeconds = 5;

/// The server or the way to it may be back soon; or it still holds the connection that broke.
bool IsTransient(const absl::Status& status) {
  return absl::IsUnavailable(status) || absl::IsAborted(status) || absl::IsDeadlineExceeded(status);
}

/// Pauses between tries that get longer, until patience ends. Not thread-safe.
class Patience {
 public:
  explicit Patience(double seconds) : seconds_(seconds) { Renew(); }
  void Renew() {
    end_ = std::chrono::steady_clock::now() +
           std::chrono::duration_cast<std::chrono::steady_clock::duration>(
               std::chrono::duration<double>(seconds_));
    pause_ = kFirstPauseSeconds;
  }
  /// False: it has ended.
  [[nodiscard]] bool Wait() {
    if (std::chrono::steady_clock::now() >= end_) {
      return false;
    }
    std::this_thread::sleep_for(std::chrono::duration<double>(pause_));
    pause_ = std::min(2 * pause_, kLastPauseSeconds);
    return true;
  }

 private:
  double seconds_;
  double pause_ = kFirstPauseSeconds;
  std::chrono::steady_clock::time_point end_;
};

}  // namespace

absl::Status Session::Persist(const std::function<absl::Status()>& call, double patience_seconds) {
  Patience patience(patience_seconds);
  while (true) {
    absl::Status status = call();
    if (!IsTransient(status) || !patience.Wait()) {
      return status;
    }
  }
}

absl::StatusOr<int64_t> Session::UploadedBytes(const SetMesh& mesh) {
  const auto blobs = v1::BlobService::NewStub(channel_);
  v1::QueryWriteRequest request;
  request.set_sha256(mesh.raw.Hex());
  v1::QueryWriteResponse response;
  grpc::ClientContext context;
  SetDeadline(context, kUnaryDeadlineSeconds);
  COHORT_RETURN_IF_ERROR(FromGrpcStatus(blobs->QueryWrite(&context, request, &response), address_));
  return response.complete() ? kWhole : response.committed_bytes();
}

absl::Status Session::UploadFrom(int64_t offset, const SetMesh& mesh, const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  file.seekg(offset);
  if (!file) {
    return absl::NotFoundError(path + ": cannot be read");
  }
  const auto blobs = v1::BlobService::NewStub(channel_);
  grpc::ClientContext context;
  SetDeadline(context, kUploadDeadlineSeconds);
  v1::WriteBlobResponse response;
  const auto writer = blobs->WriteBlob(&context, &response);
  v1::WriteBlobRequest message;
  message.set_sha256(mesh.raw.Hex());
  message.set_offset(offset);
  message.set_size_bytes(mesh.size_bytes);
  int64_t left = std::max(int64_t{0}, mesh.size_bytes - offset);
  do {
    std::string chunk(static_cast<size_t>(std::min(left, kChunkBytes)), '\0');
    file.read(chunk.data(), std::ssize(chunk));
    if (file.gcount() != std::ssize(chunk)) {
      context.TryCancel();
      (void)writer->Finish();  // Ours is the error to tell.
      return absl::DataLossError(path + ": has become shorter while it was sent");
    }
    left -= std::ssize(chunk);
    message.set_chunk(std::move(chunk));
    if (!writer->Write(message)) {
      break;  // Finish says why.
    }
    message.Clear();
  } while (left > 0);
  writer->WritesDone();
  return FromGrpcStatus(writer->Finish(), address_);
}

absl::Status Session::UploadFile(const SetMesh& mesh,
                                 const std::string& path,
                                 double patience_seconds) {
  Patience patience(patience_seconds);
  int64_t offset = 0;  // Most often the server has nothing yet: it is asked when it says otherwise.
  bool has_begun_anew = false;
  absl::Status status = UploadFrom(0, mesh, path);
  while (!status.ok()) {
    if (ErrorReason(status) == "UPLOAD_DAMAGED") {
      // What the server kept of an earlier try may be at fault; it has dropped that.
      if (offset == 0 || has_begun_anew) {
        return absl::DataLossError(path + ": has changed while it was sent");
      }
      has_begun_anew = true;
    } else {
      const bool may_go_on = IsTransient(status) || ErrorReason(status) == "WRONG_OFFSET";
      if (!may_go_on || !patience.Wait()) {
        return status;
      }
    }
    const absl::StatusOr<int64_t> uploaded = UploadedBytes(mesh);
    status = uploaded.status();
    if (!uploaded.ok()) {
      continue;
    }
    if (*uploaded == kWhole) {
      return absl::OkStatus();
    }
    if (*uploaded > offset) {
      patience.Renew();
    }
    offset = *uploaded;
    status = UploadFrom(offset, mesh, path);
  }
  return absl::OkStatus();
}

}  // namespace cohort
