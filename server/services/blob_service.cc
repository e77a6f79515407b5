#include "server/services/blob_service.h"

#include <memory>
#include <optional>
#include <string>

#include <absl/strings/str_cat.h>
#include <spdlog/spdlog.h>

#include "common/base/error_reason.h"
#include "common/base/status_macros.h"
#include "common/rpc/channel.h"
#include "common/rpc/grpc_status.h"
#include "common/store/blob_damage.h"

namespace cohort {
namespace {

absl::Status Send(BlobStore& store,
                  const std::string& hex,
                  grpc::ServerWriter<v1::ReadBlobResponse>& writer) {
  COHORT_ASSIGN_OR_RETURN(const Digest digest, Digest::FromHex(hex));
  COHORT_ASSIGN_OR_RETURN(std::unique_ptr<BlobReader> reader, store.Open(digest));
  v1::ReadBlobResponse piece;
  piece.set_size_bytes(reader->SizeBytes());
  while (true) {
    COHORT_ASSIGN_OR_RETURN(*piece.mutable_chunk(), reader->Read(kChunkBytes));
    const bool is_first = piece.size_bytes() > 0 || reader->SizeBytes() == 0;
    if ((piece.chunk().empty() && !is_first) || !writer.Write(piece) || piece.chunk().empty()) {
      return absl::OkStatus();
    }
    piece.set_size_bytes(0);
  }
}

/// What people are to know and do when a blob cannot be read.
absl::Status ExplainDamage(ManagedBlobStore& store, const absl::Status& read) {
  const std::optional<Digest> blob = UnreadableBlob(read);
  if (!blob) {
    return read;
  }
  COHORT_ASSIGN_OR_RETURN(const bool is_lost, store.QuarantineIfUnreadable(*blob));
  if (!is_lost) {
    return absl::UnavailableError("blob " + blob->Hex() + " could not be read; try again");
  }
  constexpr char kRemedy[] =
      "; if it belongs to the results of a job, \"cohort retry JOB\" computes what is lost and "
      "nothing else";
  if (absl::IsNotFound(read)) {
    return absl::NotFoundError(
        absl::StrCat("blob ", blob->Hex(), " is not in the server's store", kRemedy));
  }
  spdlog::error("event=blob_lost blob={} error=\"{}\"", blob->Hex(), std::string(read.message()));
  return WithReason(absl::DataLossError(absl::StrCat(
                        "blob ", blob->Hex(), " was damaged in the server's store", kRemedy)),
                    "BLOB_DAMAGED");
}

absl::StatusOr<Digest> ReceiveBlob(BlobStore& store,
                                   v1::WriteBlobRequest& piece,
                                   grpc::ServerReader<v1::WriteBlobRequest>& reader) {
  COHORT_ASSIGN_OR_RETURN(const std::unique_ptr<BlobWriter> writer, store.StartPut());
  do {
    COHORT_RETURN_IF_ERROR(writer->Append(piece.chunk()));
  } while (reader.Read(&piece));
  return writer->Commit();
}

absl::StatusOr<Digest> ReceiveUpload(Coordinator& coordinator,
                                     v1::WriteBlobRequest& piece,
                                     grpc::ServerReader<v1::WriteBlobRequest>& reader) {
  COHORT_ASSIGN_OR_RETURN(const Digest digest, Digest::FromHex(piece.sha256()));
  COHORT_RETURN_IF_ERROR(coordinator.CheckSpace());
  const int64_t size = piece.size_bytes();
  int64_t received = piece.offset();
  COHORT_ASSIGN_OR_RETURN(const std::unique_ptr<BlobWriter> writer,
                          coordinator.Store().ResumePut(digest, received));
  do {
    received += std::ssize(piece.chunk());
    if (received > size) {
      return absl::InvalidArgumentError(
          absl::StrCat("upload of ", digest.Hex(), ": ", received, " bytes of ", size));
    }
    COHORT_RETURN_IF_ERROR(writer->Append(piece.chunk()));
  } while (reader.Read(&piece));
  if (received < size) {
    return WithReason(
        absl::UnavailableError(absl::StrCat("the upload of ", digest.Hex(), " was cut off at byte ",
                                            received, " of ", size, "; go on there")),
        "UPLOAD_INCOMPLETE");
  }
  return writer->Commit();
}

}  // namespace

grpc::Status BlobServiceSkin::StatBlob(grpc::ServerContext* /*context*/,
                                       const v1::StatBlobRequest* request,
                                       v1::StatBlobResponse* response) {
  const absl::StatusOr<Digest> digest = Digest::FromHex(request->sha256());
  if (!digest.ok()) {
    return ToGrpcStatus(digest.status());
  }
  const absl::StatusOr<bool> exists = store_.Renew(*digest);
  if (!exists.ok()) {
    return ToGrpcStatus(exists.status());
  }
  response->set_exists(*exists);
  return grpc::Status::OK;
}

grpc::Status BlobServiceSkin::ReadBlob(grpc::ServerContext* /*context*/,
                                       const v1::ReadBlobRequest* request,
                                       grpc::ServerWriter<v1::ReadBlobResponse>* writer) {
  return ToGrpcStatus(ExplainDamage(store_, Send(store_, request->sha256(), *writer)));
}

grpc::Status BlobServiceSkin::WriteBlob(grpc::ServerContext* context,
                                        grpc::ServerReader<v1::WriteBlobRequest>* reader,
                                        v1::WriteBlobResponse* response) {
  v1::WriteBlobRequest piece;
  const bool is_empty = !reader->Read(&piece);
  const absl::StatusOr<Digest> digest = is_empty || piece.sha256().empty()
                                            ? ReceiveBlob(store_, piece, *reader)
                                            : ReceiveUpload(coordinator_, piece, *reader);
  if (!digest.ok()) {
    return ToGrpcStatus(digest.status());
  }
  if (context->IsCancelled()) {
    return grpc::Status::CANCELLED;  // Cut off: what was kept is a prefix that nobody asks for.
  }
  response->set_sha256(digest->Hex());
  return grpc::Status::OK;
}

grpc::Status BlobServiceSkin::QueryWrite(grpc::ServerContext* /*context*/,
                                         const v1::QueryWriteRequest* request,
                                         v1::QueryWriteResponse* response) {
  const absl::StatusOr<Digest> digest = Digest::FromHex(request->sha256());
  if (!digest.ok()) {
    return ToGrpcStatus(digest.status());
  }
  const absl::StatusOr<bool> exists = store_.Renew(*digest);
  if (!exists.ok()) {
    return ToGrpcStatus(exists.status());
  }
  const absl::StatusOr<int64_t> kept = store_.UploadedBytes(*digest);
  if (!kept.ok()) {
    return ToGrpcStatus(kept.status());
  }
  response->set_complete(*exists);
  response->set_committed_bytes(*kept);
  return grpc::Status::OK;
}

}  // namespace cohort
