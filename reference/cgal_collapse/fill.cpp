#include "reference/cgal_collapse/fill.h"

#include <stdexcept>

#include "core/base/atomic_file.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/io/off.h"
#include "reference/door/json_file.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

std::filesystem::path tool_beside_this_program() {
  return std::filesystem::read_symlink("/proc/self/exe").parent_path() / "palpate_gmsh";
}

json read_response(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) return json::object();
  json value = read_json_file(path);
  return value.is_object() ? value : json::object();
}

}  // namespace

TimedMesh fill_by_gmsh(const SurfaceMesh& surface, const json& options, const std::filesystem::path& folder) {
  const auto skin_file = folder / "skin.off";
  const auto mesh_file = folder / "filled.mesh";
  const auto request_file = folder / "fill_request.json";
  const auto response_file = folder / "fill_response.json";
  write_off(skin_file, surface);
  std::filesystem::remove(response_file);
  const json request{{"schema", "palpate/request/1"},
                     {"contest", "mesh"},
                     {"method", "gmsh.delaunay"},
                     {"surface_in", skin_file.string()},
                     {"mesh_out", mesh_file.string()},
                     {"options", options},
                     {"threads", 1}};
  write_file_atomically(request_file, request.dump());
  const int code =
      run_program({tool_beside_this_program().string(), request_file.string(), response_file.string()});
  const json response = read_response(response_file);
  if (code != 0 || response.value("status", json()) != "ok") {
    const json message = response.value("message", json());
    throw std::runtime_error(message.is_string()
                                 ? message.get<std::string>()
                                 : "palpate_gmsh left with exit code " + std::to_string(code));
  }
  return {response.at("kernel_s").get<double>(), read_medit(mesh_file, ReadOrientation::kKeep).mesh};
}

}  // namespace palpate::reference
