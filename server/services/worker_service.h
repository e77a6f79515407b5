#pragma once

#include "cohort/v1/worker_service.grpc.pb.h"
#include "server/core/coordinator.h"

namespace cohort {

/// WorkerService over the coordinator.
class WorkerServiceSkin final : public v1::WorkerService::Service {
 public:
  explicit WorkerServiceSkin(Coordinator& coordinator) : coordinator_(coordinator) {}

  grpc::Status Synchronize(grpc::ServerContext* context,
                           const v1::SynchronizeRequest* request,
                           v1::SynchronizeResponse* response) override;
  grpc::Status CompleteTask(grpc::ServerContext* context,
                            const v1::CompleteTaskRequest* request,
                            v1::CompleteTaskResponse* response) override;
  grpc::Status ReleaseTask(grpc::ServerContext* context,
                           const v1::ReleaseTaskRequest* request,
                           v1::ReleaseTaskResponse* response) override;
  grpc::Status FailTask(grpc::ServerContext* context,
                        const v1::FailTaskRequest* request,
                        v1::FailTaskResponse* response) override;

 private:
  Coordinator& coordinator_;
};

}  // namespace cohort
