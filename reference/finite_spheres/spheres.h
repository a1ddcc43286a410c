// The spheres of a body: one at each vertex, and which tets each of them reaches.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/mesh/tet_mesh.h"

namespace palpate::reference {

/// A sphere at each vertex.
///
/// Shape:  centres_m and radii_m have one entry a sphere, in the order of the vertices; offsets one a tet and
/// one
///         more: the spheres that reach into tet t are members[offsets[t] .. offsets[t + 1]), increasing.
struct Spheres {
  std::vector<Vec3> centres_m;
  std::vector<double> radii_m;
  std::vector<std::size_t> offsets;
  std::vector<Index> members;

  std::span<const Index> of(std::size_t tet) const {
    return {members.data() + offsets[tet], members.data() + offsets[tet + 1]};
  }
};

/// Places the spheres: r_I = factor x the longest edge at vertex I.
///
/// Cover: the distance to a corner is largest, over a tet, at another corner. With factor > 1 each point of a
/// tet lies inside the spheres of its four corners, which are not in one plane: what functions of first order
/// need. Gaps: a sphere reaches what lies in it of the body's part that is connected, within the sphere, with
/// its centre. The part is found from tet to tet, through faces that the sphere meets. So it doesn't reach
/// across a gap, and its functions are continuous all the same: where a part ends, a boundary is. Requires: a
/// mesh whose vertices all have tets. Throws: ContractError unless factor > 1; InputError as build_faces.
Spheres build_spheres(const TetMesh& mesh, double factor);

}  // namespace palpate::reference
