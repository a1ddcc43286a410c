// Adapter of random edge collapses.
#include <limits>

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/mesh/io/medit.h"
#include "reference/door/request_options.h"
#include "reference/random/edge_collapse.h"
#include "reference/simplifier_support/remesh_run.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

EdgeCollapseOptions read_options(json left) {
  EdgeCollapseOptions options;
  options.seed =
      static_cast<std::uint64_t>(take_whole(left, "seed", 0, std::numeric_limits<std::int64_t>::max(), 0));
  options.candidates = static_cast<int>(take_whole(left, "candidates", 1, 1000, options.candidates));
  options.first_guard = take_number(left, "first_guard", 0.0, 1.0, options.first_guard);
  options.last_guard = take_number(left, "last_guard", 0.0, options.first_guard, options.last_guard);
  options.placement =
      take_choice(left, "placement", {"best", "midpoint"}) == 0 ? Placement::kBest : Placement::kMidpoint;
  require_all_taken(left);
  return options;
}

Response answer(const Request& request) {
  if (request.method != "random.edge_collapse") {
    throw InputError("method", 0, "random.edge_collapse", request.method);
  }
  EdgeCollapseOptions options = read_options(request.options);
  MeditFile file = read_medit(request.input);
  TetMesh& mesh = file.mesh;
  const bool to_the_limit = request.stop == json{{"limit", true}};
  if (!to_the_limit) options.target_tets = read_tet_target(request.stop, mesh.tets.size());
  Response response;
  response.notes = std::move(file.notes);
  response.report = {
      {"method", request.method}, {"vertices_in", mesh.points.size()}, {"tets_in", mesh.tets.size()}};

  const Stopwatch watch;
  const EdgeCollapseReport report = collapse_random_edges(mesh, options);
  response.kernel_s = watch.seconds();

  write_medit(request.output, mesh);
  response.report["vertices_out"] = mesh.points.size();
  response.report["tets_out"] = mesh.tets.size();
  response.report["collapses"] = report.collapses;
  response.report["stop"] = report.reached_target ? request.stop.begin().key() : "limit";
  response.report["rejected"] = {{"boundary", report.refused_boundary},
                                 {"flip", report.refused_flip},
                                 {"quality", report.refused_quality}};
  return response;
}

}  // namespace
}  // namespace palpate::reference

int main(int argc, char** argv) {
  return palpate::reference::run_adapter(argc, argv, palpate::reference::answer);
}
