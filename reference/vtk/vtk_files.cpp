#include <vtkCellType.h>
#include <vtkCellTypes.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>
#include <vtkUnstructuredGridReader.h>
#include <vtkXMLUnstructuredGridReader.h>
#include <vtkXMLUnstructuredGridWriter.h>

#include <array>
#include <exception>
#include <set>

#include "core/base/error.h"
#include "reference/vtk/vtk_tools.h"

namespace palpate::reference {
namespace {

/// Throws, beside InputError, whatever VTK or the standard library does.
vtkSmartPointer<vtkUnstructuredGrid> load_with_vtk(const std::filesystem::path& path) {
  const std::string where = path.string();
  vtkSmartPointer<vtkUnstructuredGrid> grid;
  if (path.extension() == ".vtu") {
    vtkNew<vtkXMLUnstructuredGridReader> reader;
    if (reader->CanReadFile(where.c_str()) == 0) {
      throw InputError(where, 0, "a .vtu file that VTK can read", "something else");
    }
    reader->SetFileName(where.c_str());
    reader->Update();
    if (reader->GetErrorCode() != 0) throw InputError(where, 0, "a whole .vtu file", "a broken one");
    grid = reader->GetOutput();
  } else {
    vtkNew<vtkUnstructuredGridReader> reader;
    reader->SetFileName(where.c_str());
    if (reader->IsFileUnstructuredGrid() == 0) {
      throw InputError(where, 0, "a .vtk file with an unstructured grid", "something else");
    }
    reader->Update();
    if (reader->GetErrorCode() != 0) throw InputError(where, 0, "a whole .vtk file", "a broken one");
    grid = reader->GetOutput();
  }
  if (grid == nullptr || grid->GetNumberOfCells() == 0) {
    throw InputError(where, 0, "a grid with cells", "none");
  }
  return grid;
}

vtkSmartPointer<vtkUnstructuredGrid> load(const std::filesystem::path& path) {
  try {
    return load_with_vtk(path);
  } catch (const InputError&) {
    throw;
  } catch (const std::exception& error) {  // a length below zero or beyond all bounds, as the file has it
    throw InputError(path.string(), 0, "a file that VTK can read", error.what());
  }
}

bool is_left_out(int kind) {
  return kind == VTK_VERTEX || kind == VTK_POLY_VERTEX || kind == VTK_LINE || kind == VTK_POLY_LINE ||
         kind == VTK_TRIANGLE;
}

}  // namespace

TetMesh read_grid(const std::filesystem::path& path, std::vector<std::string>& notes) {
  const std::string where = path.string();
  const auto grid = load(path);
  TetMesh mesh;
  for (vtkIdType i = 0; i < grid->GetNumberOfPoints(); ++i) {
    std::array<double, 3> p{};
    grid->GetPoint(i, p.data());
    mesh.points.push_back({p[0], p[1], p[2]});
    if (!is_finite(mesh.points.back())) throw InputError(where, 0, "finite coordinates", "NaN or infinity");
  }
  std::set<std::string> left_out;
  vtkNew<vtkIdList> corners;
  for (vtkIdType i = 0; i < grid->GetNumberOfCells(); ++i) {
    const int kind = grid->GetCellType(i);
    if (kind != VTK_TETRA) {
      const std::string name = vtkCellTypes::GetClassNameFromTypeId(kind);
      if (!is_left_out(kind))
        throw InputError(where, 0, "linear tetrahedra and triangles only", name + " cells");
      if (kind != VTK_TRIANGLE) left_out.insert(name);
      continue;
    }
    grid->GetCellPoints(i, corners);
    Tet tet{};
    for (std::size_t k = 0; k < 4; ++k) {
      const vtkIdType v = corners->GetId(static_cast<vtkIdType>(k));
      if (v < 0 || v >= grid->GetNumberOfPoints()) {
        throw InputError(where, 0, "corners that are points of the grid", std::to_string(v));
      }
      tet[k] = static_cast<Index>(v);
    }
    mesh.tets.push_back(tet);
  }
  for (const std::string& name : left_out) notes.push_back(name + " cells are left out");
  if (mesh.tets.empty()) throw InputError(where, 0, "tetrahedra", "none");
  return mesh;
}

void write_vtu(const std::filesystem::path& path, const TetMesh& mesh) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  for (const Vec3& p : mesh.points) points->InsertNextPoint(p.x, p.y, p.z);
  vtkNew<vtkUnstructuredGrid> grid;
  grid->SetPoints(points);
  grid->Allocate(static_cast<vtkIdType>(mesh.tets.size()));
  for (const Tet& t : mesh.tets) {
    const std::array<vtkIdType, 4> corners{t[0], t[1], t[2], t[3]};
    grid->InsertNextCell(VTK_TETRA, 4, corners.data());
  }
  vtkNew<vtkXMLUnstructuredGridWriter> writer;
  const std::string where = path.string();
  writer->SetFileName(where.c_str());
  writer->SetInputData(grid);
  writer->SetDataModeToAppended();
  writer->EncodeAppendedDataOff();
  if (writer->Write() == 0 || writer->GetErrorCode() != 0) {
    throw InputError(where, 0, "a place that can be written", "none, or a full disk");
  }
}

}  // namespace palpate::reference
