#include "core/mesh/io/displacement_vtu.h"

#include <string>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/base/number_text.h"

namespace palpate {
namespace {

void append_vectors(std::string& text, std::span<const Vec3> vectors) {
  for (const Vec3& v : vectors) {
    append_number(text, v.x);
    text += ' ';
    append_number(text, v.y);
    text += ' ';
    append_number(text, v.z);
    text += '\n';
  }
}

constexpr const char* kEndArray = "</DataArray>\n";

}  // namespace

void write_displacement_vtu(const std::filesystem::path& path, const TetMesh& mesh,
                            std::span<const Vec3> displacement_m) {
  require(displacement_m.size() == mesh.points.size(), "write_displacement_vtu: one displacement a vertex");
  constexpr const char* kVtkTetra = "10";
  std::string text =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
      "byte_order=\"LittleEndian\">\n"
      "<UnstructuredGrid>\n<Piece NumberOfPoints=\"";
  append_number(text, mesh.points.size());
  text += "\" NumberOfCells=\"";
  append_number(text, mesh.tets.size());
  text +=
      "\">\n<PointData Vectors=\"displacement_m\">\n<DataArray type=\"Float64\" Name=\"displacement_m\" "
      "NumberOfComponents=\"3\" format=\"ascii\">\n";
  append_vectors(text, displacement_m);
  text += kEndArray;
  text += "</PointData>\n<Points>\n<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">\n";
  append_vectors(text, mesh.points);
  text += kEndArray;
  text += "</Points>\n<Cells>\n<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">\n";
  for (const Tet& tet : mesh.tets) {
    for (const Index vertex : tet) {
      append_number(text, vertex);
      text += ' ';
    }
    text += '\n';
  }
  text += kEndArray;
  text += "<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">\n";
  for (std::size_t i = 1; i <= mesh.tets.size(); ++i) {
    append_number(text, 4 * i);
    text += '\n';
  }
  text += kEndArray;
  text += "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">\n";
  for (std::size_t i = 0; i < mesh.tets.size(); ++i) {
    text += kVtkTetra;
    text += '\n';
  }
  text += kEndArray;
  text += "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
  write_file_atomically(path, text);
}

}  // namespace palpate
