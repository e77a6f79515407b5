#pragma once

#include <cstdint>

#include "server/planning/mesh_range.h"

namespace cohort {

/// Cuts a number of meshes into batches: of one size at first, smaller towards the end, so that
/// workers which take them one after the other finish together.
class BatchPartition {
 public:
  /// @param meshes  >= 0.
  /// @param size    of the first batches, >= 1.
  /// @param least   of the last ones (but the very last, which may be smaller), 1..size.
  BatchPartition(int64_t meshes, int64_t size, int64_t least);

  [[nodiscard]] int64_t Count() const { return count_; }
  /// @param batch  0..Count()-1.
  [[nodiscard]] MeshRange At(int64_t batch) const;

 private:
  [[nodiscard]] MeshRange Next(int64_t begin) const;

  int64_t meshes_;
  int64_t size_;
  int64_t least_;
  int64_t full_;   ///< Batches of `size_` at the front.
  int64_t count_;  ///< Of all.
};

/// The batches of so many meshes of a job: large enough to be worth handing out, and enough of them
/// to keep workers busy. Follows from the meshes alone, so that the sums over batches do too.
/// @param mean_vertices  of a mesh.
[[nodiscard]] BatchPartition BatchesOf(int64_t meshes, double mean_vertices);

}  // namespace cohort
