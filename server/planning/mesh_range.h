#pragma once

#include <cstdint>

namespace cohort {

/// Consecutive meshes [begin, end).
struct MeshRange {
  int64_t begin = 0;
  int64_t end = 0;
  [[nodiscard]] int64_t Size() const { return end - begin; }
  friend bool operator==(const MeshRange&, const MeshRange&) = default;
};

}  // namespace cohort
