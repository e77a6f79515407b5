#pragma once

#include <memory>

#include "tests/bench/rivals/rival.h"

namespace cohort {

/// Each is defined where its package was found: COHORT_BENCH_<NAME> (CMakeLists.txt).

std::unique_ptr<NearestRival> MakeNanoflann(PointList vertices);
std::unique_ptr<NearestRival> MakePclKdTree(PointList vertices);
std::unique_ptr<NearestRival> MakeOpen3dKdTree(PointList vertices);
std::unique_ptr<NearestRival> MakeVtkPointLocator(PointList vertices);
std::unique_ptr<NearestRival> MakeVtkKdTree(PointList vertices);

std::unique_ptr<SurfaceRival> MakeEmbree(PointList vertices, TriangleList triangles);
std::unique_ptr<SurfaceRival> MakeCgalTree(PointList vertices, TriangleList triangles);
std::unique_ptr<SurfaceRival> MakeVtkCellLocator(PointList vertices, TriangleList triangles);

}  // namespace cohort
