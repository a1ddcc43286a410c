// Built shapes: deterministic to the byte, no file needed.
#pragma once

#include <cstdint>

#include "core/mesh/tet_mesh.h"

namespace palpate {

/// Cube [0, 1]^3 of n^3 cells, six Kuhn tets a cell. Inner vertices are moved by up to `jitter` cells per
/// axis (uniform, seeded), and a move is halved until every tet around stays positive. Throws: InputError
/// unless 1 <= n <= 560 (2^30 tets) and 0 <= jitter <= 0.5.
TetMesh build_kuhn_cube(int cells_per_side, double jitter, std::uint64_t seed);

/// Bar [0, 4] x [0, 1] x [0, 1] of 4n x n x n Kuhn cells. Throws: InputError unless 1 <= n <= 350.
TetMesh build_bar(int cells_per_side);

/// Body-centred cubic lattice in the bar [0, 4] x [0, 1]^2 with n cells a unit: lattice tets inside, the
/// outer octahedra cut flat at the faces, with a vertex in the middle of each outer square. Inside, edges are
/// 1/n (axes) and sqrt(3)/(2n) (half diagonals) long and every tet has the volume 1/(12 n^3); 48 n^3 + 36 n^2
/// tets. Throws: InputError unless 1 <= n <= 270.
TetMesh build_bcc_bar(int cells_per_side);

/// The skin of build_bar(n), each square of it in two triangles. Throws: as build_bar.
SurfaceMesh build_bar_surface(int cells_per_side);

/// Geodesic unit sphere: each face of the icosahedron divided into f^2 triangles; 10 f^2 + 2 vertices, 20 f^2
/// triangles. Throws: InputError unless 1 <= f <= 1000.
SurfaceMesh build_geodesic_sphere(int frequency);

/// The geodesic sphere bent into the shape of a kidney with a hilum, in centimetres: 11.0 x 5.5 x 4.5, 147 ml
/// (for a fine surface). Genus 0 and free of self-intersections. Throws: as build_geodesic_sphere.
SurfaceMesh build_bean_surface(int frequency);

}  // namespace palpate
