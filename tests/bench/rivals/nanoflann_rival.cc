#include <array>
#include <cstddef>
#include <memory>

#include <nanoflann.hpp>

#include "tests/bench/rivals/built_in.h"

namespace cohort {
namespace {

constexpr size_t kLeafSize = 10;  // nanoflann's default

struct Cloud {
  PointList points;

  [[nodiscard]] size_t kdtree_get_point_count() const { return static_cast<size_t>(points.count); }
  [[nodiscard]] double kdtree_get_pt(size_t i, size_t axis) const {
    return points.xyz[3 * i + axis];
  }
  template <typename Box>
  bool kdtree_get_bbox(Box& /*box*/) const {
    return false;
  }
};

using Tree =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Cloud>, Cloud, 3>;

class NanoflannRival : public NearestRival {
 public:
  explicit NanoflannRival(PointList vertices)
      : cloud_{vertices}, tree_(3, cloud_, nanoflann::KDTreeSingleIndexAdaptorParams(kLeafSize)) {}

  void Find(PointList queries, int32_t* nearest, double* squared_distances) const override {
    for (int64_t i = 0; i < queries.count; ++i) {
      uint32_t index = 0;
      tree_.knnSearch(queries.xyz + 3 * i, 1, &index, squared_distances + i);
      nearest[i] = static_cast<int32_t>(index);
    }
  }

 private:
  Cloud cloud_;
  Tree tree_;
};

class NanoflannIcp : public IcpRival {
 public:
  explicit NanoflannIcp(PointList target)
      : cloud_{target}, tree_(3, cloud_, nanoflann::KDTreeSingleIndexAdaptorParams(kLeafSize)) {}

  [[nodiscard]] RivalSums Pass(PointList source,
                               const std::array<double, 12>& transform) const override {
    RivalSums sums;
    for (int64_t i = 0; i < source.count; ++i) {
      Add(source.xyz + 3 * i, transform, sums);
    }
    return sums;
  }

 private:
  void Add(const double* a, const std::array<double, 12>& transform, RivalSums& sums) const {
    std::array<double, 3> moved{};
    for (size_t r = 0; r < 3; ++r) {
      moved[r] = transform[4 * r] * a[0] + transform[4 * r + 1] * a[1] +
                 transform[4 * r + 2] * a[2] + transform[4 * r + 3];
    }
    uint32_t index = 0;
    double squared_distance = 0;
    tree_.knnSearch(moved.data(), 1, &index, &squared_distance);
    const double* b = cloud_.points.xyz + 3 * static_cast<size_t>(index);
    sums.count += 1;
    sums.squared_distance += squared_distance;
    for (size_t r = 0; r < 3; ++r) {
      sums.a[r] += a[r];
      sums.b[r] += b[r];
      sums.aa += a[r] * a[r];
      sums.bb += b[r] * b[r];
      for (size_t c = 0; c < 3; ++c) {
        sums.ba[3 * r + c] += b[r] * a[c];
      }
    }
  }

  Cloud cloud_;
  Tree tree_;
};

}  // namespace

std::unique_ptr<NearestRival> MakeNanoflann(PointList vertices) {
  return std::make_unique<NanoflannRival>(vertices);
}

std::unique_ptr<IcpRival> MakeIcpRival(PointList target) {
  return std::make_unique<NanoflannIcp>(target);
}

}  // namespace cohort
