// Adapter of CGAL's tetrahedral remeshing.
// Built with CGAL, GPL: this program is distributed under GPL-3.0-or-later.

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "reference/cgal/remesh.h"
#include "reference/door/request_options.h"
#include "reference/simplifier_support/remesh_run.h"

namespace palpate::reference {
namespace {

constexpr int kMostIterations = 1000;

RemeshSettings read_settings(const Request& request) {
  if (request.method != "cgal.remesh" && request.method != "cgal.remesh_free") {
    throw InputError("method", 0, "cgal.remesh or cgal.remesh_free", request.method);
  }
  RemeshSettings settings;
  settings.remesh_boundary = request.method == "cgal.remesh_free";
  nlohmann::json left = request.options;
  if (const auto given = left.find("iterations"); given != left.end()) {
    if (!given->is_number_integer() || *given < 1 || *given > kMostIterations) {
      throw InputError("iterations", 0, "a whole number from 1 to 1000", given->dump());
    }
    settings.iterations = given->get<unsigned>();
    left.erase(given);
  }
  require_all_taken(left);
  return settings;
}

Response answer(const Request& request) {
  const RemeshSettings common = read_settings(request);
  Remesher remesher;
  remesher.size_name = "edge_length";
  remesher.first_factor = 1.16;  // found on kidney, liver, bean and ball: 1.12 to 1.35
  remesher.remesh = [&](const TetMesh& mesh, std::uint64_t, double size) {
    RemeshSettings settings = common;
    settings.edge_length = size;
    const Stopwatch watch;
    TimedMesh result;
    result.mesh = remesh(mesh, settings);
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
