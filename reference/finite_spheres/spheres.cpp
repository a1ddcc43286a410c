#include "reference/finite_spheres/spheres.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/error.h"
#include "core/mesh/topology.h"
#include "core/simplify/sizing/triangle_tree.h"

namespace palpate::reference {
namespace {

/// The tet across each face of a tet, kNoIndex on the boundary; face i is opposite to vertex i.
using Neighbours = std::vector<std::array<Index, 4>>;

Neighbours find_neighbours(const TetMesh& mesh) {
  Neighbours across(mesh.tets.size(), {kNoIndex, kNoIndex, kNoIndex, kNoIndex});
  for (const Face& face : build_faces(mesh)) {
    if (face.tets[1] == kNoIndex) continue;
    for (std::size_t side = 0; side < 2; ++side) {
      const Tet& tet = mesh.tets[face.tets[side]];
      for (std::size_t i = 0; i < 4; ++i) {
        const bool is_corner =
            std::find(face.vertices.begin(), face.vertices.end(), tet[i]) != face.vertices.end();
        if (!is_corner) across[face.tets[side]][i] = face.tets[1 - side];
      }
    }
  }
  return across;
}

std::vector<double> choose_radii(const TetMesh& mesh, double factor) {
  std::vector<double> radii(mesh.points.size(), 0.0);
  for (const auto& [a, b] : build_edges(mesh)) {
    const double reach = factor * length(mesh.points[b] - mesh.points[a]);
    radii[a] = std::max(radii[a], reach);
    radii[b] = std::max(radii[b], reach);
  }
  return radii;
}

/// Walks from tet to tet as far as a sphere reaches.
class Walk {
 public:
  explicit Walk(const TetMesh& mesh)
      : mesh_(mesh),
        stars_(build_vertex_stars(mesh)),
        across_(find_neighbours(mesh)),
        last_(mesh.tets.size(), kNoIndex) {}

  /// The tets that the sphere around `centre` reaches, in no order; valid until the next call.
  const std::vector<Index>& reach(Index centre, double radius) {
    found_.clear();
    for (const Index tet : stars_.of(centre)) take(tet, centre);
    const Vec3& middle = mesh_.points[centre];
    std::size_t next = 0;
    while (next < found_.size()) {  // grows on the way
      const Index tet = found_[next++];
      for (std::size_t i = 0; i < 4; ++i) {
        const Index other = across_[tet][i];
        if (other == kNoIndex || last_[other] == centre) continue;
        const auto corner = [&](std::size_t k) -> const Vec3& {
          return mesh_.points[mesh_.tets[tet][static_cast<std::size_t>(kTetFaces[i][k])]];
        };
        if (simplify::distance_sq_to_triangle(middle, corner(0), corner(1), corner(2)) < radius * radius)
          take(other, centre);
      }
    }
    return found_;
  }

 private:
  void take(Index tet, Index centre) {
    last_[tet] = centre;
    found_.push_back(tet);
  }

  const TetMesh& mesh_;
  VertexStars stars_;
  Neighbours across_;
  std::vector<Index> last_;  ///< of each tet: the sphere that found it last
  std::vector<Index> found_;
};

}  // namespace

Spheres build_spheres(const TetMesh& mesh, double factor) {
  require(factor > 1.0, "build_spheres: radii above the longest edge");
  Spheres spheres;
  spheres.centres_m = mesh.points;
  spheres.radii_m = choose_radii(mesh, factor);
  Walk walk(mesh);
  std::vector<std::vector<Index>> per_tet(mesh.tets.size());
  for (Index centre = 0; centre < mesh.points.size(); ++centre) {
    for (const Index tet : walk.reach(centre, spheres.radii_m[centre])) per_tet[tet].push_back(centre);
  }
  spheres.offsets.assign(1, 0);
  for (const std::vector<Index>& members : per_tet) {
    spheres.members.insert(spheres.members.end(), members.begin(), members.end());
    spheres.offsets.push_back(spheres.members.size());
  }
  return spheres;
}

}  // namespace palpate::reference
