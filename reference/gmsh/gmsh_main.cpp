// The gmsh program: fills surfaces ("mesh") and reads .msh files ("convert").
// Built with gmsh, GPL: this program is distributed under GPL-3.0-or-later.

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/io/off.h"
#include "reference/door/adapter.h"
#include "reference/gmsh/gmsh_tools.h"

namespace palpate::reference {

namespace {

/// Fills a surface; the clock runs from the surface in memory to the mesh in memory.
TetMesh fill(const Request& request, double& kernel_s) {
  if (!request.options.contains("interior_size") || !request.options["interior_size"].is_number()) {
    throw InputError("request", 0, "the option interior_size", "none");
  }
  nlohmann::json options = request.options;
  const double threshold = take_optimize_threshold(options);
  const SurfaceMesh surface = read_off(request.input);
  const Stopwatch watch;
  TetMesh mesh = fill_surface(surface, {options["interior_size"].get<double>(), threshold});
  kernel_s = watch.seconds();
  check_filled(surface, mesh);
  return mesh;
}

Response answer(const Request& request) {
  const GmshSession session;
  Response response;
  TetMesh mesh;
  if (request.contest == "mesh" && request.method == "gmsh.delaunay") {
    mesh = fill(request, response.kernel_s);
  } else if (request.contest == "convert" && request.method == "gmsh.read") {
    const Stopwatch watch;
    mesh = read_msh(request.input, request.output.parent_path(), response.notes);
    response.kernel_s = watch.seconds();
  } else {
    throw InputError("request", 0, "mesh gmsh.delaunay or convert gmsh.read",
                     request.contest + " " + request.method);
  }
  write_medit(request.output, mesh);
  response.report = {{"vertices", mesh.points.size()}, {"tets", mesh.tets.size()}};
  return response;
}

}  // namespace
}  // namespace palpate::reference

int main(int argc, char** argv) {
  return palpate::reference::run_adapter(argc, argv, palpate::reference::answer);
}
