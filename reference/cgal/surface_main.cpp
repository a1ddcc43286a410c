// The CGAL surface program: reads and judges ("convert"), and remeshes ("mesh") closed surfaces.
// Built with CGAL, GPL: this program is distributed under GPL-3.0-or-later.
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/mesh/io/off.h"
#include "reference/cgal/surface_tools.h"
#include "reference/door/adapter.h"

namespace palpate::reference {
namespace {

/// Refuses a surface that bounds no volume, and says what may help.
void check_or_hint(const SurfaceMesh& surface, const std::string& where) {
  try {
    check_closed_surface(surface, where);
  } catch (const InputError& error) {
    throw InputError(std::string(error.what()) + "; --repair may mend it (in a scene: repair: true)");
  }
}

Response answer(const Request& request) {
  Response response;
  SurfaceMesh surface;
  const Stopwatch watch;
  if (request.contest == "convert" && request.method == "cgal.read_surface") {
    surface = read_surface(request.input);
    check_or_hint(surface, request.input.string());
  } else if (request.contest == "mesh" && request.method == "cgal.remesh_surface") {
    if (!request.options.contains("edge_length") || !request.options["edge_length"].is_number()) {
      throw InputError("request", 0, "the option edge_length", "none");
    }
    RemeshedSurface remeshed =
        remesh_surface(read_off(request.input), request.options["edge_length"].get<double>());
    surface = std::move(remeshed.surface);
    response.report["edge_length"] = remeshed.edge_length;
  } else {
    throw InputError("request", 0, "convert cgal.read_surface or mesh cgal.remesh_surface",
                     request.contest + " " + request.method);
  }
  response.kernel_s = watch.seconds();
  write_off(request.output, surface);
  response.report["vertices"] = surface.points.size();
  response.report["triangles"] = surface.triangles.size();
  return response;
}

}  // namespace
}  // namespace palpate::reference

int main(int argc, char** argv) {
  return palpate::reference::run_adapter(argc, argv, palpate::reference::answer);
}
