// Adapter of VTK's quadric decimation of tetrahedral grids.
#include <vtkCellArray.h>
#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkObject.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkUnstructuredGrid.h>
#include <vtkUnstructuredGridQuadricDecimation.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <vector>

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/space_order.h"
#include "reference/door/request_options.h"
#include "reference/simplifier_support/remesh_run.h"
#include "reference/simplifier_support/size_search.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

constexpr double kWorthANote = 0.005;

/// The scalar field that the filter wants beside the positions, and that its quadrics keep too.
enum class Scalar {
  kZero,   ///< none: only positions count
  kRadius  ///< distance from the middle of the bounding box
};

/// How vertices and tets are numbered when the filter gets them. Its tables are by place in memory, so that
/// its time depends on it, up to five times on organs of a million tets.
enum class Order {
  kGiven,  ///< as in the file
  kSpace   ///< along a space-filling curve
};

struct QuadricOptions {
  unsigned seed = 1;
  Order order = Order::kGiven;
  Scalar scalar = Scalar::kZero;
  int candidates = 8;
  bool auto_add_candidates = true;
  double auto_add_threshold = 0.4;
  double boundary_weight = 100.0;
};

QuadricOptions read_options(json left) {
  constexpr std::int64_t kLargest = std::numeric_limits<int>::max();
  QuadricOptions options;
  options.seed = static_cast<unsigned>(take_whole(left, "seed", 0, kLargest, options.seed));
  options.scalar = take_choice(left, "scalar", {"zero", "radius"}) == 0 ? Scalar::kZero : Scalar::kRadius;
  options.order = take_choice(left, "order", {"given", "space"}) == 0 ? Order::kGiven : Order::kSpace;
  options.candidates = static_cast<int>(take_whole(left, "candidates", 1, kLargest, options.candidates));
  options.auto_add_candidates = take_option<bool>(left, "auto_add_candidates", &json::is_boolean,
                                                  "true or false", options.auto_add_candidates);
  options.auto_add_threshold = take_number(left, "auto_add_threshold", 0.0, 1e9, options.auto_add_threshold);
  options.boundary_weight = take_number(left, "boundary_weight", 0.0, 1e9, options.boundary_weight);
  require_all_taken(left);
  return options;
}

vtkNew<vtkUnstructuredGrid> build_grid(const TetMesh& mesh, Scalar scalar) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(static_cast<vtkIdType>(mesh.points.size()));
  Vec3 low = mesh.points.front();
  Vec3 high = low;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const Vec3& p = mesh.points[v];
    points->SetPoint(static_cast<vtkIdType>(v), p.x, p.y, p.z);
    low = {std::fmin(low.x, p.x), std::fmin(low.y, p.y), std::fmin(low.z, p.z)};
    high = {std::fmax(high.x, p.x), std::fmax(high.y, p.y), std::fmax(high.z, p.z)};
  }
  vtkNew<vtkDoubleArray> field;
  field->SetName("scalar");
  field->SetNumberOfValues(static_cast<vtkIdType>(mesh.points.size()));
  const Vec3 middle = 0.5 * (low + high);
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    field->SetValue(static_cast<vtkIdType>(v),
                    scalar == Scalar::kZero ? 0.0 : std::sqrt(length_sq(mesh.points[v] - middle)));
  }
  vtkNew<vtkCellArray> cells;
  for (const Tet& t : mesh.tets) {
    const std::array<vtkIdType, 4> ids{t[0], t[1], t[2], t[3]};
    cells->InsertNextCell(4, ids.data());
  }
  vtkNew<vtkUnstructuredGrid> grid;
  grid->SetPoints(points);
  grid->SetCells(VTK_TETRA, cells);
  grid->GetPointData()->SetScalars(field);
  return grid;
}

/// The grid as it is, whatever the orientation of its tets; points that no tet uses are left out.
TetMesh take_mesh(vtkUnstructuredGrid& grid) {
  TetMesh mesh;
  std::vector<Index> number(static_cast<std::size_t>(grid.GetNumberOfPoints()), kNoIndex);
  for (vtkIdType c = 0; c < grid.GetNumberOfCells(); ++c) {
    vtkIdType size = 0;
    const vtkIdType* ids = nullptr;
    grid.GetCellPoints(c, size, ids);
    if (grid.GetCellType(c) != VTK_TETRA || size != 4) {
      throw std::runtime_error("VTK left a cell that is no tetrahedron");
    }
    Tet tet{};
    for (std::size_t k = 0; k < 4; ++k) {
      Index& index = number[static_cast<std::size_t>(ids[k])];
      if (index == kNoIndex) {
        index = static_cast<Index>(mesh.points.size());
        std::array<double, 3> p{};
        grid.GetPoint(ids[k], p.data());
        mesh.points.push_back({p[0], p[1], p[2]});
      }
      tet[k] = index;
    }
    mesh.tets.push_back(tet);
  }
  return mesh;
}

/// What the clock does not count.
void check_answer(const TetMesh& mesh) {
  if (mesh.tets.empty()) throw std::runtime_error("VTK left no tetrahedron");
  for (const Vec3& p : mesh.points) {
    if (!is_finite(p)) throw std::runtime_error("VTK left a point without finite coordinates");
  }
}

Response answer(const Request& request) {
  if (request.method != "vtk.quadric") throw InputError("method", 0, "vtk.quadric", request.method);
  vtkObject::GlobalWarningDisplayOff();
  const QuadricOptions options = read_options(request.options);
  MeditFile file = read_medit(request.input);
  const std::uint64_t target = read_tet_target(request.stop, file.mesh.tets.size());
  Response response;
  response.notes = std::move(file.notes);

  const Stopwatch watch;
  std::srand(options.seed);
  if (options.order == Order::kSpace) sort_in_space(file.mesh);
  const vtkNew<vtkUnstructuredGrid> grid = build_grid(file.mesh, options.scalar);
  vtkNew<vtkUnstructuredGridQuadricDecimation> decimation;
  decimation->SetInputData(grid);
  decimation->SetScalarsName("scalar");
  decimation->SetNumberOfTetsOutput(static_cast<int>(target));
  decimation->SetNumberOfCandidates(options.candidates);
  decimation->SetAutoAddCandidates(options.auto_add_candidates ? 1 : 0);
  decimation->SetAutoAddCandidatesThreshold(options.auto_add_threshold);
  decimation->SetBoundaryWeight(options.boundary_weight);
  decimation->Update();
  const TetMesh out = take_mesh(*decimation->GetOutput());
  response.kernel_s = watch.seconds();

  check_answer(out);
  write_medit(request.output, out);
  const double mismatch = count_mismatch(out.tets.size(), target);
  if (std::fabs(mismatch) > kWorthANote) {
    response.notes.push_back("VTK ended with " + std::to_string(out.tets.size()) + " tetrahedra, where " +
                             std::to_string(target) + " were asked for");
  }
  response.report = {{"method", request.method},          {"vertices_in", file.mesh.points.size()},
                     {"vertices_out", out.points.size()}, {"tets_in", file.mesh.tets.size()},
                     {"tets_out", out.tets.size()},       {"target_tets", target},
                     {"stop", request.stop.begin().key()}};
  return response;
}

}  // namespace
}  // namespace palpate::reference

int main(int argc, char** argv) {
  return palpate::reference::run_adapter(argc, argv, palpate::reference::answer);
}
