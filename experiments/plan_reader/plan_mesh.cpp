#include "experiments/plan_reader/plan_mesh.h"

#include <set>

#include "experiments/plan_reader/plan_report.h"
#include "experiments/scene_reader/shape_fields.h"

namespace palpate::experiments {
namespace {

PlanMesh read_mesh_entry(const YamlValue& value, const std::filesystem::path& folder) {
  const YamlFields fields = value.fields(with_shape_keys({"name", "make", "file", "tags"}));
  PlanMesh mesh;
  mesh.name = fields.need("name").identifier();
  mesh.tags = read_tags(fields);
  const auto make = fields.find("make");
  const auto file = fields.find("file");
  if (make.has_value() == file.has_value()) value.fail("a mesh needs one of \"make\" and \"file\"");
  if (make) {
    mesh.shape = read_shape_fields(fields, *make);
    return mesh;
  }
  refuse_shape_keys(fields);
  mesh.file = folder / file->text();
  mesh.where = file->file() + ":" + std::to_string(file->line());
  if (is_surface_file(mesh.file))
    file->fail("expected a mesh in .mesh, .msh, .vtk or .vtu, found a surface, " + mesh.file.string() +
               " (palpate mesh fills it)");
  if (!is_mesh_file(mesh.file)) file->fail_expected("a mesh in .mesh, .msh, .vtk or .vtu");
  std::error_code error;
  if (!std::filesystem::is_regular_file(mesh.file, error)) {
    file->fail("expected a mesh file, found none at " + mesh.file.string());
  }
  return mesh;
}

}  // namespace

std::vector<PlanMesh> read_meshes(const YamlValue& value, const std::filesystem::path& folder) {
  std::vector<PlanMesh> meshes;
  std::set<std::string> names;
  for (const YamlValue& item : value.items()) {
    meshes.push_back(read_mesh_entry(item, folder));
    if (!names.insert(meshes.back().name).second) item.fail("mesh \"" + meshes.back().name + "\" twice");
  }
  if (meshes.empty()) value.fail("meshes: expected at least one");
  return meshes;
}

}  // namespace palpate::experiments
