#include "common/geometry/nearest/nearest_vertex.h"

#include <cassert>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include <nanoflann.hpp>

namespace cohort {
namespace {

/// The documented distance, the only one that leaves this file.
float SquaredDistance(const float* a, const float* b) {
  const float dx = a[0] - b[0];
  const float dy = a[1] - b[1];
  const float dz = a[2] - b[2];
  return std::fma(dx, dx, std::fma(dy, dy, dz * dz));
}

/// Vertices in the order of the tree's leaves, as nanoflann reads them.
class LeafPoints {
 public:
  using ElementType = float;
  using DistanceType = float;

  explicit LeafPoints(const Eigen::Matrix3Xf& vertices)
      : xyz_(vertices.data(), vertices.data() + vertices.size()) {}

  /// Puts point order[i] at place i.
  void Reorder(const std::vector<uint32_t>& order) {
    std::vector<float> reordered;
    reordered.reserve(xyz_.size());
    for (const uint32_t i : order) {
      reordered.insert(reordered.end(), At(i), At(i) + 3);
    }
    xyz_ = std::move(reordered);
  }
  [[nodiscard]] const float* At(uint32_t i) const { return &xyz_[3 * size_t{i}]; }

  [[nodiscard]] size_t kdtree_get_point_count() const { return xyz_.size() / 3; }
  [[nodiscard]] float kdtree_get_pt(uint32_t i, size_t axis) const { return At(i)[axis]; }
  template <class Box>
  bool kdtree_get_bbox(Box& /*box*/) const {
    return false;  // nanoflann computes it.
  }

 private:
  std::vector<float> xyz_;
};

/// Distance for walking the tree: without fused multiply-add, which is a call into the C library on
/// machines that the compiler may not assume to have it. NearestResult makes it exact.
class ApproximateDistance {
 public:
  using ElementType = float;
  using DistanceType = float;

  explicit ApproximateDistance(const LeafPoints& points) : points_(points) {}

  [[nodiscard]] float evalMetric(const float* query, uint32_t i, size_t /*dimensions*/) const {
    const float* point = points_.At(i);
    const float dx = query[0] - point[0];
    const float dy = query[1] - point[1];
    const float dz = query[2] - point[2];
    return dx * dx + (dy * dy + dz * dz);
  }
  [[nodiscard]] float accum_dist(float a, float b, size_t /*axis*/) const {
    return (a - b) * (a - b);
  }

 private:
  const LeafPoints& points_;
};

/// Keeps the smallest (exact distance, vertex index) of the points offered.
///
/// nanoflann prunes boxes and drops points by WorstDist(), in rounded arithmetic. The true minimum
/// and its ties must get through: both the approximate distance and the incremental bound of a box
/// are within a few 1e-6 of exact (some 3 roundings of 6e-8 for each of tens of levels), so the
/// worst distance is told 1e-4 too large. That lets through hardly any point more.
class NearestResult {
 public:
  using DistanceType = float;

  NearestResult(const LeafPoints& points, const std::vector<int32_t>& vertex_of, const float* query)
      : points_(points), vertex_of_(vertex_of), query_(query) {}

  bool addPoint(float /*approximate_distance*/, uint32_t i) {
    const float squared_distance = SquaredDistance(query_, points_.At(i));
    const int32_t vertex = vertex_of_[i];
    if (squared_distance < squared_distance_ ||
        (squared_distance == squared_distance_ && vertex < vertex_)) {
      squared_distance_ = squared_distance;
      vertex_ = vertex;
      worst_ = squared_distance * (1 + 1e-4F) + std::numeric_limits<float>::min();
    }
    return true;  // go on
  }
  [[nodiscard]] float worstDist() const { return worst_; }
  [[nodiscard]] bool full() const { return true; }

  [[nodiscard]] int32_t Vertex() const { return vertex_; }
  [[nodiscard]] float Distance() const { return squared_distance_; }

 private:
  const LeafPoints& points_;
  const std::vector<int32_t>& vertex_of_;
  const float* query_;
  int32_t vertex_ = 0;
  float squared_distance_ = std::numeric_limits<float>::infinity();
  float worst_ = std::numeric_limits<float>::infinity();
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<ApproximateDistance, LeafPoints, 3, uint32_t>;
constexpr size_t kLeafSize = 16;

class KdTreeNearestVertex final : public NearestVertex {
 public:
  explicit KdTreeNearestVertex(const Eigen::Ref<const Eigen::Matrix3Xf>& vertices)
      : vertices_(vertices),
        points_(vertices_),
        tree_(3, points_, nanoflann::KDTreeSingleIndexAdaptorParams(kLeafSize)) {
    // The points of a leaf side by side in memory, numbered as they lie.
    points_.Reorder(tree_.vAcc);
    vertex_of_.assign(tree_.vAcc.begin(), tree_.vAcc.end());
    std::iota(tree_.vAcc.begin(), tree_.vAcc.end(), 0U);
  }

  void Find(const Eigen::Ref<const Eigen::Matrix3Xf>& queries,
            std::span<int32_t> indices,
            std::span<float> squared_distances) const override {
    assert(std::ssize(indices) == queries.cols());
    assert(std::ssize(squared_distances) == queries.cols());
    for (Eigen::Index i = 0; i < queries.cols(); ++i) {
      NearestResult result(points_, vertex_of_, queries.col(i).data());
      tree_.findNeighbors(result, queries.col(i).data(), nanoflann::SearchParams());
      indices[static_cast<size_t>(i)] = result.Vertex();
      squared_distances[static_cast<size_t>(i)] = result.Distance();
    }
  }

  [[nodiscard]] const Eigen::Matrix3Xf& Vertices() const override { return vertices_; }

 private:
  Eigen::Matrix3Xf vertices_;
  LeafPoints points_;
  Tree tree_;
  std::vector<int32_t> vertex_of_;  ///< Place in leaf order -> vertex index.
};

}  // namespace

std::unique_ptr<const NearestVertex> NearestVertex::Build(
    const Eigen::Ref<const Eigen::Matrix3Xf>& vertices) {
  assert(vertices.cols() >= 1);
  return std::make_unique<const KdTreeNearestVertex>(vertices);
}

}  // namespace cohort
