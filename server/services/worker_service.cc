#include "server/services/worker_service.h"

#include <algorithm>

#include "common/rpc/convert.h"
#include "common/rpc/grpc_status.h"
#include "common/store/blob_damage.h"

namespace cohort {
namespace {

constexpr double kMaxWaitSeconds = 20;

WorkerReport ReportFromProto(const v1::SynchronizeRequest& wire) {
  WorkerReport report;
  report.worker = WorkerId{wire.worker()};
  report.build = wire.build();
  for (const v1::HeldTask& held : wire.held()) {
    report.held.push_back(FromProto(held));
  }
  report.free_slots = wire.free_slots();
  report.spare_slots = wire.spare_slots();
  report.slots = wire.slots();
  report.instruction_set = wire.instruction_set();
  report.draining = wire.draining();
  report.wait_seconds = std::clamp(wire.wait_ms() / 1000.0, 0.0, kMaxWaitSeconds);
  return report;
}

void OrdersToProto(const WorkerOrders& orders, v1::SynchronizeResponse& wire) {
  for (const GrantedTask& granted : orders.grants) {
    auto* grant = wire.add_grants();
    *grant->mutable_lease() = ToProto(granted.lease);
    *grant->mutable_task() = ToProto(granted.task);
  }
  for (const Lease& lease : orders.lost) {
    *wire.add_lost() = ToProto(lease);
  }
  wire.set_next_sync_ms(static_cast<int>(orders.next_sync_seconds * 1000));
  wire.set_is_wedged(orders.is_wedged);
  wire.set_lease_ms(static_cast<int>(orders.lease_seconds * 1000));
}

}  // namespace

grpc::Status WorkerServiceSkin::Synchronize(grpc::ServerContext* context,
                                            const v1::SynchronizeRequest* request,
                                            v1::SynchronizeResponse* response) {
  const absl::StatusOr<WorkerOrders> orders = coordinator_.Synchronize(
      ReportFromProto(*request), [context] { return context->IsCancelled(); });
  if (!orders.ok()) {
    return ToGrpcStatus(orders.status());
  }
  OrdersToProto(*orders, *response);
  return grpc::Status::OK;
}

grpc::Status WorkerServiceSkin::CompleteTask(grpc::ServerContext* context,
                                             const v1::CompleteTaskRequest* request,
                                             v1::CompleteTaskResponse* response) {
  const absl::StatusOr<TaskResult> result = FromProto(request->result());
  if (!result.ok()) {
    return ToGrpcStatus(result.status());
  }
  const WorkerId worker{request->worker()};
  const Lease lease = FromProto(request->lease());
  if (!request->has_report()) {
    const absl::StatusOr<bool> taken = coordinator_.CompleteTask(worker, lease, *result);
    if (!taken.ok()) {
      return ToGrpcStatus(taken.status());
    }
    response->set_superseded(!*taken);
    return grpc::Status::OK;
  }
  const absl::StatusOr<CompletionAnswer> answer =
      coordinator_.CompleteTask(worker, lease, *result, ReportFromProto(request->report()),
                                [context] { return context->IsCancelled(); });
  if (!answer.ok()) {
    return ToGrpcStatus(answer.status());
  }
  response->set_superseded(!answer->taken);
  if (answer->orders) {
    OrdersToProto(*answer->orders, *response->mutable_orders());
  }
  return grpc::Status::OK;
}

grpc::Status WorkerServiceSkin::ReleaseTask(grpc::ServerContext* /*context*/,
                                            const v1::ReleaseTaskRequest* request,
                                            v1::ReleaseTaskResponse* /*response*/) {
  return ToGrpcStatus(
      coordinator_.ReleaseTask(WorkerId{request->worker()}, FromProto(request->lease())));
}

grpc::Status WorkerServiceSkin::FailTask(grpc::ServerContext* /*context*/,
                                         const v1::FailTaskRequest* request,
                                         v1::FailTaskResponse* /*response*/) {
  absl::Status failure(static_cast<absl::StatusCode>(request->code()), request->message());
  if (!request->blob_sha256().empty()) {
    const absl::StatusOr<Digest> blob = Digest::FromHex(request->blob_sha256());
    if (!blob.ok()) {
      return ToGrpcStatus(blob.status());
    }
    failure = WithUnreadableBlob(failure, *blob);
  }
  return ToGrpcStatus(
      coordinator_.FailTask(WorkerId{request->worker()}, FromProto(request->lease()), failure));
}

}  // namespace cohort
