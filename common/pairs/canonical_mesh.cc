#include "common/pairs/canonical_mesh.h"

#include "common/base/status_macros.h"
#include "common/geometry/io/read_mesh.h"
#include "common/store/mesh_blob.h"

namespace cohort {

absl::StatusOr<CanonicalMesh> MakeCanonical(std::string_view bytes,
                                            const std::string& name,
                                            int position_bits) {
  COHORT_ASSIGN_OR_RETURN(TriangleMesh mesh, ReadMesh(bytes, name));
  CanonicalMesh canonical;
  if (const absl::Status checked = CheckAndClean(mesh, canonical.health); !checked.ok()) {
    return absl::Status(checked.code(), name + ": " + std::string(checked.message()));
  }
  COHORT_ASSIGN_OR_RETURN(canonical.blob,
                          EncodeDracoMeshBlob(mesh, {.position_bits = position_bits}));
  // The decoded mesh is the mesh from now on: Draco rounds coordinates and reorders vertices.
  COHORT_ASSIGN_OR_RETURN(canonical.mesh, DecodeMeshBlob(canonical.blob));
  return canonical;
}

}  // namespace cohort
