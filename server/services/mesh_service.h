#pragma once

#include "cohort/v1/mesh_service.grpc.pb.h"
#include "server/core/coordinator.h"

namespace cohort {

/// MeshService over the coordinator; streams files into the blob store.
class MeshServiceSkin final : public v1::MeshService::Service {
 public:
  explicit MeshServiceSkin(Coordinator& coordinator) : coordinator_(coordinator) {}

  grpc::Status FindMissing(grpc::ServerContext* context,
                           const v1::FindMissingRequest* request,
                           v1::FindMissingResponse* response) override;
  grpc::Status AddMesh(grpc::ServerContext* context,
                       grpc::ServerReader<v1::AddMeshRequest>* reader,
                       v1::AddMeshResponse* response) override;
  grpc::Status ListMeshes(grpc::ServerContext* context,
                          const v1::ListMeshesRequest* request,
                          v1::ListMeshesResponse* response) override;
  grpc::Status ListSets(grpc::ServerContext* context,
                        const v1::ListSetsRequest* request,
                        v1::ListSetsResponse* response) override;

  grpc::Status RemoveMesh(grpc::ServerContext* context,
                          const v1::RemoveMeshRequest* request,
                          v1::RemoveMeshResponse* response) override;
  grpc::Status DeleteSet(grpc::ServerContext* context,
                         const v1::DeleteSetRequest* request,
                         v1::DeleteSetResponse* response) override;

 private:
  absl::Status ReceiveBytes(const v1::AddMeshRequest& first,
                            grpc::ServerReader<v1::AddMeshRequest>& reader,
                            const SetMesh& mesh);
  Coordinator& coordinator_;
};

}  // namespace cohort
