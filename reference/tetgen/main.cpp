// Adapter of TetGen as a simplifier: inner vertices are removed, the skin is kept.
// Built with TetGen, AGPL: this program is distributed under AGPL-3.0-or-later.
#include <tetgen.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/base/stopwatch.h"
#include "core/mesh/geometry.h"
#include "core/mesh/topology.h"
#include "reference/door/request_options.h"
#include "reference/simplifier_support/remesh_run.h"

namespace palpate::reference {
namespace {

/// Options of the method.
struct CoarsenSettings {
  double radius_edge_ratio = 1.1;
  int optimize_level = 10;
};

constexpr double kLeastShare = 1e-3;  ///< of the inner vertices: TetGen reads 0 as its default, all of them
constexpr double kMostRatio = 10.0;
constexpr int kMostLevel = 10;

/// TetGen counts the other way round: its tets are negative by our orientation.
void hand_over(const TetMesh& mesh, tetgenio& in) {
  in.firstnumber = 0;
  in.numberofpoints = static_cast<int>(mesh.points.size());
  in.pointlist = new REAL[3 * mesh.points.size()];
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    in.pointlist[3 * v] = mesh.points[v].x;
    in.pointlist[3 * v + 1] = mesh.points[v].y;
    in.pointlist[3 * v + 2] = mesh.points[v].z;
  }
  in.numberofcorners = 4;
  in.numberoftetrahedra = static_cast<int>(mesh.tets.size());
  in.tetrahedronlist = new int[4 * mesh.tets.size()];
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const Tet& tet = mesh.tets[t];
    const std::array<Index, 4> turned{tet[1], tet[0], tet[2], tet[3]};
    for (std::size_t i = 0; i < 4; ++i) in.tetrahedronlist[4 * t + i] = static_cast<int>(turned[i]);
  }
  // Each face a facet of its own: TetGen flips edges within a flat one, -Y or not.
  const std::vector<Triangle> boundary = build_boundary(mesh);
  in.numberoftrifaces = static_cast<int>(boundary.size());
  in.trifacelist = new int[3 * boundary.size()];
  in.trifacemarkerlist = new int[boundary.size()];
  for (std::size_t f = 0; f < boundary.size(); ++f) {
    for (std::size_t i = 0; i < 3; ++i) in.trifacelist[3 * f + i] = static_cast<int>(boundary[f][i]);
    in.trifacemarkerlist[f] = static_cast<int>(f) + 1;
  }
}

TetMesh take_back(const tetgenio& out) {
  TetMesh mesh;
  mesh.points.reserve(static_cast<std::size_t>(out.numberofpoints));
  for (std::ptrdiff_t v = 0; v < out.numberofpoints; ++v) {
    const REAL* p = out.pointlist + 3 * v;
    mesh.points.push_back({p[0], p[1], p[2]});
  }
  mesh.tets.reserve(static_cast<std::size_t>(out.numberoftetrahedra));
  for (std::ptrdiff_t t = 0; t < out.numberoftetrahedra; ++t) {
    const int* tet = out.tetrahedronlist + 4 * t;
    mesh.tets.push_back({static_cast<Index>(tet[1]), static_cast<Index>(tet[0]), static_cast<Index>(tet[2]),
                         static_cast<Index>(tet[3])});
    const Tet& now = mesh.tets.back();
    if (signed_volume(mesh.points[now[0]], mesh.points[now[1]], mesh.points[now[2]], mesh.points[now[3]]) <
        0.0)
      std::swap(mesh.tets.back()[0], mesh.tets.back()[1]);
  }
  return mesh;
}

/// Removes `share` of the inner vertices.
TimedMesh coarsen(const TetMesh& mesh, double share, const CoarsenSettings& settings) {
  tetgenio in;
  tetgenio out;
  hand_over(mesh, in);
  std::string switches = "rq" + short_number(settings.radius_edge_ratio) + "R1/" +
                         short_number(std::clamp(share, kLeastShare, 1.0)) + "O" +
                         std::to_string(settings.optimize_level) + "/7YQ";
  const Stopwatch watch;
  try {
    tetrahedralize(switches.data(), &in, &out);
  } catch (int code) {  // how TetGen says that it failed
    throw std::runtime_error("TetGen ended with its error " + std::to_string(code));
  }
  TimedMesh result;
  result.mesh = take_back(out);
  result.kernel_s = watch.seconds();
  if (result.mesh.tets.empty()) throw std::runtime_error("TetGen left no tetrahedron");
  return result;
}

/// The search goes by an edge length, with which a count falls as its third power: the share of the inner
/// vertices that is left does so from the length of the mesh's own edges on.
double share_to_remove(const TetMesh& mesh, double size) {
  constexpr double kEdgeCubedPerVolume = 8.485281374238571;  // 6 sqrt(2): of a regular tet
  const double own =
      std::cbrt(kEdgeCubedPerVolume * total_volume(mesh) / static_cast<double>(mesh.tets.size()));
  return 1.0 - std::min(1.0, std::pow(own / size, 3.0));
}

Response answer(const Request& request) {
  if (request.method != "tetgen.coarsen") throw InputError("method", 0, "tetgen.coarsen", request.method);
  nlohmann::json left = request.options;
  CoarsenSettings settings;
  settings.radius_edge_ratio =
      take_number(left, "radius_edge_ratio", 1.0, kMostRatio, settings.radius_edge_ratio);
  settings.optimize_level =
      static_cast<int>(take_whole(left, "optimize_level", 0, kMostLevel, settings.optimize_level));
  require_all_taken(left);
  Remesher remesher;
  remesher.size_name = "size";
  remesher.remesh = [settings](const TetMesh& mesh, std::uint64_t, double size) {
    return coarsen(mesh, share_to_remove(mesh, size), settings);
  };
  return run_remesher(request, remesher);
}

}  // namespace
}  // namespace palpate::reference

int main(int argc, char** argv) {
  return palpate::reference::run_adapter(argc, argv, palpate::reference::answer);
}
