#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include <Eigen/Core>

namespace cohort {

/// Finds, for many query points at once, the nearest vertex of one target mesh. Exact.
///
/// Distances are float32: fma(dx, dx, fma(dy, dy, dz * dz)) with d = query - vertex, evaluated in
/// that order on every machine; of several nearest vertices the lowest index wins. Callers centre
/// the coordinates, so that float32 is enough. Const calls may run together.
class NearestVertex {
 public:
  /// @param vertices  3 x n, n >= 1, finite, centred, mesh units; copied.
  [[nodiscard]] static std::unique_ptr<const NearestVertex> Build(
      const Eigen::Ref<const Eigen::Matrix3Xf>& vertices);
  virtual ~NearestVertex() = default;

  /// Writes for each column of `queries` the index of its nearest vertex and the squared distance.
  /// @param queries  3 x q, in the frame of `vertices`.
  /// @param indices, squared_distances  q slots each.
  virtual void Find(const Eigen::Ref<const Eigen::Matrix3Xf>& queries,
                    std::span<int32_t> indices,
                    std::span<float> squared_distances) const = 0;

  /// The vertices as given, 3 x n.
  [[nodiscard]] virtual const Eigen::Matrix3Xf& Vertices() const = 0;
};

}  // namespace cohort
