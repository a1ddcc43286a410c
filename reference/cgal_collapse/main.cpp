// Adapter of CGAL's surface edge collapse with gmsh's fill behind it.
// Built with CGAL, GPL: this program is distributed under GPL-3.0-or-later.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "reference/cgal_collapse/collapse.h"
#include "reference/cgal_collapse/fill.h"
#include "reference/door/request_options.h"
#include "reference/simplifier_support/remesh_run.h"
#include "reference/simplifier_support/skin.h"

namespace palpate::reference {
namespace {

namespace fs = std::filesystem;

/// A folder beside the output mesh, removed at the end.
class WorkFolder {
 public:
  explicit WorkFolder(const fs::path& output) : path_(output.string() + ".work") {
    std::error_code error;
    fs::create_directory(path_, error);
    if (error) throw InputError(path_.string(), 0, "a folder that can be made", error.message());
  }
  ~WorkFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  WorkFolder(const WorkFolder&) = delete;
  WorkFolder& operator=(const WorkFolder&) = delete;

  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

struct Settings {
  CollapseCost cost = CollapseCost::kLindstromTurk;
  double skin_edges_kept = 0.0;     ///< share of the skin's edges; 0: as the count of tets asks for
  double optimize_threshold = 0.3;  ///< of gmsh
  fs::path folder;                  ///< for the files between the two programs
};

/// Edges to leave. Without a share of its own a surface goes with the count of tets: it has as many elements
/// as the volume to the power of 2/3.
std::size_t edges_to_leave(std::size_t edges_in, std::size_t tets_in, std::uint64_t target, double kept) {
  const double share = static_cast<double>(target) / static_cast<double>(tets_in);
  constexpr double kTetrahedron = 6.0;
  const double wanted = static_cast<double>(edges_in) * (kept > 0.0 ? kept : std::pow(share, 2.0 / 3.0));
  return static_cast<std::size_t>(std::max(kTetrahedron, std::round(wanted)));
}

/// The timed kernel: skin, collapse, fill.
TimedMesh collapse_and_fill(const TetMesh& mesh, std::uint64_t target, double size,
                            const Settings& settings) {
  const Stopwatch watch;
  const SurfaceMesh skin = take_skin(mesh);
  const std::size_t edges_in = 3 * skin.triangles.size() / 2;
  const std::size_t edges = edges_to_leave(edges_in, mesh.tets.size(), target, settings.skin_edges_kept);
  const SurfaceMesh collapsed = collapse_edges(skin, {settings.cost, edges});
  const double collapse_s = watch.seconds();
  TimedMesh filled =
      fill_by_gmsh(collapsed, {{"interior_size", size}, {"optimize_threshold", settings.optimize_threshold}},
                   settings.folder);
  filled.kernel_s += collapse_s;
  return filled;
}

/// Takes a number from 0 to 1 out of `options`.
double take_share(nlohmann::json& options, const char* name, double preset) {
  const auto given = options.find(name);
  if (given == options.end()) return preset;
  if (!given->is_number() || !(*given >= 0.0 && *given <= 1.0)) {
    throw InputError(name, 0, "a number from 0 to 1", given->dump());
  }
  const auto value = given->get<double>();
  options.erase(given);
  return value;
}

Response answer(const Request& request) {
  if (request.method != "cgal.collapse") throw InputError("method", 0, "cgal.collapse", request.method);
  nlohmann::json left = request.options;
  Settings settings;
  constexpr std::array kCosts{CollapseCost::kLindstromTurk, CollapseCost::kGarlandHeckbert};
  settings.cost = kCosts[take_choice(left, "cost", {"lindstrom_turk", "garland_heckbert"})];
  settings.skin_edges_kept = take_share(left, "skin_edges_kept", settings.skin_edges_kept);
  settings.optimize_threshold = take_share(left, "optimize_threshold", settings.optimize_threshold);
  require_all_taken(left);
  const WorkFolder work(request.output);
  settings.folder = work.path();
  Remesher remesher;
  remesher.size_name = "interior_size";
  remesher.first_factor = 0.74;  // found on kidney, liver, bean and ball: 0.70 to 0.84
  remesher.remesh = [&](const TetMesh& mesh, std::uint64_t target, double size) {
    return collapse_and_fill(mesh, target, size, settings);
  };
  return run_remesher(request, remesher);
}

}  // namespace
}  // namespace palpate::reference

int main(int argc, char** argv) {
  return palpate::reference::run_adapter(argc, argv, palpate::reference::answer);
}
