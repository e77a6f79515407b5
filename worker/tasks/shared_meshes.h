#pragma once

#include <memory>
#include <string_view>

#include "common/geometry/nearest/packed_mesh.h"
#include "common/store/shared_folder.h"

namespace cohort {

/// Packed meshes that one worker of a machine has made and the others read, instead of decoding,
/// placing and packing them. Thread-safe.
class SharedMeshes {
 public:
  /// @param folder  must outlive this.
  explicit SharedMeshes(SharedFolder& folder) : folder_(folder) {}

  /// @param key  says all that the mesh follows from.
  /// @return null if nobody has shared it.
  [[nodiscard]] std::shared_ptr<const PackedMesh> Get(std::string_view key);
  void Keep(std::string_view key, const PackedMesh& mesh);

 private:
  SharedFolder& folder_;
};

}  // namespace cohort
