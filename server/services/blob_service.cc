#include "server/services/blob_service.h"

#include <memory>
#include <string>

#include "common/base/status_macros.h"
#include "common/rpc/channel.h"
#include "common/rpc/grpc_status.h"

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

absl::StatusOr<Digest> Receive(BlobStore& store, grpc::ServerReader<v1::WriteBlobRequest>& reader) {
  COHORT_ASSIGN_OR_RETURN(std::unique_ptr<BlobWriter> writer, store.StartPut());
  v1::WriteBlobRequest piece;
  while (reader.Read(&piece)) {
    COHORT_RETURN_IF_ERROR(writer->Append(piece.chunk()));
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
  const absl::StatusOr<bool> exists = store_.Contains(*digest);
  if (!exists.ok()) {
    return ToGrpcStatus(exists.status());
  }
  response->set_exists(*exists);
  return grpc::Status::OK;
}

grpc::Status BlobServiceSkin::ReadBlob(grpc::ServerContext* /*context*/,
                                       const v1::ReadBlobRequest* request,
                                       grpc::ServerWriter<v1::ReadBlobResponse>* writer) {
  return ToGrpcStatus(Send(store_, request->sha256(), *writer));
}

grpc::Status BlobServiceSkin::WriteBlob(grpc::ServerContext* context,
                                        grpc::ServerReader<v1::WriteBlobRequest>* reader,
                                        v1::WriteBlobResponse* response) {
  const absl::StatusOr<Digest> digest = Receive(store_, *reader);
  if (!digest.ok()) {
    return ToGrpcStatus(digest.status());
  }
  if (context->IsCancelled()) {
    return grpc::Status::CANCELLED;  // Cut off: what was kept is a prefix that nobody asks for.
  }
  response->set_sha256(digest->Hex());
  return grpc::Status::OK;
}

}  // namespace cohort
