#include "client/session.h"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <limits>
#include <thread>
#include <utility>

#include "common/base/status_macros.h"
#include "common/rpc/channel.h"
#include "common/rpc/convert.h"
#include "common/rpc/convert_outputs.h"
#include "common/rpc/grpc_status.h"

namespace cohort {
namespace {

constexpr double kUploadDeadlineSeconds = 3600;
constexpr double kStreamDeadlineSeconds = 600;
constexpr std::chrono::seconds kPatience(60);
constexpr int kPageSize = 1000;
constexpr size_t kDigestsPerCall = 1000;

}  // namespace

Session::Session(std::shared_ptr<grpc::Channel> channel, const std::string& address)
    : address_(address),
      channel_(std::move(channel)),
      meshes_(v1::MeshService::NewStub(channel_)),
      jobs_(v1::JobService::NewStub(channel_)),
      results_(v1::ResultService::NewStub(channel_)),
      admin_(v1::AdminService::NewStub(channel_)),
      blobs_(channel_, address) {}

absl::StatusOr<std::unique_ptr<Session>> Session::Open(const std::string& address) {
  COHORT_ASSIGN_OR_RETURN(const std::string normalized, NormalizeAddress(address));
  return std::unique_ptr<Session>(new Session(OpenChannel(normalized), normalized));
}

absl::Status Session::WaitUntilReady(double seconds) {
  const auto deadline = std::chrono::system_clock::now() +
                        std::chrono::milliseconds(static_cast<int64_t>(seconds * 1000));
  return channel_->WaitForConnected(deadline)
             ? absl::OkStatus()
             : absl::UnavailableError("no server answers at " + address_);
}

absl::StatusOr<std::vector<Digest>> Session::FindMissing(const std::vector<Digest>& digests) {
  std::vector<Digest> missing;
  for (size_t first = 0; first < digests.size(); first += kDigestsPerCall) {
    v1::FindMissingRequest request;
    for (size_t i = first; i < std::min(digests.size(), first + kDigestsPerCall); ++i) {
      request.add_sha256(digests[i].Hex());
    }
    v1::FindMissingResponse response;
    grpc::ClientContext context;
    SetDeadline(context, kUnaryDeadlineSeconds);
    COHORT_RETURN_IF_ERROR(
        FromGrpcStatus(meshes_->FindMissing(&context, request, &response), address_));
    for (const std::string& hex : response.sha256()) {
      COHORT_ASSIGN_OR_RETURN(Digest digest, Digest::FromHex(hex));
      missing.push_back(std::move(digest));
    }
  }
  return missing;
}

absl::Status Session::AddMesh(const std::string& set,
                              const SetMesh& mesh,
                              const std::string& path) {
  grpc::ClientContext context;
  SetDeadline(context, kUploadDeadlineSeconds);
  v1::AddMeshResponse response;
  const auto writer = meshes_->AddMesh(&context, &response);
  v1::AddMeshRequest message;
  message.mutable_header()->set_set(set);
  *message.mutable_header()->mutable_mesh() = ToProto(mesh);
  bool open = writer->Write(message);
  if (!path.empty()) {
    std::ifstream file(path, std::ios::binary);
    std::string chunk(static_cast<size_t>(kChunkBytes), '\0');
    bool first = true;
    while (open && file) {
      file.read(chunk.data(), static_cast<std::streamsize>(chunk.size()));
      if (file.gcount() == 0 && !first) {
        break;
      }
      message.set_chunk(chunk.substr(0, static_cast<size_t>(file.gcount())));
      open = writer->Write(message);
      first = false;
    }
    if (file.bad()) {
      context.TryCancel();
    }
  }
  writer->WritesDone();
  return FromGrpcStatus(writer->Finish(), address_);
}

absl::StatusOr<std::vector<SetMesh>> Session::ListMeshes(const std::string& set) {
  std::vector<SetMesh> meshes;
  v1::ListMeshesRequest request;
  request.set_set(set);
  request.set_page_size(kPageSize);
  do {
    v1::ListMeshesResponse response;
    grpc::ClientContext context;
    SetDeadline(context, kUnaryDeadlineSeconds);
    COHORT_RETURN_IF_ERROR(
        FromGrpcStatus(meshes_->ListMeshes(&context, request, &response), address_));
    for (const v1::SetMesh& wire : response.meshes()) {
      COHORT_ASSIGN_OR_RETURN(SetMesh mesh, FromProto(wire));
      meshes.push_back(std::move(mesh));
    }
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty());
  return meshes;
}

absl::StatusOr<Job> Session::CreateJob(const std::string& set,
                                       const JobSpec& spec,
                                       const std::string& request_id) {
  v1::CreateJobRequest request;
  request.set_set(set);
  *request.mutable_spec() = ToProto(spec);
  request.set_request_id(request_id);
  v1::CreateJobResponse response;
  grpc::ClientContext context;
  SetDeadline(context, kUnaryDeadlineSeconds);
  COHORT_RETURN_IF_ERROR(FromGrpcStatus(jobs_->CreateJob(&context, request, &response), address_));
  return FromProto(response.job());
}

absl::StatusOr<Job> Session::GetJob(const JobId& id) {
  v1::GetJobRequest request;
  request.set_id(id.value);
  v1::GetJobResponse response;
  grpc::ClientContext context;
  SetDeadline(context, kUnaryDeadlineSeconds);
  COHORT_RETURN_IF_ERROR(FromGrpcStatus(jobs_->GetJob(&context, request, &response), address_));
  return FromProto(response.job());
}

absl::StatusOr<std::vector<Job>> Session::ListJobs(int limit) {
  std::vector<Job> jobs;
  v1::ListJobsRequest request;
  do {
    request.set_page_size(std::min(kPageSize, limit - static_cast<int>(jobs.size())));
    v1::ListJobsResponse response;
    grpc::ClientContext context;
    SetDeadline(context, kUnaryDeadlineSeconds);
    COHORT_RETURN_IF_ERROR(FromGrpcStatus(jobs_->ListJobs(&context, request, &response), address_));
    for (const v1::Job& wire : response.jobs()) {
      COHORT_ASSIGN_OR_RETURN(Job job, FromProto(wire));
      jobs.push_back(std::move(job));
    }
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty() && std::ssize(jobs) < limit);
  return jobs;
}

absl::Status Session::WatchOnce(const JobId& id,
                                const std::function<bool(const Job&)>& on_change,
                                Job& last,
                                bool& wanted) {
  v1::WatchJobRequest request;
  request.set_id(id.value);
  request.set_since_version(last.version);
  grpc::ClientContext context;
  SetDeadline(context, kStreamDeadlineSeconds);
  const auto reader = jobs_->WatchJob(&context, request);
  v1::WatchJobResponse message;
  while (wanted && reader->Read(&message)) {
    COHORT_ASSIGN_OR_RETURN(last, FromProto(message.job()));
    wanted = on_change(last);
  }
  if (!wanted) {
    context.TryCancel();
  }
  const grpc::Status status = reader->Finish();
  return wanted ? FromGrpcStatus(status, address_) : absl::OkStatus();
}

absl::StatusOr<Job> Session::WatchJob(const JobId& id,
                                      const std::function<bool(const Job&)>& on_change) {
  Job last;
  bool wanted = true;
  auto last_heard = std::chrono::steady_clock::now();
  while (true) {
    const int64_t version = last.version;
    const absl::Status status = WatchOnce(id, on_change, last, wanted);
    if (!wanted || (status.ok() && IsFinal(last.state))) {
      return last;
    }
    const auto now = std::chrono::steady_clock::now();
    const bool quiet = status.code() == absl::StatusCode::kDeadlineExceeded;
    if (last.version > version || quiet) {
      last_heard = now;
    }
    const bool transient = status.ok() || quiet || status.code() == absl::StatusCode::kUnavailable;
    if (!transient || now - last_heard > kPatience ||
        (version == 0 && last.version == 0 && !quiet)) {
      return status.ok() ? absl::UnavailableError("the server ended the stream") : status;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
  }
}

absl::StatusOr<std::vector<JobMesh>> Session::ListJobMeshes(const JobId& id) {
  std::vector<JobMesh> meshes;
  v1::ListJobMeshesRequest request;
  request.set_id(id.value);
  request.set_page_size(kPageSize);
  do {
    v1::ListJobMeshesResponse response;
    grpc::ClientContext context;
    SetDeadline(context, kUnaryDeadlineSeconds);
    COHORT_RETURN_IF_ERROR(
        FromGrpcStatus(results_->ListJobMeshes(&context, request, &response), address_));
    for (const v1::JobMesh& wire : response.meshes()) {
      COHORT_ASSIGN_OR_RETURN(JobMesh mesh, FromProto(wire));
      meshes.push_back(std::move(mesh));
    }
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty());
  return meshes;
}

absl::StatusOr<JobOutputs> Session::GetOutputs(const JobId& id) {
  v1::GetOutputsRequest request;
  request.set_id(id.value);
  v1::GetOutputsResponse response;
  grpc::ClientContext context;
  SetDeadline(context, kUnaryDeadlineSeconds);
  COHORT_RETURN_IF_ERROR(
      FromGrpcStatus(results_->GetOutputs(&context, request, &response), address_));
  return FromProto(response);
}

namespace {

/// Hands on the values of a block of the stream.
/// @return kDataLoss if they do not fit it.
template <typename Indices, typename Values>
absl::Status TakeBlock(const JobId& id,
                       const Indices& rows,
                       const Indices& columns,
                       const Values& values,
                       const MatrixTaker& take) {
  const auto is_negative = [](int32_t index) { return index < 0; };
  if (int64_t{rows.size()} * columns.size() != values.size() ||
      std::any_of(rows.begin(), rows.end(), is_negative) ||
      std::any_of(columns.begin(), columns.end(), is_negative)) {
    return absl::DataLossError("job " + id.value + ": the server sent a broken matrix block");
  }
  return take({.rows = {rows.data(), static_cast<size_t>(rows.size())},
               .columns = {columns.data(), static_cast<size_t>(columns.size())},
               .values = {values.data(), static_cast<size_t>(values.size())}});
}

}  // namespace

absl::Status Session::SendBlob(const std::string& bytes) {
  COHORT_ASSIGN_OR_RETURN(const bool exists, blobs_.Contains(Sha256::Of(bytes)));
  return exists ? absl::OkStatus() : blobs_.Put(bytes).status();
}

absl::Status Session::ReadMatrix(const JobId& id, Metric metric, const MatrixTaker& take) {
  v1::GetMatrixRequest request;
  request.set_id(id.value);
  request.set_metric(ToProto(metric));
  grpc::ClientContext context;
  SetDeadline(context, kStreamDeadlineSeconds);
  const auto reader = results_->GetMatrix(&context, request);
  v1::GetMatrixResponse block;
  while (reader->Read(&block)) {
    if (absl::Status status = TakeBlock(id, block.sources(), block.targets(), block.values(), take);
        !status.ok()) {
      context.TryCancel();
      return status;
    }
  }
  return FromGrpcStatus(reader->Finish(), address_);
}

absl::Status Session::ReadPreview(const JobId& id, const MatrixTaker& take) {
  v1::GetPreviewRequest request;
  request.set_id(id.value);
  grpc::ClientContext context;
  SetDeadline(context, kStreamDeadlineSeconds);
  const auto reader = results_->GetPreview(&context, request);
  v1::GetPreviewResponse block;
  while (reader->Read(&block)) {
    if (absl::Status status = TakeBlock(id, block.rows(), block.columns(), block.values(), take);
        !status.ok()) {
      context.TryCancel();
      return status;
    }
  }
  return FromGrpcStatus(reader->Finish(), address_);
}

}  // namespace cohort
