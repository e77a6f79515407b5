#include "worker/grpc_coordinator_link.h"

#include <utility>

#include "common/base/status_macros.h"
#include "common/rpc/channel.h"
#include "common/rpc/convert.h"
#include "common/rpc/grpc_status.h"
#include "common/store/blob_damage.h"

namespace cohort {
namespace {

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
  request.set_worker(report.worker.value);
  request.set_build(report.build);
  for (const HeldTask& task : report.held) {
    *request.add_held() = ToProto(task);
  }
  request.set_free_slots(report.free_slots);
  request.set_spare_slots(report.spare_slots);
  request.set_slots(report.slots);
  request.set_instruction_set(report.instruction_set);
  request.set_draining(report.draining);
  request.set_wait_ms(static_cast<int>(report.wait_seconds * 1000));
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

absl::Status GrpcCoordinatorLink::CompleteTask(const WorkerId& worker,
                                               const Lease& lease,
                                               const TaskResult& result) {
  v1::CompleteTaskRequest request;
  request.set_worker(worker.value);
  *request.mutable_lease() = ToProto(lease);
  *request.mutable_result() = ToProto(result);
  v1::CompleteTaskResponse response;
  grpc::ClientContext context;
  SetDeadline(context, kUnaryDeadlineSeconds);
  return FromGrpcStatus(stub_->CompleteTask(&context, request, &response), peer_);
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
