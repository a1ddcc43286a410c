#include "reference/simplifier_support/skin.h"

#include "core/mesh/topology.h"

namespace palpate::reference {

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

}  // namespace palpate::reference
