// Small meshes made by hand, good ones and broken ones, for tests.
#pragma once

#include <array>
#include <span>

#include "core/base/random.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::testing_support {

/// One tet with corners 0, x, y, z.
TetMesh make_corner_tet();

/// One regular tet of edge 1.
TetMesh make_regular_tet();

/// A cell of the unit grid by its least corner.
using Cell = std::array<int, 3>;

/// Unit cubes, six Kuhn tets each; cells that touch share their vertices. Vertices are sorted by z, y, x.
TetMesh make_kuhn_cells(std::span<const Cell> cells);

/// The block of nx x ny x nz unit cubes.
TetMesh make_kuhn_block(int nx, int ny, int nz);

/// 3 x 3 x 1 cubes without the middle one: a solid torus (one handle).
TetMesh make_cube_ring();

/// 3 x 3 x 3 cubes without the middle one: a ball with a cavity.
TetMesh make_hollow_cube();

/// Vertices of the block (3 or more cubes a side) that are on no face of it.
std::vector<Index> interior_vertices_of_block(int nx, int ny, int nz);

/// The number of the vertex at a grid point of the block.
Index block_vertex(int nx, int ny, int x, int y, int z);

/// Two tets that share a face, with the apexes above and below it.
TetMesh make_two_tets();

/// The number of vertices that two tets share.
int count_shared(const Tet& a, const Tet& b);

/// Both meshes side by side, the second's vertices after the first's.
TetMesh join_meshes(const TetMesh& a, const TetMesh& b);

/// The mesh moved by `by`.
TetMesh translated(TetMesh mesh, const Vec3& by);

/// Triangles of edge length up to about `size` whose first corners lie anywhere in the unit cube.
SurfaceMesh random_triangles(int triangles, double size, SplitMix64& random);

}  // namespace palpate::testing_support
