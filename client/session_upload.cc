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

constexpr double kPieceDeadlineSeconds = 3600;
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

absl::Status Session::UploadOnce(const SetMesh& mesh, const std::string& path, int64_t& committed) {
  const auto blobs = v1::BlobService::NewStub(channel_);
  {
    v1::QueryWriteRequest request;
    request.set_sha256(mesh.raw.Hex());
    v1::QueryWriteResponse response;
    grpc::ClientContext context;
    SetDeadline(context, kUnaryDeadlineSeconds);
    COHORT_RETURN_IF_ERROR(
        FromGrpcStatus(blobs->QueryWrite(&context, request, &response), address_));
    if (response.complete()) {
      return absl::OkStatus();
    }
    committed = response.committed_bytes();
  }
  std::ifstream file(path, std::ios::binary);
  file.seekg(committed);
  if (!file) {
    return absl::NotFoundError(path + ": cannot be read");
  }
  grpc::ClientContext context;
  SetDeadline(context, kPieceDeadlineSeconds);
  v1::WriteBlobResponse response;
  const auto writer = blobs->WriteBlob(&context, &response);
  v1::WriteBlobRequest message;
  message.set_sha256(mesh.raw.Hex());
  message.set_offset(committed);
  message.set_size_bytes(mesh.size_bytes);
  int64_t left = std::max(int64_t{0}, mesh.size_bytes - committed);
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
  int64_t most_committed = 0;
  bool has_begun_anew = false;
  while (true) {
    int64_t committed = 0;
    absl::Status status = UploadOnce(mesh, path, committed);
    if (ErrorReason(status) == "UPLOAD_DAMAGED") {
      // What the server kept of an earlier try may be at fault; it has dropped that.
      if (committed == 0 || has_begun_anew) {
        return absl::DataLossError(path + ": has changed while it was sent");
      }
      has_begun_anew = true;
      continue;
    }
    if (committed > most_committed) {
      most_committed = committed;
      patience.Renew();
    }
    if (!IsTransient(status) || !patience.Wait()) {
      return status;
    }
  }
}

}  // namespace cohort
