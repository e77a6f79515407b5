#pragma once

#include <memory>
#include <string>

#include <grpcpp/channel.h>
#include <grpcpp/client_context.h>

#include "cohort/v1/worker_service.grpc.pb.h"
#include "common/base/mutex.h"
#include "worker/coordinator_link.h"

namespace cohort {

/// CoordinatorLink over WorkerService.
class GrpcCoordinatorLink final : public CoordinatorLink {
 public:
  GrpcCoordinatorLink(const std::shared_ptr<grpc::Channel>& channel, std::string peer);

  [[nodiscard]] absl::StatusOr<WorkerOrders> Synchronize(const WorkerReport& report) override;
  [[nodiscard]] absl::StatusOr<std::optional<WorkerOrders>> CompleteTask(
      const WorkerId& worker,
      const Lease& lease,
      const TaskResult& result,
      const std::optional<WorkerReport>& report) override;
  [[nodiscard]] absl::Status ReleaseTask(const WorkerId& worker, const Lease& lease) override;
  [[nodiscard]] absl::Status FailTask(const WorkerId& worker,
                                      const Lease& lease,
                                      const absl::Status& failure) override;
  void CancelSynchronize() override;

 private:
  std::string peer_;
  std::unique_ptr<v1::WorkerService::Stub> stub_;
  Mutex mutex_;
  grpc::ClientContext* waiting_ ABSL_GUARDED_BY(mutex_) = nullptr;  ///< Of the call under way.
  bool cancelled_ ABSL_GUARDED_BY(mutex_) = false;
};

}  // namespace cohort
