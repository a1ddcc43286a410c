// Tools on CGAL: reading, judging and remeshing closed triangle surfaces.
#pragma once

#include <cstddef>
#include <filesystem>
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

/// A surface that was mended, and what was changed.
struct SurfaceRepair {
  SurfaceMesh surface;
  std::size_t points_merged = 0;      ///< with others nearer than 1e-6 of the box's diagonal
  std::size_t triangles_dropped = 0;  ///< without an area, or there twice
  std::size_t pieces_dropped = 0;     ///< loose and open, of less than a hundredth of the area each
  std::size_t points_split = 0;       ///< where sheets touched that did not belong together
  std::size_t holes_filled = 0;
  std::size_t hole_triangles = 0;      ///< that fill them
  double longest_rim = 0.0;            ///< of the holes
  std::size_t intersecting_pairs = 0;  ///< of triangles, once holes were filled
  std::size_t triangles_replaced = 0;  ///< taken out where triangles intersected
  std::size_t triangles_turned = 0;    ///< of those that are left
  double area_before = 0.0;
  double area_after = 0.0;
  double volume_before = 0.0;  ///< with a sign; means something only if was_closed
  double volume_after = 0.0;
  bool was_closed = false;

  /// One line on what was changed.
  std::string text() const;
};

/// Mends what check_closed_surface refuses, as far as CGAL's Polygon Mesh Processing can: merges points,
/// drops triangles without an area, doubled ones and loose open pieces, turns neighbours the same way, fills
/// holes with triangles as small as their rims', removes self-intersections, and turns all outward. The
/// result is as good as the repair came: check_closed_surface has the last word. Requires: at least one
/// triangle.
SurfaceRepair repair_surface(const SurfaceMesh& surface);

/// A remeshed surface, and the edge length that it took.
struct RemeshedSurface {
  SurfaceMesh surface;
  double edge_length = 0.0;
};

/// Isotropic remeshing to edges of about `edge_length`, projected onto the input.
/// Takes the first result that neither intersects itself nor has a folded edge, and tries shorter edges, down
/// to half the wanted, where thin parts cannot have the wanted ones.
/// Throws: InputError if none is sound, with how thick the body is.
RemeshedSurface remesh_surface(const SurfaceMesh& surface, double edge_length);

}  // namespace palpate::reference
