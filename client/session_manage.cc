// The calls that change a job on its way, what a set holds, or look after the server.
#include "client/session.h"
#include "common/base/status_macros.h"
#include "common/rpc/channel.h"
#include "common/rpc/convert.h"
#include "common/rpc/convert_estimate.h"
#include "common/rpc/grpc_status.h"

namespace cohort {
namespace {

/// Of millions of blobs.
constexpr double kCollectionDeadlineSeconds = 3600;

/// One unary call with the usual deadline.
template <typename Request, typename Response, typename Stub>
absl::StatusOr<Response> Call(Stub& stub,
                              grpc::Status (Stub::*method)(grpc::ClientContext*,
                                                           const Request&,
                                                           Response*),
                              const Request& request,
                              const std::string& address) {
  grpc::ClientContext context;
  SetDeadline(context, kUnaryDeadlineSeconds);
  Response response;
  COHORT_RETURN_IF_ERROR(FromGrpcStatus((stub.*method)(&context, request, &response), address));
  return response;
}

}  // namespace

absl::StatusOr<Estimate> Session::EstimateJob(const std::string& set, const JobSpec& spec) {
  v1::EstimateJobRequest request;
  request.set_set(set);
  *request.mutable_spec() = ToProto(spec);
  COHORT_ASSIGN_OR_RETURN(const auto response,
                          Call(*jobs_, &v1::JobService::Stub::EstimateJob, request, address_));
  return FromProto(response.estimate());
}

absl::StatusOr<Job> Session::CancelJob(const JobId& id) {
  v1::CancelJobRequest request;
  request.set_id(id.value);
  COHORT_ASSIGN_OR_RETURN(const auto response,
                          Call(*jobs_, &v1::JobService::Stub::CancelJob, request, address_));
  return FromProto(response.job());
}

absl::StatusOr<Job> Session::PauseJob(const JobId& id) {
  v1::PauseJobRequest request;
  request.set_id(id.value);
  COHORT_ASSIGN_OR_RETURN(const auto response,
                          Call(*jobs_, &v1::JobService::Stub::PauseJob, request, address_));
  return FromProto(response.job());
}

absl::StatusOr<Job> Session::ResumeJob(const JobId& id) {
  v1::ResumeJobRequest request;
  request.set_id(id.value);
  COHORT_ASSIGN_OR_RETURN(const auto response,
                          Call(*jobs_, &v1::JobService::Stub::ResumeJob, request, address_));
  return FromProto(response.job());
}

absl::StatusOr<Job> Session::RetryJob(const JobId& id) {
  v1::RetryJobRequest request;
  request.set_id(id.value);
  COHORT_ASSIGN_OR_RETURN(const auto response,
                          Call(*jobs_, &v1::JobService::Stub::RetryJob, request, address_));
  return FromProto(response.job());
}

absl::Status Session::DeleteJob(const JobId& id) {
  v1::DeleteJobRequest request;
  request.set_id(id.value);
  return Call(*jobs_, &v1::JobService::Stub::DeleteJob, request, address_).status();
}

absl::Status Session::RemoveMesh(const std::string& set, const std::string& name) {
  v1::RemoveMeshRequest request;
  request.set_set(set);
  request.set_name(name);
  return Call(*meshes_, &v1::MeshService::Stub::RemoveMesh, request, address_).status();
}

absl::Status Session::DeleteSet(const std::string& set) {
  v1::DeleteSetRequest request;
  request.set_set(set);
  return Call(*meshes_, &v1::MeshService::Stub::DeleteSet, request, address_).status();
}

absl::StatusOr<std::vector<WorkerStatus>> Session::ListWorkers() {
  COHORT_ASSIGN_OR_RETURN(const auto response, Call(*admin_, &v1::AdminService::Stub::ListWorkers,
                                                    v1::ListWorkersRequest(), address_));
  std::vector<WorkerStatus> workers;
  workers.reserve(static_cast<size_t>(response.workers_size()));
  for (const v1::Worker& worker : response.workers()) {
    workers.push_back(FromProto(worker));
  }
  return workers;
}

absl::StatusOr<v1::CollectGarbageResponse> Session::CollectGarbage(
    std::optional<double> age_hours, std::optional<double> remember_days) {
  v1::CollectGarbageRequest request;
  if (age_hours) {
    request.set_age_hours(*age_hours);
  }
  if (remember_days) {
    request.set_remember_days(*remember_days);
  }
  grpc::ClientContext context;
  SetDeadline(context, kCollectionDeadlineSeconds);
  v1::CollectGarbageResponse response;
  COHORT_RETURN_IF_ERROR(
      FromGrpcStatus(admin_->CollectGarbage(&context, request, &response), address_));
  return response;
}

}  // namespace cohort
