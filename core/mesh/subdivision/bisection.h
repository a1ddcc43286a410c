// Local refinement: edges are halved where a mesh is to be finer.
#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "core/mesh/boundary_problem.h"
#include "core/mesh/tet_mesh.h"

namespace palpate {

/// A mesh with some edges halved. The vertices of the one before keep their numbers, and vertex n + i of its
/// n is the midpoint of halved[i], whose ends come before it.
struct BisectedMesh {
  TetMesh mesh;
  std::vector<Edge> halved;
};

/// Halves edges until there are at least `vertices` vertices, with all tets around each.
///
/// The next edge is the one with the greatest length / size(midpoint); before it is halved, so is the longest
/// edge of the tets around it that is longer, and so on (the longest-edge propagation path), which keeps
/// angles bounded. Ties are broken by vertex numbers. The body stays the same to rounding, and so does its
/// boundary. Edges where size is infinite are halved on such paths alone. Stops when no other is left.
/// Requires: size > 0. Time: n log n.
/// Source: M.-C. Rivara, Int. J. Numer. Meth. Engng 40 (1997), 3313-3324.
BisectedMesh bisect_edges(const TetMesh& mesh, std::size_t vertices,
                          const std::function<double(const Vec3&)>& size);

/// The same problem on the bisected mesh: each face hands its weight, its load and what holds it to its
/// halves. `vertices` is the number before. Throws: InputError for fields that vary (body_force_n_m3,
/// held_field_m), which are not handed down.
BoundaryProblem bisect_problem(const BoundaryProblem& problem, std::size_t vertices,
                               std::span<const Edge> halved);

}  // namespace palpate
