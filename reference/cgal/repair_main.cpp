// The CGAL repair program: mends closed surfaces ("convert").
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

/// Mends the surface. Throws: InputError with what was tried if it still bounds no volume.
SurfaceMesh repair_or_refuse(const SurfaceMesh& surface, const std::string& where, Response& response) {
  SurfaceRepair repair = repair_surface(surface);
  try {
    check_closed_surface(repair.surface, where);
  } catch (const InputError& error) {
    throw InputError(std::string(error.what()) + "; " + repair.text() + ", which did not mend it");
  }
  response.notes.push_back(repair.text());
  response.report = {
      {"points_merged", repair.points_merged},       {"triangles_dropped", repair.triangles_dropped},
      {"pieces_dropped", repair.pieces_dropped},     {"points_split", repair.points_split},
      {"holes_filled", repair.holes_filled},         {"intersecting_pairs", repair.intersecting_pairs},
      {"triangles_turned", repair.triangles_turned}, {"volume_after", repair.volume_after}};
  return std::move(repair.surface);
}

Response answer(const Request& request) {
  if (request.contest != "convert" || request.method != "cgal.repair_surface")
    throw InputError("request", 0, "convert cgal.repair_surface", request.contest + " " + request.method);
  Response response;
  const Stopwatch watch;
  const SurfaceMesh surface = repair_or_refuse(read_surface(request.input), request.input.string(), response);
  response.kernel_s = watch.seconds();
  write_off(request.output, surface);
  return response;
}

}  // namespace
}  // namespace palpate::reference

int main(int argc, char** argv) {
  return palpate::reference::run_adapter(argc, argv, palpate::reference::answer);
}
