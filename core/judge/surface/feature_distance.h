// The judge's look at the edges of a skin: how much it is bent at them, and how far the sharp ones of the
// input are from those of the output.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/mesh/tet_mesh.h"

namespace palpate::judge {

/// An edge by its ends.
using EdgeEnds = std::array<Vec3, 2>;

/// The edges of a surface at which the normals of the two triangles differ by more than `angle_deg`, and
/// those that have another number of triangles than two. A triangle without area has no normal: its edges are
/// none. Throws: ContractError if a point of a triangle is not finite or does not exist.
std::vector<EdgeEnds> list_sharp_edges(const SurfaceMesh& surface, double angle_deg);

/// How much a surface is bent: the sum over its edges of length times the angle between the normals of its
/// two triangles, in radians; edges that have another number of triangles than two count nothing. On a convex
/// body, however it is triangulated, it is twice the integral of the mean curvature; what is crumpled has
/// more. Throws: as list_sharp_edges.
double total_bend(const SurfaceMesh& surface);

/// From one set of edges to another: max over the points x of the first of dist(x, second).
struct EdgeDistance {
  double lower = 0.0;  ///< attained at a point that was looked at
  double upper = 0.0;  ///< no point of the edges is farther away, up to rounding
};

/// Brackets that distance by branch and bound: a part with the ends p, q and the middle m is no farther than
/// min(max(dist(p, b), dist(q, b)), dist(m, second) + |p - q| / 2), b the edge nearest to m. Ends within
/// 0.1% or 10^-7 of the diagonal of the box around both.
/// Returns: zeros if `from` is empty, infinite distances if only `to` is.
EdgeDistance measure_edge_distance(const std::vector<EdgeEnds>& from, const std::vector<EdgeEnds>& to);

/// What became of the input's sharp edges.
struct FeatureDistance {
  std::uint64_t input_edges = 0;   ///< sharper than the angle
  std::uint64_t output_edges = 0;  ///< sharper than half of it
  EdgeDistance kept;               ///< from these of the input to those of the output
};

/// How far the input's edges that are sharper than `angle_deg` are from the output's that are sharper than
/// half of it: an edge that went blunt counts as gone from half the angle on. Sharp edges that the output has
/// elsewhere do not count: a coarse skin has some wherever the input's is curved.
FeatureDistance measure_feature_distance(const SurfaceMesh& input, const SurfaceMesh& output,
                                         double angle_deg);

}  // namespace palpate::judge
