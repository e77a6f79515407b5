#include <vtkAbstractPointLocator.h>
#include <vtkCellArray.h>
#include <vtkGenericCell.h>
#include <vtkKdTreePointLocator.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkStaticCellLocator.h>
#include <vtkStaticPointLocator.h>

#include "tests/bench/rivals/built_in.h"

namespace cohort {
namespace {

void SetPoints(PointList vertices, vtkPolyData& mesh) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (int64_t i = 0; i < vertices.count; ++i) {
    points->InsertNextPoint(vertices.xyz + 3 * i);
  }
  mesh.SetPoints(points);
}

template <typename Locator>
class VtkPointRival : public NearestRival {
 public:
  explicit VtkPointRival(PointList vertices) : vertices_(vertices) {
    SetPoints(vertices, *mesh_.Get());
    locator_->SetDataSet(mesh_);
    locator_->BuildLocator();
  }

  void Find(PointList queries, int32_t* nearest, double* squared_distances) const override {
    for (int64_t i = 0; i < queries.count; ++i) {
      const double* q = queries.xyz + 3 * i;
      const vtkIdType found = locator_->FindClosestPoint(q);
      const double* p = vertices_.xyz + 3 * found;
      nearest[i] = static_cast<int32_t>(found);
      squared_distances[i] = (q[0] - p[0]) * (q[0] - p[0]) + (q[1] - p[1]) * (q[1] - p[1]) +
                             (q[2] - p[2]) * (q[2] - p[2]);
    }
  }

 private:
  PointList vertices_;
  vtkNew<vtkPolyData> mesh_;
  vtkNew<Locator> locator_;
};

class VtkCellRival : public SurfaceRival {
 public:
  VtkCellRival(PointList vertices, TriangleList triangles) {
    SetPoints(vertices, *mesh_.Get());
    vtkNew<vtkCellArray> cells;
    for (int64_t i = 0; i < triangles.count; ++i) {
      const int32_t* t = triangles.corners + 3 * i;
      cells->InsertNextCell({t[0], t[1], t[2]});
    }
    mesh_->SetPolys(cells);
    mesh_->BuildCells();
    locator_->SetDataSet(mesh_);
    locator_->BuildLocator();
  }

  void Find(PointList queries, double* squared_distances) const override {
    vtkNew<vtkGenericCell> cell;
    double closest[3];
    vtkIdType cell_id = 0;
    int part = 0;
    for (int64_t i = 0; i < queries.count; ++i) {
      locator_->FindClosestPoint(queries.xyz + 3 * i, closest, cell, cell_id, part,
                                 squared_distances[i]);
    }
  }

 private:
  vtkNew<vtkPolyData> mesh_;
  vtkNew<vtkStaticCellLocator> locator_;
};

}  // namespace

std::unique_ptr<NearestRival> MakeVtkPointLocator(PointList vertices) {
  return std::make_unique<VtkPointRival<vtkStaticPointLocator>>(vertices);
}

std::unique_ptr<NearestRival> MakeVtkKdTree(PointList vertices) {
  return std::make_unique<VtkPointRival<vtkKdTreePointLocator>>(vertices);
}

std::unique_ptr<SurfaceRival> MakeVtkCellLocator(PointList vertices, TriangleList triangles) {
  return std::make_unique<VtkCellRival>(vertices, triangles);
}

}  // namespace cohort
