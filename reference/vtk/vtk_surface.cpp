#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPolyData.h>

#include <array>
#include <utility>

#include "core/mesh/geometry.h"
#include "reference/vtk/vtk_tools.h"

namespace palpate::reference {
namespace {

SurfaceMesh to_surface(vtkPolyData* data, const Vec3& origin) {
  SurfaceMesh surface;
  for (vtkIdType i = 0; i < data->GetNumberOfPoints(); ++i) {
    std::array<double, 3> p{};
    data->GetPoint(i, p.data());
    surface.points.push_back(Vec3{p[0], p[1], p[2]} - origin);
  }
  vtkNew<vtkIdList> corners;
  for (vtkIdType i = 0; i < data->GetNumberOfCells(); ++i) {
    data->GetCellPoints(i, corners);
    if (corners->GetNumberOfIds() != 3) continue;
    surface.triangles.push_back({static_cast<Index>(corners->GetId(0)), static_cast<Index>(corners->GetId(1)),
                                 static_cast<Index>(corners->GetId(2))});
  }
  return surface;
}

/// Drops the points that no triangle uses; the others keep their order.
void remove_unused_points(SurfaceMesh& surface) {
  std::vector<Index> renamed(surface.points.size(), kNoIndex);
  for (const Triangle& t : surface.triangles) {
    for (const Index v : t) renamed[v] = 0;
  }
  Index kept = 0;
  for (std::size_t v = 0; v < renamed.size(); ++v) {
    if (renamed[v] == kNoIndex) continue;
    renamed[v] = kept;
    surface.points[kept++] = surface.points[v];
  }
  surface.points.resize(kept);
  for (Triangle& t : surface.triangles) {
    for (Index& v : t) v = renamed[v];
  }
}

}  // namespace

SurfaceMesh closed_surface_of(vtkPolyData* data, const Vec3& origin) {
  SurfaceMesh surface = to_surface(data, origin);
  remove_unused_points(surface);
  if (enclosed_volume(surface) < 0.0) {
    for (Triangle& t : surface.triangles) std::swap(t[1], t[2]);
  }
  return surface;
}

}  // namespace palpate::reference
