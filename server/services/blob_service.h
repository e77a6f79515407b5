#pragma once

#include "cohort/v1/blob_service.grpc.pb.h"
#include "common/store/blob_store.h"

namespace cohort {

/// BlobService over the store, piece by piece.
class BlobServiceSkin final : public v1::BlobService::Service {
 public:
  explicit BlobServiceSkin(BlobStore& store) : store_(store) {}

  grpc::Status StatBlob(grpc::ServerContext* context,
                        const v1::StatBlobRequest* request,
                        v1::StatBlobResponse* response) override;
  grpc::Status ReadBlob(grpc::ServerContext* context,
                        const v1::ReadBlobRequest* request,
                        grpc::ServerWriter<v1::ReadBlobResponse>* writer) override;
  grpc::Status WriteBlob(grpc::ServerContext* context,
                         grpc::ServerReader<v1::WriteBlobRequest>* reader,
                         v1::WriteBlobResponse* response) override;

 private:
  BlobStore& store_;
};

}  // namespace cohort
