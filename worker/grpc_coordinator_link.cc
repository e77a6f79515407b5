#include "worker/grpc_coordinator_link.h"

#include <utility>

#include "common/base/status_macros.h"
#include "common/rpc/channel.h"
#include "common/rpc/convert.h"
#include "common/rpc/grpc_status.h"
#include "common/store/blob_damage.h"

namespace cohort {
namespace {

void ReportToProto(const WorkerReport& report, v1::SynchronizeRequest& wire) {
  wire.set_worker(report.worker.value);
  wire.set_build(report.build);
  for (const HeldTask& task : report.held) {
    *wire.add_held() = ToProto(task);
  }
  wire.set_free_slots(report.free_slots);
  wire.set_spare_slots(report.spare_slots);
  wire.set_slots(report.slots);
  wire.set_instruction_set(report.instruction_set);
  wire.set_draining(report.draining);
  wire.set_wait_ms(static_cast<int>(report.wait_seconds * 1000));
}

absl::StatusOr<WorkerOrders> OrdersFromProto(const v1::SynchronizeResponse& wire) {
  WorkerOrders orders;
  for (const auto& grant : wire.grants()) {
    COHORT_ASSIGN_OR_RETURN(Task task, FromProto(grant.task()));
    orders.grants.push_back({.lease = FromProto(grant.lease()), .task = std::move(task)});
  }
  for (const v1::Lease& lease : wire.lost()) {
    orders.lost.push_back(FromProto(lease));
  }
  orders.next_sync_seconds = wire.next_sync_ms() / 1000.0;
  orders.lease_seconds = wire.lease_ms() / 1000.0;
  orders.is_wedged = wire.is_wedged();
  return orders;
}

}  // namespace

GrpcCoordinatorLink::GrpcCoordinatorLink(const std::shared_ptr<grpc::Channel>& channel,
                                         std::string peer)
    : peer_(std::move(peer)), stub_(v1::WorkerService::NewStub(channel)) {}

absl::StatusOr<WorkerOrders> GrpcCoordinatorLink::Synchronize(const WorkerReport& report) {
  v1::SynchronizeRequest request;
  ReportToProto(report, request);
  grpc::ClientContext context;
  SetDeadline(context, kUnaryDeadlineSeconds + report.wait_seconds);
  {
    MutexLock lock(mutex_);
    if (cancelled_) {
      return absl::CancelledError("the worker is stopping");
    }
    waiting_ = &context;
  }
  v1::SynchronizeResponse response;
  const grpc::Status status = stub_->Synchronize(&context, request, &response);
  {
    MutexLock lock(mutex_);
    waiting_ = nullptr;
  }
  COHORT_RETURN_IF_ERROR(FromGrpcStatus(status, peer_));
  return OrdersFromProto(response);
}

absl::StatusOr<std::optional<WorkerOrders>> GrpcCoordinatorLink::CompleteTask(
    const WorkerId& worker,
    const Lease& lease,
    const TaskResult& result,
    const std::optional<WorkerReport>& report) {
  v1::CompleteTaskRequest request;
  request.set_worker(worker.value);
  *request.mutable_lease() = ToProto(lease);
  *request.mutable_result() = ToProto(result);
  if (report) {
    ReportToProto(*report, *request.mutable_report());
  }
  v1::CompleteTaskResponse response;
  grpc::ClientContext context;
  SetDeadline(context, kUnaryDeadlineSeconds);
  COHORT_RETURN_IF_ERROR(FromGrpcStatus(stub_->CompleteTask(&context, request, &response), peer_));
  std::optional<WorkerOrders> orders;
  if (response.has_orders()) {
    COHORT_ASSIGN_OR_RETURN(orders, OrdersFromProto(response.orders()));
  }
  return orders;
}

absl::Status GrpcCoordinatorLink::ReleaseTask(const WorkerId& worker, const Lease& lease) {
  v1::ReleaseTaskRequest request;
  request.set_worker(worker.value);
  *request.mutable_lease() = ToProto(lease);
  v1::ReleaseTaskResponse response;
  grpc::ClientContext context;
  SetDeadline(context, kUnaryDeadlineSeconds);
  return FromGrpcStatus(stub_->ReleaseTask(&context, request, &response), peer_);
}

absl::Status GrpcCoordinatorLink::FailTask(const WorkerId& worker,
                                           const Lease& lease,
                                           const absl::Status& failure) {
  v1::FailTaskRequest request;
  request.set_worker(worker.value);
  *request.mutable_lease() = ToProto(lease);
  request.set_code(static_cast<int>(failure.code()));
  request.set_message(std::string(failure.message()));
  if (const std::optional<Digest> blob = UnreadableBlob(failure)) {
    request.set_blob_sha256(blob->Hex());
  }
  v1::FailTaskResponse response;
  grpc::ClientContext context;
  SetDeadline(context, kUnaryDeadlineSeconds);
  return FromGrpcStatus(stub_->FailTask(&context, request, &response), peer_);
}

void GrpcCoordinatorLink::CancelSynchronize() {
  MutexLock lock(mutex_);
  cancelled_ = true;
  if (waiting_ != nullptr) {
    waiting_->TryCancel();
  }
}

}  // namespace cohort
