#include "server/services/job_service.h"

#include "common/rpc/convert.h"
#include "common/rpc/convert_estimate.h"
#include "common/rpc/grpc_status.h"

namespace cohort {
namespace {

/// A stream that ends at once with an error.
class FailedWatch final : public grpc::ServerWriteReactor<v1::WatchJobResponse> {
 public:
  explicit FailedWatch(const grpc::Status& status) { Finish(status); }
  void OnDone() override { delete this; }
};

template <typename Response>
grpc::Status Answer(const absl::StatusOr<Job>& job, Response* response) {
  if (!job.ok()) {
    return ToGrpcStatus(job.status());
  }
  *response->mutable_job() = ToProto(*job);
  return grpc::Status::OK;
}

}  // namespace

grpc::Status JobServiceSkin::CreateJob(grpc::ServerContext* /*context*/,
                                       const v1::CreateJobRequest* request,
                                       v1::CreateJobResponse* response) {
  const absl::StatusOr<JobSpec> spec = FromProto(request->spec());
  if (!spec.ok()) {
    return ToGrpcStatus(spec.status());
  }
  return Answer(coordinator_.CreateJob(request->set(), *spec, request->request_id()), response);
}

grpc::Status JobServiceSkin::EstimateJob(grpc::ServerContext* /*context*/,
                                         const v1::EstimateJobRequest* request,
                                         v1::EstimateJobResponse* response) {
  const absl::StatusOr<JobSpec> spec = FromProto(request->spec());
  if (!spec.ok()) {
    return ToGrpcStatus(spec.status());
  }
  const absl::StatusOr<Estimate> estimate = coordinator_.EstimateJob(request->set(), *spec);
  if (!estimate.ok()) {
    return ToGrpcStatus(estimate.status());
  }
  *response->mutable_estimate() = ToProto(*estimate);
  return grpc::Status::OK;
}

grpc::Status JobServiceSkin::GetJob(grpc::ServerContext* /*context*/,
                                    const v1::GetJobRequest* request,
                                    v1::GetJobResponse* response) {
  return Answer(coordinator_.GetJob(JobId{request->id()}), response);
}

grpc::Status JobServiceSkin::ListJobs(grpc::ServerContext* /*context*/,
                                      const v1::ListJobsRequest* request,
                                      v1::ListJobsResponse* response) {
  const absl::StatusOr<Page<Job>> page =
      coordinator_.ListJobs(request->page_size(), request->page_token());
  if (!page.ok()) {
    return ToGrpcStatus(page.status());
  }
  for (const Job& job : page->items) {
    *response->add_jobs() = ToProto(job);
  }
  response->set_next_page_token(page->next_token);
  return grpc::Status::OK;
}

grpc::Status JobServiceSkin::CancelJob(grpc::ServerContext* /*context*/,
                                       const v1::CancelJobRequest* request,
                                       v1::CancelJobResponse* response) {
  return Answer(coordinator_.CancelJob(JobId{request->id()}), response);
}

grpc::Status JobServiceSkin::PauseJob(grpc::ServerContext* /*context*/,
                                      const v1::PauseJobRequest* request,
                                      v1::PauseJobResponse* response) {
  return Answer(coordinator_.PauseJob(JobId{request->id()}), response);
}

grpc::Status JobServiceSkin::ResumeJob(grpc::ServerContext* /*context*/,
                                       const v1::ResumeJobRequest* request,
                                       v1::ResumeJobResponse* response) {
  return Answer(coordinator_.ResumeJob(JobId{request->id()}), response);
}

grpc::Status JobServiceSkin::RetryJob(grpc::ServerContext* /*context*/,
                                      const v1::RetryJobRequest* request,
                                      v1::RetryJobResponse* response) {
  return Answer(coordinator_.RetryJob(JobId{request->id()}), response);
}

grpc::Status JobServiceSkin::DeleteJob(grpc::ServerContext* /*context*/,
                                       const v1::DeleteJobRequest* request,
                                       v1::DeleteJobResponse* /*response*/) {
  return ToGrpcStatus(coordinator_.DeleteJob(JobId{request->id()}));
}

grpc::ServerWriteReactor<v1::WatchJobResponse>* JobServiceSkin::WatchJob(
    grpc::CallbackServerContext* /*context*/, const v1::WatchJobRequest* request) {
  const absl::StatusOr<Job> job = coordinator_.GetJob(JobId{request->id()});
  if (!job.ok()) {
    return new FailedWatch(ToGrpcStatus(job.status()));
  }
  return hub_.Watch(*job, request->since_version());
}

}  // namespace cohort
