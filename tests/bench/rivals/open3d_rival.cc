#include <vector>

#include <open3d/geometry/KDTreeFlann.h>
#include <Eigen/Core>

#include "tests/bench/rivals/built_in.h"

namespace cohort {
namespace {

class Open3dRival : public NearestRival {
 public:
  explicit Open3dRival(PointList vertices)
      : vertices_(Eigen::Map<const Eigen::MatrixXd>(vertices.xyz, 3, vertices.count)),
        tree_(vertices_) {}

  void Find(PointList queries, int32_t* nearest, double* squared_distances) const override {
    std::vector<int> indices;
    std::vector<double> squares;
    for (int64_t i = 0; i < queries.count; ++i) {
      const Eigen::Vector3d query(queries.xyz + 3 * i);
      tree_.SearchKNN(query, 1, indices, squares);
      nearest[i] = indices[0];
      squared_distances[i] = squares[0];
    }
  }

 private:
  Eigen::MatrixXd vertices_;  // Open3D 0.16 copies them and then reads the original.
  open3d::geometry::KDTreeFlann tree_;
};

}  // namespace

std::unique_ptr<NearestRival> MakeOpen3dKdTree(PointList vertices) {
  return std::make_unique<Open3dRival>(vertices);
}

}  // namespace cohort
