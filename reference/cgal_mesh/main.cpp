// Adapter of CGAL's Mesh_3 as a simplifier: skin and inside are made anew.
// Built with CGAL, GPL: this program is distributed under GPL-3.0-or-later.
#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "reference/cgal_mesh/mesh.h"
#include "reference/door/request_options.h"
#include "reference/simplifier_support/remesh_run.h"
#include "reference/simplifier_support/skin.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

constexpr double kLeastDistance = 1e-3;

DelaunaySettings read_settings(const Request& request) {
  if (request.method != "cgal.mesh_3") throw InputError("method", 0, "cgal.mesh_3", request.method);
  json left = request.options;
  DelaunaySettings settings;
  settings.facet_distance = take_number(left, "facet_distance", kLeastDistance, 1.0, settings.facet_distance);
  if (left.contains("feature_deg")) {
    settings.feature_deg = take_number(left, "feature_deg", 0.0, 180.0, 0.0);
    if (!(settings.feature_deg > 0.0 && settings.feature_deg < 180.0))
      throw InputError("feature_deg", 0, "degrees between 0 and 180", std::to_string(settings.feature_deg));
  }
  settings.perturb = take_option<bool>(left, "perturb", &json::is_boolean, "true or false", settings.perturb);
  settings.exude = take_option<bool>(left, "exude", &json::is_boolean, "true or false", settings.exude);
  require_all_taken(left);
  return settings;
}

Response answer(const Request& request) {
  const DelaunaySettings common = read_settings(request);
  Remesher remesher;
  remesher.size_name = "cell_size";
  remesher.first_factor = 0.83;  // found on kidney, liver, bean and ball: 0.80 to 0.93
  remesher.remesh = [&](const TetMesh& mesh, std::uint64_t, double size) {
    DelaunaySettings settings = common;
    settings.size = size;
    const Stopwatch watch;
    TimedMesh result;
    result.mesh = mesh_inside(take_skin(mesh), settings);
    result.kernel_s = watch.seconds();
    return result;
  };
  return run_remesher(request, remesher);
}

}  // namespace
}  // namespace palpate::reference

int main(int argc, char** argv) {
  return palpate::reference::run_adapter(argc, argv, palpate::reference::answer);
}
