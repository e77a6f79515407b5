#include <iterator>
#include <vector>

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Simple_cartesian.h>

#include "tests/bench/rivals/built_in.h"

namespace cohort {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;  // the fastest of CGAL's
using Triangles = std::vector<Kernel::Triangle_3>;
using Primitive = CGAL::AABB_triangle_primitive<Kernel, Triangles::const_iterator>;
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

Kernel::Point_3 At(PointList points, int64_t i) {
  const double* p = points.xyz + 3 * i;
  return {p[0], p[1], p[2]};
}

Triangles TrianglesOf(PointList vertices, TriangleList triangles) {
  Triangles result;
  for (int64_t i = 0; i < triangles.count; ++i) {
    const int32_t* t = triangles.corners + 3 * i;
    result.emplace_back(At(vertices, t[0]), At(vertices, t[1]), At(vertices, t[2]));
  }
  return result;
}

class CgalRival : public SurfaceRival {
 public:
  CgalRival(PointList vertices, TriangleList triangles)
      : triangles_(TrianglesOf(vertices, triangles)),
        tree_(triangles_.cbegin(), triangles_.cend()) {
    tree_.build();
    tree_.accelerate_distance_queries();
  }

  void Find(PointList queries, double* squared_distances) const override {
    for (int64_t i = 0; i < queries.count; ++i) {
      squared_distances[i] = tree_.squared_distance(At(queries, i));
    }
  }

 private:
  Triangles triangles_;
  Tree tree_;
};

}  // namespace

std::unique_ptr<SurfaceRival> MakeCgalTree(PointList vertices, TriangleList triangles) {
  return std::make_unique<CgalRival>(vertices, triangles);
}

}  // namespace cohort
