// The judge's look at the skin of a mesh: how far it moved, and whether it runs through itself.
// docs/judge.md has the definitions at length.
#pragma once

#include <cstdint>

#include "core/mesh/tet_mesh.h"

namespace palpate::judge {

/// The faces with one tet, counter-clockwise seen from outside, over the mesh's own points (all of them, so
/// numbers stay). Tets with invalid indices are left out, and so are faces with a point that is not finite.
SurfaceMesh build_boundary(const TetMesh& mesh);

/// How closely distances are bracketed, and how much work that may cost.
struct SurfaceDistanceOptions {
  double relative_gap = 0.001;  ///< stop at upper <= (1 + relative_gap) lower ...
  double absolute_gap = 1e-7;   ///< ... or at upper <= lower + absolute_gap * the diagonal of both boxes
  double mean_spacing = 0.01;   ///< longest side of a sample's triangle for the mean, over that diagonal
  std::uint64_t max_pieces = 5'000'000;  ///< looked at in one direction; then the bracket stays wider
};

/// From one surface to another: max and mean over the points x of the first of dist(x, second).
struct DirectedDistance {
  double lower = 0.0;       ///< attained at a point that was looked at
  double upper = 0.0;       ///< no point of the surface is farther away, up to rounding
  double mean = 0.0;        ///< weighted by area
  double mean_error = 0.0;  ///< the mean over the whole surface is within so much of `mean`
};

/// Two-sided distance, in the unit of the points.
struct SurfaceDistance {
  DirectedDistance forward;   ///< from a to b
  DirectedDistance backward;  ///< from b to a
  double diagonal = 0.0;      ///< of the box around both

  double lower() const { return forward.lower > backward.lower ? forward.lower : backward.lower; }
  double upper() const { return forward.upper > backward.upper ? forward.upper : backward.upper; }
  double mean() const { return forward.mean > backward.mean ? forward.mean : backward.mean; }
};

/// Hausdorff distance between two triangulated surfaces, bracketed: lower() <= H <= upper().
///
/// Branch and bound over pieces of triangles. A piece P is bounded from above by
///   min( min_j max_v dist(v, b_j),  dist(m, B) + max_v |v - m| ),
/// v its corners, m its centroid, b_j triangles of the other surface B: the distance to one (convex) triangle
/// is convex, so it is greatest at a corner, and the distance to B grows no faster than the way that is gone.
/// A piece whose bound exceeds what was attained so far is cut along the sides of the triangle that is
/// nearest to m, or halved.
/// Time:    about one search in a tree of boxes for each corner and triangle, and for each piece that
/// matters. Returns: infinite distances if one surface has no triangles and the other has some; zeros if none
/// has any. Throws:  ContractError if a point of a triangle is not finite or does not exist, or for bad
/// options.
SurfaceDistance measure_surface_distance(const SurfaceMesh& a, const SurfaceMesh& b,
                                         const SurfaceDistanceOptions& options = {});

/// More pairs than these are not counted.
inline constexpr std::uint64_t kMostSelfIntersections = 1'000'000;

/// Pairs of triangles that meet elsewhere than in the vertices (by number) and edges that they share, by
/// exact orientations: crossing, touching and coplanar overlap all count. A triangle whose corners lie on one
/// line counts as one pair by itself, and in no other. Counting ends at kMostSelfIntersections: n tets in one
/// place have some 2 n^2 pairs. Throws:  ContractError if a point of a triangle is not finite or does not
/// exist.
std::uint64_t count_self_intersections(const SurfaceMesh& surface);

}  // namespace palpate::judge
