#pragma once

#include "cohort/v1/job_service.grpc.pb.h"
#include "server/core/coordinator.h"
#include "server/services/job_watch_hub.h"

namespace cohort {

/// JobService over the coordinator. Unary calls use gRPC's threads; WatchJob holds none.
class JobServiceSkin final
    : public v1::JobService::WithCallbackMethod_WatchJob<v1::JobService::Service> {
 public:
  JobServiceSkin(Coordinator& coordinator, JobWatchHub& hub)
      : coordinator_(coordinator), hub_(hub) {}

  grpc::Status CreateJob(grpc::ServerContext* context,
                         const v1::CreateJobRequest* request,
                         v1::CreateJobResponse* response) override;
  grpc::Status EstimateJob(grpc::ServerContext* context,
                           const v1::EstimateJobRequest* request,
                           v1::EstimateJobResponse* response) override;
  grpc::Status GetJob(grpc::ServerContext* context,
                      const v1::GetJobRequest* request,
                      v1::GetJobResponse* response) override;
  grpc::Status ListJobs(grpc::ServerContext* context,
                        const v1::ListJobsRequest* request,
                        v1::ListJobsResponse* response) override;
  grpc::Status CancelJob(grpc::ServerContext* context,
                         const v1::CancelJobRequest* request,
                         v1::CancelJobResponse* response) override;
  grpc::Status PauseJob(grpc::ServerContext* context,
                        const v1::PauseJobRequest* request,
                        v1::PauseJobResponse* response) override;
  grpc::Status ResumeJob(grpc::ServerContext* context,
                         const v1::ResumeJobRequest* request,
                         v1::ResumeJobResponse* response) override;
  grpc::Status RetryJob(grpc::ServerContext* context,
                        const v1::RetryJobRequest* request,
                        v1::RetryJobResponse* response) override;
  grpc::Status DeleteJob(grpc::ServerContext* context,
                         const v1::DeleteJobRequest* request,
                         v1::DeleteJobResponse* response) override;
  grpc::ServerWriteReactor<v1::WatchJobResponse>* WatchJob(
      grpc::CallbackServerContext* context, const v1::WatchJobRequest* request) override;

 private:
  Coordinator& coordinator_;
  JobWatchHub& hub_;
};

}  // namespace cohort
