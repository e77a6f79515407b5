#include <vector>

#include <pcl/kdtree/kdtree_flann.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include "tests/bench/rivals/built_in.h"

namespace cohort {
namespace {

class PclRival : public NearestRival {
 public:
  explicit PclRival(PointList vertices) : cloud_(CloudOf(vertices)), tree_(/*sorted=*/false) {
    tree_.setInputCloud(cloud_);
  }

  void Find(PointList queries, int32_t* nearest, double* squared_distances) const override {
    std::vector<int> indices(1);
    std::vector<float> squares(1);
    for (int64_t i = 0; i < queries.count; ++i) {
      tree_.nearestKSearch(At(queries, i), 1, indices, squares);
      nearest[i] = indices[0];
      squared_distances[i] = static_cast<double>(squares[0]);
    }
  }

 private:
  static pcl::PointXYZ At(PointList points, int64_t i) {
    const double* p = points.xyz + 3 * i;
    return {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
  }
  static pcl::PointCloud<pcl::PointXYZ>::Ptr CloudOf(PointList points) {
    auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
    for (int64_t i = 0; i < points.count; ++i) {
      cloud->push_back(At(points, i));
    }
    return cloud;
  }

  pcl::PointCloud<pcl::PointXYZ>::Ptr cloud_;
  pcl::KdTreeFLANN<pcl::PointXYZ> tree_;
};

}  // namespace

std::unique_ptr<NearestRival> MakePclKdTree(PointList vertices) {
  return std::make_unique<PclRival>(vertices);
}

}  // namespace cohort
