// Adapter of MAdLib as a simplifier: local modifications towards one edge length, the skin constrained.
#include <MAdLib/AdaptInterface.h>
#include <MAdLib/MeshDataBaseInterface.h>
#include <MAdLib/ModelInterface.h>
#include <MAdLib/PWLinearSField.h>

#include <algorithm>
#include <array>
#include <memory>
#include <stdexcept>
#include <string>
#include <unordered_map>

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
struct AdaptSettings {
  double sliver_quality = 0.02;
  double no_swap_quality = 0.1;
};

constexpr int kSilent = -1;

/// MAdLib's vertices and faces are entities, but its installed headers do not say so.
template <typename Part>
MAd::pEntity as_entity(Part part) {
  return reinterpret_cast<MAd::pEntity>(part);  // NOLINT(cppcoreguidelines-pro-type-reinterpret-cast)
}

/// A mesh of MAdLib and the model that its entities are classified on.
class AdaptedMesh {
 public:
  explicit AdaptedMesh(const TetMesh& mesh) {
    MAd::GM_create(&model_, "");
    mesh_ = MAd::M_new(model_);
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
      const Vec3& p = mesh.points[v];
      MAd::M_createV(mesh_, p.x, p.y, p.z, static_cast<int>(v) + 1);
    }
    MAd::pGEntity const body = MAd::GM_entityByTag(model_, 3, 1);
    MAd::pGEntity const skin = MAd::GM_entityByTag(model_, 2, 1);
    for (const Tet& tet : mesh.tets) {
      std::array<int, 4> corners = numbers(tet);
      MAd::M_createR(mesh_, 4, corners.data(), body);
    }
    for (const Triangle& face : build_boundary(mesh)) {
      std::array<int, 3> corners = numbers(face);
      MAd::M_createF(mesh_, 3, corners.data(), skin);
    }
    MAd::M_classifyEntities(mesh_);
  }
  ~AdaptedMesh() {
    MAd::M_delete(mesh_);
    MAd::GM_delete(model_);
  }
  AdaptedMesh(const AdaptedMesh&) = delete;
  AdaptedMesh& operator=(const AdaptedMesh&) = delete;

  MAd::pMesh get() const { return mesh_; }

  /// The mesh as it is now; the vertices by their numbers, so that those of the skin keep their order.
  TetMesh copy() const {
    TetMesh out;
    std::vector<MAd::pVertex> vertices;
    MAd::VIter each = MAd::M_vertexIter(mesh_);
    while (MAd::pVertex vertex = MAd::VIter_next(each)) vertices.push_back(vertex);
    MAd::VIter_delete(each);
    std::sort(vertices.begin(), vertices.end(),
              [](MAd::pVertex a, MAd::pVertex b) { return MAd::V_id(a) < MAd::V_id(b); });
    std::unordered_map<int, Index> number;
    for (MAd::pVertex vertex : vertices) {
      number.emplace(MAd::V_id(vertex), static_cast<Index>(out.points.size()));
      std::array<double, 3> place{};
      MAd::V_coord(vertex, place.data());
      out.points.push_back({place[0], place[1], place[2]});
    }
    MAd::RIter regions = MAd::M_regionIter(mesh_);
    while (MAd::pRegion region = MAd::RIter_next(regions)) {
      Tet tet{};
      for (std::size_t i = 0; i < 4; ++i)
        tet[i] = number.at(MAd::V_id(MAd::R_vertex(region, static_cast<int>(i))));
      const std::vector<Vec3>& p = out.points;
      if (signed_volume(p[tet[0]], p[tet[1]], p[tet[2]], p[tet[3]]) < 0.0) std::swap(tet[0], tet[1]);
      out.tets.push_back(tet);
    }
    MAd::RIter_delete(regions);
    return out;
  }

 private:
  template <std::size_t N>
  static std::array<int, N> numbers(const std::array<Index, N>& corners) {
    std::array<int, N> result{};
    std::transform(corners.begin(), corners.end(), result.begin(),
                   [](Index v) { return static_cast<int>(v) + 1; });
    return result;
  }

  MAd::pGModel model_ = nullptr;
  MAd::pMesh mesh_ = nullptr;
};

TimedMesh adapt(const TetMesh& mesh, double size, const AdaptSettings& settings) {
  const Stopwatch watch;
  const AdaptedMesh adapted(mesh);
  MAd::PWLSField field(adapted.get());
  MAd::VIter each = MAd::M_vertexIter(adapted.get());
  while (MAd::pVertex vertex = MAd::VIter_next(each)) field.setSize(as_entity(vertex), size);
  MAd::VIter_delete(each);
  MAd::MeshAdapter adapter(adapted.get(), &field);
  MAd::FIter faces = MAd::M_faceIter(adapted.get());
  while (MAd::pFace face = MAd::FIter_next(faces)) {
    if (MAd::F_numRegions(face) == 1) adapter.setConstraint(as_entity(face));
  }
  MAd::FIter_delete(faces);
  adapter.setSliverQuality(settings.sliver_quality);
  adapter.setNoSwapQuality(settings.no_swap_quality);
  adapter.setVerbosity(kSilent);
  adapter.run();
  TimedMesh result;
  result.mesh = adapted.copy();
  result.kernel_s = watch.seconds();
  if (result.mesh.tets.empty()) throw std::runtime_error("MAdLib left no tetrahedron");
  return result;
}

Response answer(const Request& request) {
  if (request.method != "madlib.adapt") throw InputError("method", 0, "madlib.adapt", request.method);
  nlohmann::json left = request.options;
  AdaptSettings settings;
  settings.sliver_quality = take_number(left, "sliver_quality", 0.0, 1.0, settings.sliver_quality);
  settings.no_swap_quality = take_number(left, "no_swap_quality", 0.0, 1.0, settings.no_swap_quality);
  require_all_taken(left);
  Remesher remesher;
  remesher.size_name = "edge_length";
  remesher.remesh = [settings](const TetMesh& mesh, std::uint64_t, double size) {
    return adapt(mesh, size, settings);
  };
  return run_remesher(request, remesher);
}

}  // namespace
}  // namespace palpate::reference

int main(int argc, char** argv) {
  return palpate::reference::run_adapter(argc, argv, palpate::reference::answer);
}
