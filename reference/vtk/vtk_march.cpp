#include <vtkCellArray.h>
#include <vtkFlyingEdges3D.h>
#include <vtkImageData.h>
#include <vtkImplicitPolyDataDistance.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/mesh/geometry.h"
#include "reference/vtk/vtk_tools.h"

namespace palpate::reference {
namespace {

constexpr double kMostVoxels = 5e7;
constexpr double kLevels = 128.0;  // grey levels from the surface to a voxel off it

vtkNew<vtkPolyData> to_poly_data(const SurfaceMesh& surface) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (const Vec3& p : surface.points) points->InsertNextPoint(p.x, p.y, p.z);
  vtkNew<vtkCellArray> triangles;
  for (const Triangle& t : surface.triangles) {
    triangles->InsertNextCell(3);
    for (const Index v : t) triangles->InsertCellPoint(v);
  }
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetPolys(triangles);
  return data;
}

/// The voxels around a surface, shifted by a share of one along each axis.
vtkNew<vtkImageData> voxels_around(const SurfaceMesh& surface, double spacing, std::uint64_t seed) {
  SplitMix64 random(seed);
  const BoundingBox box = bounding_box(surface.points);
  const std::array<double, 3> low{box.low.x, box.low.y, box.low.z};
  const std::array<double, 3> high{box.high.x, box.high.y, box.high.z};
  std::array<double, 3> origin{};
  std::array<double, 3> count{};
  for (std::size_t a = 0; a < 3; ++a) {
    origin[a] = low[a] - (1.0 + random.uniform()) * spacing;
    count[a] = std::ceil((high[a] - origin[a]) / spacing) + 2.0;
  }
  const double voxels = count[0] * count[1] * count[2];
  if (!(voxels <= kMostVoxels)) {
    throw InputError("spacing", 0, "one that takes at most 5e7 voxels", std::to_string(voxels) + " voxels");
  }
  vtkNew<vtkImageData> image;
  image->SetDimensions(static_cast<int>(count[0]), static_cast<int>(count[1]), static_cast<int>(count[2]));
  image->SetSpacing(spacing, spacing, spacing);
  image->SetOrigin(origin.data());
  image->AllocateScalars(VTK_FLOAT, 1);
  return image;
}

}  // namespace

SurfaceMesh march_surface(const SurfaceMesh& surface, double spacing, std::uint64_t seed) {
  if (!(spacing > 0.0 && std::isfinite(spacing))) {
    throw InputError("spacing", 0, "a positive length", std::to_string(spacing));
  }
  const vtkNew<vtkPolyData> body = to_poly_data(surface);
  const vtkNew<vtkImageData> image = voxels_around(surface, spacing, seed);
  vtkNew<vtkImplicitPolyDataDistance> distance;
  distance->SetInput(body);
  auto* grey = static_cast<float*>(image->GetScalarPointer());
  for (vtkIdType v = 0; v < image->GetNumberOfPoints(); ++v) {
    std::array<double, 3> x{};
    image->GetPoint(v, x.data());
    const double voxels = std::clamp(distance->EvaluateFunction(x.data()) / spacing, -1.0, 1.0);
    grey[v] = static_cast<float>(-std::floor(kLevels * voxels));
  }
  vtkNew<vtkFlyingEdges3D> contour;
  contour->SetInputData(image);
  contour->SetValue(0, 0.5);  // between two levels: no voxel is on it
  contour->ComputeNormalsOff();
  contour->ComputeScalarsOff();
  contour->Update();
  return closed_surface_of(contour->GetOutput(), Vec3{});
}

}  // namespace palpate::reference
