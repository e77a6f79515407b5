#pragma once

#include <cstdint>

#include "server/planning/mesh_range.h"

namespace cohort {

/// Cuts a number of meshes into blocks, the sides of tiles: of one size but for the last ones, each
/// smaller than the one before, so that small tiles are left for the end, when workers are to
/// finish together.
class BlockPartition {
 public:
  /// @param meshes  >= 0.
  /// @param count   of blocks, 1..meshes; 0 if there are no meshes.
  BlockPartition(int64_t meshes, int64_t count);

  [[nodiscard]] int64_t Count() const { return count_; }
  /// @param block  0..Count()-1; none is empty.
  [[nodiscard]] MeshRange At(int64_t block) const { return {Begin(block), Begin(block + 1)}; }
  /// No block has more meshes than this.
  [[nodiscard]] int64_t MostMeshes() const;

 private:
  [[nodiscard]] int64_t Begin(int64_t block) const;
  /// Weights of so many blocks at the end: 1, 2, ..., steps_, steps_, ...
  [[nodiscard]] int64_t WeightOfLast(int64_t blocks) const;

  int64_t meshes_;
  int64_t count_;
  int64_t steps_;  ///< Sizes that there are, the full one included.
};

}  // namespace cohort
