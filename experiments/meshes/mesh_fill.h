// Filling surfaces with tets to a wanted number of vertices.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/mesh/tet_mesh.h"

namespace palpate::experiments {

/// A skin and its filling.
struct FilledSurface {
  SurfaceMesh skin;
  TetMesh mesh;
  double interior_size = 0.0;
};

/// V - E + F of a closed surface.
std::int64_t skin_euler(const SurfaceMesh& skin);

/// Fills a closed surface by gmsh in a child process. The skin is kept to the bit, every tet has a positive
/// volume, and the mesh is as much a ball as the surface is a sphere (V - E + F - T is half the surface's
/// Euler characteristic). Throws: UnavailableError if gmsh fails, hangs, or breaks one of these.
FilledSurface fill_surface(const SurfaceMesh& skin, double interior_size);

/// Throws: InputError, "`where`: ...", for a closed surface that gmsh cannot fill: one so small or so large
/// that products of its lengths leave the numbers, or several pieces of which one has a cavity (what lies in
/// a cavity is a piece, too).
void check_fillable(const std::string& where, const SurfaceMesh& surface);

/// Throws: InputError unless a body, with its box's diagonal in metres, is 1 nm to 1000 km across.
void require_body_size(double across_m);

/// Remeshes a closed surface by CGAL to edges of about `edge_length`.
SurfaceMesh remesh_surface(const SurfaceMesh& surface, double edge_length);

/// A closed surface as marching cubes leave it, on a grid of voxels: it crosses the grid's edges wherever
/// that happens to be, so it has needles, and edges of 0.7 times the spacing in the mean. The seed says where
/// the grid lies. Throws: UnavailableError if VTK is missing, or if the voxels are so coarse that the surface
/// gets another topology.
SurfaceMesh march_surface(const SurfaceMesh& surface, double spacing, std::uint64_t seed);

/// Vertices that a filling of this volume takes, roughly: a first guess, and a bound against absurd sizes.
double estimate_interior_vertices(double volume, double interior_size);

/// The interior size that estimate_interior_vertices() turns into `vertices`.
double estimate_interior_size(double volume, double vertices);

/// Throws: InputError if filling `volume` with edges of `interior_size` takes more than 20 million vertices.
void check_interior_size(double volume, double interior_size);

/// Looks for the interior size at which the filled skin has `vertices` vertices within 0.3% (0.8% above
/// 3000).
///
/// Starts from `start` and goes by the power law V ~ h^-3 inside a bracket; at most 14 fillings. The closest
/// is returned, so it may be further off. Deterministic. Requires: vertices > skin.points.size().
FilledSurface fill_to_vertices(const SurfaceMesh& skin, std::uint64_t vertices, double start);

/// The mean length of the edges of a closed surface.
double mean_edge(const SurfaceMesh& surface);

/// Fills a user's surface: the interior is adapted to the count, and only a skin that is too fine or too
/// coarse for it is remeshed, which is said in a note. Throws: as fill_with_skin.
FilledSurface fill_user_surface(const SurfaceMesh& surface, std::uint64_t vertices,
                                std::vector<std::string>& notes);

/// Is `found` within 1% of `wanted` (or one vertex)?
bool is_close_enough(std::uint64_t found, std::uint64_t wanted);

/// Throws: InputError, about `name`, if it has not about so many vertices (is_close_enough()).
void require_vertices(const FilledSurface& filled, std::uint64_t vertices, const std::string& name);

/// A skin for a given interior size.
using SkinMaker = std::function<SurfaceMesh(double interior_size)>;

/// Looks for skin and interior size together: first both, at the maker's own ratio, until the count is within
/// 8%, then the interior alone by fill_to_vertices(), over up to four skins nearby if the first cannot have
/// it. Throws: InputError if no size tried comes within 1% of `vertices`.
FilledSurface fill_with_skin(const SkinMaker& make_skin, std::uint64_t vertices, double start,
                             const std::string& name);

}  // namespace palpate::experiments
