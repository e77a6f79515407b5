#pragma once

#include "cohort/v1/blob_service.grpc.pb.h"
#include "server/core/coordinator.h"

namespace cohort {

/// BlobService over the coordinator's store, piece by piece. A damaged blob that somebody asks for
/// is moved aside, so that it is made again when it is needed.
class BlobServiceSkin final : public v1::BlobService::Service {
 public:
  explicit BlobServiceSkin(Coordinator& coordinator)
      : coordinator_(coordinator), store_(coordinator.Store()) {}

  grpc::Status StatBlob(grpc::ServerContext* context,
                        const v1::StatBlobRequest* request,
                        v1::StatBlobResponse* response) override;
  grpc::Status ReadBlob(grpc::ServerContext* context,
                        const v1::ReadBlobRequest* request,
                        grpc::ServerWriter<v1::ReadBlobResponse>* writer) override;
  grpc::Status WriteBlob(grpc::ServerContext* context,
                         grpc::ServerReader<v1::WriteBlobRequest>* reader,
                         v1::WriteBlobResponse* response) override;
  grpc::Status QueryWrite(grpc::ServerContext* context,
                          const v1::QueryWriteRequest* request,
                          v1::QueryWriteResponse* response) override;

 private:
  Coordinator& coordinator_;
  ManagedBlobStore& store_;
};

}  // namespace cohort
