// Adapter of CGAL's surface edge collapse with gmsh's fill behind it.
// Built with CGAL, GPL: this program is distributed under GPL-3.0-or-later.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <system_error>

#include "core/base/error.h"
#include "reference/cgal_collapse/collapse.h"
#include "reference/cgal_collapse/fill.h"
#include "reference/fusion_options.h"
#include "reference/remesh_run.h"
#include "reference/skin.h"

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

/// Edges of a surface that goes with the count of tets: a surface has as many elements as the volume to the
/// power of 2/3.
std::size_t surface_edges(std::size_t edges_in, std::size_t tets_in, std::uint64_t target) {
  const double share = static_cast<double>(target) / static_cast<double>(tets_in);
  constexpr double kTetrahedron = 6.0;
  return static_cast<std::size_t>(
      std::max(kTetrahedron, std::round(static_cast<double>(edges_in) * std::pow(share, 2.0 / 3.0))));
}

/// The timed kernel: skin, collapse, fill.
TimedMesh collapse_and_fill(const TetMesh& mesh, std::uint64_t target, double size, CollapseCost cost,
                            const fs::path& folder) {
  const auto start = std::chrono::steady_clock::now();
  const SurfaceMesh skin = take_skin(mesh);
  const std::size_t edges_in = 3 * skin.triangles.size() / 2;
  const SurfaceMesh collapsed =
      collapse_edges(skin, {cost, surface_edges(edges_in, mesh.tets.size(), target)});
  const double collapse_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  TimedMesh filled = fill_by_gmsh(collapsed, size, folder);
  filled.kernel_s += collapse_s;
  return filled;
}

Response answer(const Request& request) {
  if (request.method != "cgal.collapse") throw InputError("method", 0, "cgal.collapse", request.method);
  nlohmann::json left = request.options;
  constexpr std::array kCosts{CollapseCost::kLindstromTurk, CollapseCost::kGarlandHeckbert};
  const CollapseCost cost = kCosts[take_choice(left, "cost", {"lindstrom_turk", "garland_heckbert"})];
  require_all_taken(left);
  const WorkFolder work(request.output);
  Remesher remesher;
  remesher.size_name = "interior_size";
  remesher.first_factor = 0.74;  // found on kidney, liver, bean and ball: 0.70 to 0.84
  remesher.remesh = [&](const TetMesh& mesh, std::uint64_t target, double size) {
    return collapse_and_fill(mesh, target, size, cost, work.path());
  };
  return run_remesher(request, remesher);
}

}  // namespace
}  // namespace palpate::reference

int main(int argc, char** argv) {
  return palpate::reference::run_adapter(argc, argv, palpate::reference::answer);
}
