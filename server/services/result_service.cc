#include "server/services/result_service.h"

#include <algorithm>
#include <charconv>
#include <string>
#include <vector>

#include "common/base/status_macros.h"
#include "common/rpc/convert.h"
#include "common/rpc/convert_outputs.h"
#include "common/rpc/grpc_status.h"

namespace cohort {
namespace {

constexpr int kMaxPageSize = 1000;

absl::Status SendMatrix(Coordinator& coordinator,
                        const v1::GetMatrixRequest& request,
                        grpc::ServerWriter<v1::GetMatrixResponse>& writer) {
  COHORT_ASSIGN_OR_RETURN(const Metric metric, FromProto(request.metric()));
  return coordinator.GetMatrix(JobId{request.id()}, metric, [&](const MatrixBlock& block) {
    v1::GetMatrixResponse message;
    message.mutable_sources()->Add(block.sources.begin(), block.sources.end());
    message.mutable_targets()->Add(block.targets.begin(), block.targets.end());
    message.mutable_values()->Add(block.values.begin(), block.values.end());
    return writer.Write(message);
  });
}

absl::Status SendPreview(Coordinator& coordinator,
                         const v1::GetPreviewRequest& request,
                         grpc::ServerWriter<v1::GetPreviewResponse>& writer) {
  return coordinator.GetPreview(JobId{request.id()}, [&](const PreviewBlock& block) {
    v1::GetPreviewResponse message;
    message.mutable_rows()->Add(block.rows.begin(), block.rows.end());
    message.mutable_columns()->Add(block.columns.begin(), block.columns.end());
    message.mutable_values()->Add(block.values.begin(), block.values.end());
    return writer.Write(message);
  });
}

/// The token of a page of job meshes is the index of its first mesh.
absl::StatusOr<size_t> FirstIndex(const std::string& token) {
  size_t first = 0;
  const char* end = token.data() + token.size();
  const auto parsed = std::from_chars(token.data(), end, first);
  if (!token.empty() && (parsed.ec != std::errc() || parsed.ptr != end)) {
    return absl::InvalidArgumentError("page_token '" + token + "' is not one of this listing");
  }
  return first;
}

absl::Status ListPage(Coordinator& coordinator,
                      const v1::ListJobMeshesRequest& request,
                      v1::ListJobMeshesResponse& response) {
  if (request.page_size() < 0) {
    return absl::InvalidArgumentError("page_size must not be < 0");
  }
  COHORT_ASSIGN_OR_RETURN(const size_t first, FirstIndex(request.page_token()));
  COHORT_ASSIGN_OR_RETURN(const std::vector<JobMesh> meshes,
                          coordinator.GetJobMeshes(JobId{request.id()}));
  const int size =
      request.page_size() == 0 ? kMaxPageSize : std::min(request.page_size(), kMaxPageSize);
  const size_t last = std::min(meshes.size(), first + static_cast<size_t>(size));
  for (size_t i = first; i < last; ++i) {
    *response.add_meshes() = ToProto(meshes[i]);
  }
  if (last < meshes.size()) {
    response.set_next_page_token(std::to_string(last));
  }
  return absl::OkStatus();
}

}  // namespace

grpc::Status ResultServiceSkin::GetMatrix(grpc::ServerContext* /*context*/,
                                          const v1::GetMatrixRequest* request,
                                          grpc::ServerWriter<v1::GetMatrixResponse>* writer) {
  return ToGrpcStatus(SendMatrix(coordinator_, *request, *writer));
}

grpc::Status ResultServiceSkin::GetPreview(grpc::ServerContext* /*context*/,
                                           const v1::GetPreviewRequest* request,
                                           grpc::ServerWriter<v1::GetPreviewResponse>* writer) {
  return ToGrpcStatus(SendPreview(coordinator_, *request, *writer));
}

grpc::Status ResultServiceSkin::ListJobMeshes(grpc::ServerContext* /*context*/,
                                              const v1::ListJobMeshesRequest* request,
                                              v1::ListJobMeshesResponse* response) {
  return ToGrpcStatus(ListPage(coordinator_, *request, *response));
}

grpc::Status ResultServiceSkin::GetOutputs(grpc::ServerContext* /*context*/,
                                           const v1::GetOutputsRequest* request,
                                           v1::GetOutputsResponse* response) {
  const absl::StatusOr<JobOutputs> outputs = coordinator_.GetOutputs(JobId{request->id()});
  if (!outputs.ok()) {
    return ToGrpcStatus(outputs.status());
  }
  *response = ToProto(*outputs);
  return grpc::Status::OK;
}

}  // namespace cohort
