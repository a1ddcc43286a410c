// Adapter of Netgen as a simplifier: the skin is kept, the inside is filled anew.
#include <array>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>

namespace nglib {
#include <nglib.h>
}

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "core/mesh/geometry.h"
#include "reference/door/request_options.h"
#include "reference/simplifier_support/remesh_run.h"
#include "reference/simplifier_support/skin.h"

namespace palpate::reference {
namespace {

/// Options of the method.
struct FrontSettings {
  int optimize_steps = 3;
  double grading = 0.3;
};

constexpr int kMostSteps = 20;

/// Netgen's library and one mesh of it, as long as this lives.
class NetgenMesh {
 public:
  NetgenMesh() {
    nglib::Ng_Init();
    mesh_ = nglib::Ng_NewMesh();
  }
  ~NetgenMesh() {
    nglib::Ng_DeleteMesh(mesh_);
    nglib::Ng_Exit();
  }
  NetgenMesh(const NetgenMesh&) = delete;
  NetgenMesh& operator=(const NetgenMesh&) = delete;

  nglib::Ng_Mesh* get() const { return mesh_; }

 private:
  nglib::Ng_Mesh* mesh_;
};

void add_skin(const SurfaceMesh& skin, nglib::Ng_Mesh* mesh) {
  for (const Vec3& p : skin.points) {
    std::array<double, 3> place{p.x, p.y, p.z};
    nglib::Ng_AddPoint(mesh, place.data());
  }
  for (const Triangle& face : skin.triangles) {
    std::array<int, 3> corners{};
    for (std::size_t i = 0; i < 3; ++i) corners[i] = static_cast<int>(face[i]) + 1;
    nglib::Ng_AddSurfaceElement(mesh, nglib::NG_TRIG, corners.data());
  }
}

TetMesh take_volume(nglib::Ng_Mesh* mesh) {
  TetMesh out;
  const int points = nglib::Ng_GetNP(mesh);
  out.points.reserve(static_cast<std::size_t>(points));
  for (int v = 1; v <= points; ++v) {
    std::array<double, 3> place{};
    nglib::Ng_GetPoint(mesh, v, place.data());
    out.points.push_back({place[0], place[1], place[2]});
  }
  const int tets = nglib::Ng_GetNE(mesh);
  out.tets.reserve(static_cast<std::size_t>(tets));
  for (int t = 1; t <= tets; ++t) {
    std::array<int, NG_VOLUME_ELEMENT_MAXPOINTS> corners{};
    if (nglib::Ng_GetVolumeElement(mesh, t, corners.data()) != nglib::NG_TET)
      throw std::runtime_error("Netgen made an element that is no linear tetrahedron");
    Tet tet{};
    for (std::size_t i = 0; i < 4; ++i) tet[i] = static_cast<Index>(corners[i] - 1);
    if (signed_volume(out.points[tet[0]], out.points[tet[1]], out.points[tet[2]], out.points[tet[3]]) < 0.0)
      std::swap(tet[0], tet[1]);
    out.tets.push_back(tet);
  }
  return out;
}

TimedMesh fill(const TetMesh& mesh, double size, const FrontSettings& settings) {
  const NetgenMesh netgen;
  const Stopwatch watch;
  TimedMesh result;
  const SurfaceMesh skin = take_skin(mesh);
  add_skin(skin, netgen.get());
  nglib::Ng_Meshing_Parameters parameters;
  parameters.maxh = size;
  parameters.fineness = 1.0;
  parameters.grading = settings.grading;
  parameters.optsteps_3d = settings.optimize_steps;
  parameters.optvolmeshenable = settings.optimize_steps > 0 ? 1 : 0;
  const nglib::Ng_Result end = nglib::Ng_GenerateVolumeMesh(netgen.get(), &parameters);
  if (end != nglib::NG_OK) throw std::runtime_error("Netgen ended with its result " + std::to_string(end));
  result.mesh = take_volume(netgen.get());
  result.kernel_s = watch.seconds();
  if (result.mesh.tets.empty()) throw std::runtime_error("Netgen left no tetrahedron");
  for (std::size_t v = 0; v < skin.points.size(); ++v) {
    if (!(result.mesh.points[v] == skin.points[v]))
      throw std::runtime_error("Netgen moved a vertex of the skin");
  }
  return result;
}

Response answer(const Request& request) {
  if (request.method != "netgen.remesh") throw InputError("method", 0, "netgen.remesh", request.method);
  nlohmann::json left = request.options;
  FrontSettings settings;
  settings.optimize_steps =
      static_cast<int>(take_whole(left, "optimize_steps", 0, kMostSteps, settings.optimize_steps));
  settings.grading = take_number(left, "grading", 0.0, 1.0, settings.grading);
  require_all_taken(left);
  Remesher remesher;
  remesher.size_name = "longest_edge";
  remesher.remesh = [settings](const TetMesh& mesh, std::uint64_t, double size) {
    return fill(mesh, size, settings);
  };
  return run_remesher(request, remesher);
}

}  // namespace
}  // namespace palpate::reference

int main(int argc, char** argv) {
  return palpate::reference::run_adapter(argc, argv, palpate::reference::answer);
}
