#include "tests/bench/rivals/built_in.h"

namespace cohort {

std::vector<NearestRivalKind> NearestRivals() {
  std::vector<NearestRivalKind> rivals = {{kBase, MakeNanoflann}};
#if defined(COHORT_BENCH_PCL)
  rivals.push_back({"PCL KdTreeFLANN", MakePclKdTree});
#endif
#if defined(COHORT_BENCH_OPEN3D)
  rivals.push_back({"Open3D KDTreeFlann", MakeOpen3dKdTree});
#endif
#if defined(COHORT_BENCH_VTK)
  rivals.push_back({"VTK vtkStaticPointLocator", MakeVtkPointLocator});
  rivals.push_back({"VTK vtkKdTreePointLocator", MakeVtkKdTree});
#endif
  return rivals;
}

std::vector<SurfaceRivalKind> SurfaceRivals() {
  std::vector<SurfaceRivalKind> rivals;
#if defined(COHORT_BENCH_EMBREE)
  rivals.push_back({kEmbree, MakeEmbree});
#endif
#if defined(COHORT_BENCH_CGAL)
  rivals.push_back({kCgal, MakeCgalTree});
#endif
#if defined(COHORT_BENCH_VTK)
  rivals.push_back({"VTK vtkStaticCellLocator", MakeVtkCellLocator});
#endif
  return rivals;
}

}  // namespace cohort
