#include "common/geometry/nearest/vertex_neighbourhood.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include <nanoflann.hpp>

namespace cohort {
namespace {

/// Vertices as nanoflann reads them.
class TreePoints {
 public:
  explicit TreePoints(const Eigen::Matrix3Xd& vertices) : vertices_(vertices) {}

  [[nodiscard]] size_t kdtree_get_point_count() const {
    return static_cast<size_t>(vertices_.cols());
  }
  [[nodiscard]] double kdtree_get_pt(uint32_t i, size_t axis) const {
    return vertices_(static_cast<Eigen::Index>(axis), i);
  }
  template <class Box>
  bool kdtree_get_bbox(Box& /*box*/) const {
    return false;  // nanoflann computes it.
  }

 private:
  const Eigen::Matrix3Xd& vertices_;
};

/// The documented distance, for points and (one axis at a time) for boxes.
class SquaredDistance {
 public:
  using ElementType = double;
  using DistanceType = double;

  explicit SquaredDistance(const TreePoints& points) : points_(points) {}

  [[nodiscard]] double evalMetric(const double* query, uint32_t i, size_t /*dimensions*/) const {
    const double dx = query[0] - points_.kdtree_get_pt(i, 0);
    const double dy = query[1] - points_.kdtree_get_pt(i, 1);
    const double dz = query[2] - points_.kdtree_get_pt(i, 2);
    return dx * dx + (dy * dy + dz * dz);
  }
  [[nodiscard]] double accum_dist(double a, double b, size_t /*axis*/) const {
    return (a - b) * (a - b);
  }

 private:
  const TreePoints& points_;
};

/// nanoflann walks on and offers points only below this. Its bounds of boxes are sums that differ
/// from a point's distance by some 1e-15, and points at exactly the limit count too.
double LooseLimit(double squared_distance) {
  return squared_distance * (1 + 1e-9) + std::numeric_limits<double>::min();
}

bool IsNearer(const NearVertex& a, const NearVertex& b) {
  return a.squared_distance < b.squared_distance ||
         (a.squared_distance == b.squared_distance && a.vertex < b.vertex);
}

/// Keeps the k nearest of the points offered, the farthest of them on top of a heap.
class NearestResult {
 public:
  using DistanceType = double;

  NearestResult(size_t k, std::vector<NearVertex>& found) : k_(k), found_(found) {}

  bool addPoint(double squared_distance, uint32_t i) {
    const NearVertex candidate = {.vertex = static_cast<int32_t>(i),
                                  .squared_distance = squared_distance};
    if (found_.size() == k_) {
      if (!IsNearer(candidate, found_.front())) {
        return true;  // go on
      }
      std::pop_heap(found_.begin(), found_.end(), IsNearer);
      found_.pop_back();
    }
    found_.push_back(candidate);
    std::push_heap(found_.begin(), found_.end(), IsNearer);
    return true;
  }
  [[nodiscard]] double worstDist() const {
    return found_.size() < k_ ? std::numeric_limits<double>::infinity()
                              : LooseLimit(found_.front().squared_distance);
  }
  [[nodiscard]] bool full() const { return true; }

 private:
  size_t k_;
  std::vector<NearVertex>& found_;
};

/// Keeps all points offered that lie within the radius.
class WithinResult {
 public:
  using DistanceType = double;

  WithinResult(double squared_radius, std::vector<NearVertex>& found)
      : squared_radius_(squared_radius), found_(found) {}

  bool addPoint(double squared_distance, uint32_t i) {
    if (squared_distance <= squared_radius_) {
      found_.push_back({.vertex = static_cast<int32_t>(i), .squared_distance = squared_distance});
    }
    return true;  // go on
  }
  [[nodiscard]] double worstDist() const { return LooseLimit(squared_radius_); }
  [[nodiscard]] bool full() const { return true; }

 private:
  double squared_radius_;
  std::vector<NearVertex>& found_;
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<SquaredDistance, TreePoints, 3, uint32_t>;
constexpr size_t kLeafSize = 10;

class KdTreeNeighbourhood final : public VertexNeighbourhood {
 public:
  explicit KdTreeNeighbourhood(const Eigen::Ref<const Eigen::Matrix3Xd>& vertices)
      : vertices_(vertices),
        points_(vertices_),
        tree_(3, points_, nanoflann::KDTreeSingleIndexAdaptorParams(kLeafSize)) {}

  void Nearest(const Eigen::Vector3d& query,
               int64_t k,
               std::vector<NearVertex>& found) const override {
    assert(k >= 1);
    found.clear();
    NearestResult result(static_cast<size_t>(std::min<int64_t>(k, vertices_.cols())), found);
    tree_.findNeighbors(result, query.data(), nanoflann::SearchParams());
    std::sort_heap(found.begin(), found.end(), IsNearer);
  }

  void Within(const Eigen::Vector3d& query,
              double radius,
              std::vector<NearVertex>& found) const override {
    assert(radius >= 0);
    found.clear();
    WithinResult result(radius * radius, found);
    tree_.findNeighbors(result, query.data(), nanoflann::SearchParams());
    std::sort(found.begin(), found.end(), IsNearer);
  }

  [[nodiscard]] const Eigen::Matrix3Xd& Vertices() const override { return vertices_; }

 private:
  Eigen::Matrix3Xd vertices_;
  TreePoints points_;
  Tree tree_;
};

}  // namespace

std::unique_ptr<const VertexNeighbourhood> VertexNeighbourhood::Build(
    const Eigen::Ref<const Eigen::Matrix3Xd>& vertices) {
  assert(vertices.cols() >= 1);
  return std::make_unique<const KdTreeNeighbourhood>(vertices);
}

double MeanSpacing(const VertexNeighbourhood& neighbourhood) {
  const Eigen::Matrix3Xd& vertices = neighbourhood.Vertices();
  assert(vertices.cols() >= 2);
  std::vector<NearVertex> found;
  double sum = 0;
  for (Eigen::Index v = 0; v < vertices.cols(); ++v) {
    neighbourhood.Nearest(vertices.col(v), 2, found);
    sum += std::sqrt(found[1].squared_distance);  // found[0]: itself, or another one right there
  }
  return sum / static_cast<double>(vertices.cols());
}

}  // namespace cohort
