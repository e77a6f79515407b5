#include "server/services/mesh_service.h"

#include <memory>
#include <string>
#include <vector>

#include "common/base/error_reason.h"
#include "common/base/status_macros.h"
#include "common/rpc/convert.h"
#include "common/rpc/grpc_status.h"

namespace cohort {
namespace {

constexpr int kMaxDigestsPerCall = 10'000;

}  // namespace

grpc::Status MeshServiceSkin::FindMissing(grpc::ServerContext* /*context*/,
                                          const v1::FindMissingRequest* request,
                                          v1::FindMissingResponse* response) {
  if (request->sha256_size() > kMaxDigestsPerCall) {
    return ToGrpcStatus(absl::InvalidArgumentError(
        "sha256: at most " + std::to_string(kMaxDigestsPerCall) + " per call"));
  }
  std::vector<Digest> digests;
  digests.reserve(static_cast<size_t>(request->sha256_size()));
  for (const std::string& hex : request->sha256()) {
    const absl::StatusOr<Digest> digest = Digest::FromHex(hex);
    if (!digest.ok()) {
      return ToGrpcStatus(digest.status());
    }
    digests.push_back(*digest);
  }
  const absl::StatusOr<std::vector<Digest>> missing = coordinator_.FindMissing(digests);
  if (!missing.ok()) {
    return ToGrpcStatus(missing.status());
  }
  for (const Digest& digest : *missing) {
    response->add_sha256(digest.Hex());
  }
  return grpc::Status::OK;
}

grpc::Status MeshServiceSkin::AddMesh(grpc::ServerContext* /*context*/,
                                      grpc::ServerReader<v1::AddMeshRequest>* reader,
                                      v1::AddMeshResponse* response) {
  v1::AddMeshRequest message;
  if (!reader->Read(&message) || !message.has_header()) {
    return ToGrpcStatus(absl::InvalidArgumentError("AddMesh: the first message must be a header"));
  }
  const std::string set = message.header().set();
  const absl::StatusOr<SetMesh> mesh = FromProto(message.header().mesh());
  if (!mesh.ok()) {
    return ToGrpcStatus(mesh.status());
  }
  if (reader->Read(&message)) {
    const absl::Status received = ReceiveBytes(message, *reader, *mesh);
    if (!received.ok()) {
      return ToGrpcStatus(received);
    }
  }
  const absl::StatusOr<SetMesh> added = coordinator_.AddMesh(set, *mesh);
  if (!added.ok()) {
    return ToGrpcStatus(added.status());
  }
  *response->mutable_mesh() = ToProto(*added);
  return grpc::Status::OK;
}

absl::Status MeshServiceSkin::ReceiveBytes(const v1::AddMeshRequest& first,
                                           grpc::ServerReader<v1::AddMeshRequest>& reader,
                                           const SetMesh& mesh) {
  COHORT_RETURN_IF_ERROR(coordinator_.CheckSpace());
  COHORT_ASSIGN_OR_RETURN(std::unique_ptr<BlobWriter> writer, coordinator_.Store().StartPut());
  v1::AddMeshRequest message = first;
  int64_t received = 0;
  do {
    received += static_cast<int64_t>(message.chunk().size());
    if (received > mesh.size_bytes) {
      break;  // Reported below.
    }
    COHORT_RETURN_IF_ERROR(writer->Append(message.chunk()));
  } while (reader.Read(&message));
  if (received != mesh.size_bytes) {
    return WithReason(absl::DataLossError("mesh " + mesh.name + ": " + std::to_string(received) +
                                          " bytes arrived, " + std::to_string(mesh.size_bytes) +
                                          " were announced; send it again"),
                      "UPLOAD_INCOMPLETE");
  }
  COHORT_ASSIGN_OR_RETURN(const Digest digest, writer->Commit());
  if (digest != mesh.raw) {
    return WithReason(absl::DataLossError("mesh " + mesh.name + ": the bytes have SHA-256 " +
                                          digest.Hex() + ", announced was " + mesh.raw.Hex()),
                      "UPLOAD_DAMAGED");
  }
  return absl::OkStatus();
}

grpc::Status MeshServiceSkin::ListMeshes(grpc::ServerContext* /*context*/,
                                         const v1::ListMeshesRequest* request,
                                         v1::ListMeshesResponse* response) {
  const absl::StatusOr<Page<SetMesh>> page =
      coordinator_.ListMeshes(request->set(), request->page_size(), request->page_token());
  if (!page.ok()) {
    return ToGrpcStatus(page.status());
  }
  for (const SetMesh& mesh : page->items) {
    *response->add_meshes() = ToProto(mesh);
  }
  response->set_next_page_token(page->next_token);
  return grpc::Status::OK;
}

grpc::Status MeshServiceSkin::ListSets(grpc::ServerContext* /*context*/,
                                       const v1::ListSetsRequest* request,
                                       v1::ListSetsResponse* response) {
  const absl::StatusOr<Page<MeshSet>> page =
      coordinator_.ListSets(request->page_size(), request->page_token());
  if (!page.ok()) {
    return ToGrpcStatus(page.status());
  }
  for (const MeshSet& set : page->items) {
    auto* added = response->add_sets();
    added->set_name(set.name);
    added->set_meshes(set.meshes);
    added->set_size_bytes(set.size_bytes);
  }
  response->set_next_page_token(page->next_token);
  return grpc::Status::OK;
}

grpc::Status MeshServiceSkin::RemoveMesh(grpc::ServerContext* /*context*/,
                                         const v1::RemoveMeshRequest* request,
                                         v1::RemoveMeshResponse* /*response*/) {
  return ToGrpcStatus(coordinator_.RemoveMesh(request->set(), request->name()));
}

grpc::Status MeshServiceSkin::DeleteSet(grpc::ServerContext* /*context*/,
                                        const v1::DeleteSetRequest* request,
                                        v1::DeleteSetResponse* /*response*/) {
  return ToGrpcStatus(coordinator_.DeleteSet(request->set()));
}

}  // namespace cohort
