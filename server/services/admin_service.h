#pragma once

#include "cohort/v1/admin_service.grpc.pb.h"
#include "server/core/coordinator.h"

namespace cohort {

/// AdminService over the coordinator.
class AdminServiceSkin final : public v1::AdminService::Service {
 public:
  explicit AdminServiceSkin(Coordinator& coordinator) : coordinator_(coordinator) {}

  grpc::Status ListWorkers(grpc::ServerContext* context,
                           const v1::ListWorkersRequest* request,
                           v1::ListWorkersResponse* response) override;
  grpc::Status CollectGarbage(grpc::ServerContext* context,
                              const v1::CollectGarbageRequest* request,
                              v1::CollectGarbageResponse* response) override;

 private:
  Coordinator& coordinator_;
};

}  // namespace cohort
