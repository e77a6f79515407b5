#include "common/geometry/comparison/signed_distances.h"

#include <cassert>
#include <cmath>

namespace cohort {
namespace {

/// (p - c) . n: float products are exact in double, so only two sums round.
double Side(const Eigen::Vector3f& p, const Eigen::Vector3f& c, const Eigen::Vector3f& n) {
  const Eigen::Vector3d difference = p.cast<double>() - c.cast<double>();
  return difference.x() * double{n.x()} + difference.y() * double{n.y()} +
         difference.z() * double{n.z()};
}

template <typename PointOf>
SignedField WithSides(const Eigen::Ref<const Eigen::Matrix3Xf>& queries,
                      const Eigen::Ref<const Eigen::Matrix3Xf>& normals,
                      std::span<const float> squared_distances,
                      PointOf point_of) {
  assert(normals.cols() == queries.cols());
  assert(static_cast<Eigen::Index>(squared_distances.size()) == queries.cols());
  SignedField field;
  field.distances.resize(squared_distances.size());
  for (size_t i = 0; i < squared_distances.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    const double side = Side(queries.col(column), point_of(i), normals.col(column));
    const float distance = std::sqrt(squared_distances[i]);
    field.distances[i] = side > 0 ? distance : side < 0 ? 0.0F - distance : 0.0F;
    field.undecided += side == 0 && distance > 0 ? 1 : 0;
  }
  return field;
}

}  // namespace

SignedField SignedDistances(const Eigen::Ref<const Eigen::Matrix3Xf>& queries,
                            const Eigen::Ref<const Eigen::Matrix3Xf>& normals,
                            const Eigen::Ref<const Eigen::Matrix3Xf>& target_vertices,
                            std::span<const int32_t> nearest,
                            std::span<const float> squared_distances) {
  assert(nearest.size() == squared_distances.size());
  return WithSides(queries, normals, squared_distances,
                   [&](size_t i) -> Eigen::Vector3f { return target_vertices.col(nearest[i]); });
}

SignedField SignedDistances(const Eigen::Ref<const Eigen::Matrix3Xf>& queries,
                            const Eigen::Ref<const Eigen::Matrix3Xf>& normals,
                            const Eigen::Ref<const Eigen::Matrix3Xf>& nearest_points,
                            std::span<const float> squared_distances) {
  return WithSides(queries, normals, squared_distances, [&](size_t i) -> Eigen::Vector3f {
    return nearest_points.col(static_cast<Eigen::Index>(i));
  });
}

}  // namespace cohort
