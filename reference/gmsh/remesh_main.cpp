// Adapter of gmsh as a simplifier: the skin is kept, the inside is filled anew.
// Built with gmsh, GPL: this program is distributed under GPL-3.0-or-later.

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "reference/door/request_options.h"
#include "reference/gmsh/gmsh_tools.h"
#include "reference/simplifier_support/remesh_run.h"
#include "reference/simplifier_support/skin.h"

namespace palpate::reference {
namespace {

Response answer(const Request& request) {
  if (request.method != "gmsh.remesh") throw InputError("method", 0, "gmsh.remesh", request.method);
  nlohmann::json left = request.options;
  FillSettings common;
  common.optimize_threshold = take_optimize_threshold(left);
  require_all_taken(left);
  Remesher remesher;
  remesher.size_name = "interior_size";
  remesher.first_factor = 0.74;  // found on kidney, liver, bean and ball: 0.70 to 0.84
  remesher.remesh = [common](const TetMesh& mesh, std::uint64_t, double size) {
    const GmshSession session;
    FillSettings settings = common;
    settings.interior_size = size;
    const Stopwatch watch;
    TimedMesh result;
    const SurfaceMesh skin = take_skin(mesh);
    result.mesh = fill_surface(skin, settings);
    result.kernel_s = watch.seconds();
    check_filled(skin, result.mesh);
    return result;
  };
  return run_remesher(request, remesher);
}

}  // namespace
}  // namespace palpate::reference

int main(int argc, char** argv) {
  return palpate::reference::run_adapter(argc, argv, palpate::reference::answer);
}
