#pragma once

#include "cohort/v1/result_service.grpc.pb.h"
#include "server/core/coordinator.h"

namespace cohort {

/// ResultService over the coordinator.
class ResultServiceSkin final : public v1::ResultService::Service {
 public:
  explicit ResultServiceSkin(Coordinator& coordinator) : coordinator_(coordinator) {}

  grpc::Status GetMatrix(grpc::ServerContext* context,
                         const v1::GetMatrixRequest* request,
                         grpc::ServerWriter<v1::GetMatrixResponse>* writer) override;
  grpc::Status GetPreview(grpc::ServerContext* context,
                          const v1::GetPreviewRequest* request,
                          grpc::ServerWriter<v1::GetPreviewResponse>* writer) override;
  grpc::Status ListJobMeshes(grpc::ServerContext* context,
                             const v1::ListJobMeshesRequest* request,
                             v1::ListJobMeshesResponse* response) override;
  grpc::Status GetOutputs(grpc::ServerContext* context,
                          const v1::GetOutputsRequest* request,
                          v1::GetOutputsResponse* response) override;

 private:
  Coordinator& coordinator_;
};

}  // namespace cohort
