// Tools on CGAL: reading, judging and remeshing closed triangle surfaces.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include "core/mesh/tet_mesh.h"

namespace palpate::reference {

/// Reads .stl (ASCII or binary), .off, .obj or .ply, and merges points with exactly equal coordinates.
/// Throws: InputError for a file that cannot be read, is empty, holds other polygons than triangles, or a
///         coordinate that is not finite.
SurfaceMesh read_surface(const std::filesystem::path& path);

/// Does the surface bound a volume? Checks, in this order: repeated corners, closedness, edges with more than
/// two triangles, consistent orientation, vertices whose triangles do not form one fan, self-intersection,
/// positive volume, and how several pieces are nested.
/// Throws: InputError, one line that names `where`, how many faults there are and the place of one.
void check_closed_surface(const SurfaceMesh& surface, const std::string& where);

/// Pairs of triangles that intersect, and the middle of one.
struct Intersections {
  std::size_t pairs = 0;
  Vec3 place;
};

/// Requires: a manifold surface with consistent orientation.
Intersections find_self_intersections(const SurfaceMesh& surface);

/// Do closed pieces lie outside each other, or alternate outward and inward from outside to inside?
/// Requires: a closed manifold surface without self-intersection.
bool is_nested_well(const SurfaceMesh& surface);

/// Isotropic remeshing to edges of about `edge_length`, projected onto the input.
/// Tries several numbers of sweeps, and takes the first result that neither intersects itself nor has a
/// folded edge. Throws: std::runtime_error if none is sound.
SurfaceMesh remesh_surface(const SurfaceMesh& surface, double edge_length);

}  // namespace palpate::reference
