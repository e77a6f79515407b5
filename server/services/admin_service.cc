#include "server/services/admin_service.h"

#include "common/rpc/convert.h"
#include "common/rpc/grpc_status.h"

namespace cohort {

grpc::Status AdminServiceSkin::ListWorkers(grpc::ServerContext* /*context*/,
                                           const v1::ListWorkersRequest* /*request*/,
                                           v1::ListWorkersResponse* response) {
  for (const WorkerStatus& status : coordinator_.ListWorkers()) {
    *response->add_workers() = ToProto(status);
  }
  return grpc::Status::OK;
}

}  // namespace cohort
