// Adapter of gmsh as a simplifier: the skin is kept, the inside is filled anew.
// Built with gmsh, GPL: this program is distributed under GPL-3.0-or-later.
#include <chrono>

#include "core/base/error.h"
#include "core/mesh/topology.h"
#include "reference/fusion_options.h"
#include "reference/gmsh/gmsh_tools.h"
#include "reference/remesh_run.h"

namespace palpate::reference {
namespace {

/// The mesh's boundary as a surface of its own: the vertices that it uses, in their order.
SurfaceMesh take_skin(const TetMesh& mesh) {
  SurfaceMesh skin;
  skin.triangles = build_boundary(mesh);
  std::vector<Index> index_of(mesh.points.size(), kNoIndex);
  for (const Triangle& t : skin.triangles) {
    for (const Index v : t) index_of[v] = 0;
  }
  for (std::size_t v = 0; v < index_of.size(); ++v) {
    if (index_of[v] == kNoIndex) continue;
    index_of[v] = static_cast<Index>(skin.points.size());
    skin.points.push_back(mesh.points[v]);
  }
  for (Triangle& t : skin.triangles) {
    for (Index& v : t) v = index_of[v];
  }
  return skin;
}

Response answer(const Request& request) {
  if (request.method != "gmsh.remesh") throw InputError("method", 0, "gmsh.remesh", request.method);
  require_all_taken(request.options);
  Remesher remesher;
  remesher.size_name = "interior_size";
  remesher.remesh = [](const TetMesh& mesh, std::uint64_t, double size) {
    const GmshSession session;
    const auto start = std::chrono::steady_clock::now();
    TimedMesh result;
    result.mesh = fill_surface(take_skin(mesh), size);
    result.kernel_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return result;
  };
  return run_remesher(request, remesher);
}

}  // namespace
}  // namespace palpate::reference

int main(int argc, char** argv) {
  return palpate::reference::run_adapter(argc, argv, palpate::reference::answer);
}
