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

grpc::Status AdminServiceSkin::CollectGarbage(grpc::ServerContext* /*context*/,
                                              const v1::CollectGarbageRequest* request,
                                              v1::CollectGarbageResponse* response) {
  GarbageOptions options = coordinator_.Options().garbage;
  if (request->has_age_hours()) {
    options.age_seconds = request->age_hours() * 3600;
  }
  if (request->has_remember_days()) {
    options.remember_seconds = request->remember_days() * 24 * 3600;
  }
  const absl::StatusOr<GarbageCount> count = coordinator_.CollectGarbage(options);
  if (!count.ok()) {
    return ToGrpcStatus(count.status());
  }
  response->set_blobs(count->blobs);
  response->set_bytes(count->bytes);
  response->set_kept_blobs(count->kept_blobs);
  response->set_kept_bytes(count->kept_bytes);
  return grpc::Status::OK;
}

}  // namespace cohort
