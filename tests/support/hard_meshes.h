// Valid meshes that are hard on simplifiers: thin, flat, far away, with handles, cavities and parts.
#pragma once

#include <string>
#include <vector>

#include "core/base/random.h"
#include "core/mesh/tet_mesh.h"
#include "tests/support/small_meshes.h"

namespace palpate::testing_support {

/// Each cell divided into n^3: the same body on a finer grid.
std::vector<Cell> divided(std::span<const Cell> cells, int n);

/// A plate of cells with three holes through it (genus 3), a ring (genus 1), a ball with a cavity, two balls
/// and a ring side by side; each cell divided into n^3, and inner vertices shaken.
TetMesh make_three_holes(int n, std::uint64_t seed);
TetMesh make_divided_ring(int n, std::uint64_t seed);
TetMesh make_divided_hollow(int n, std::uint64_t seed);
TetMesh make_three_parts(int n, std::uint64_t seed);

/// Moves each inner vertex by up to `amount` per axis; a move is halved until every tet around stays
/// positive.
TetMesh shaken(TetMesh mesh, double amount, std::uint64_t seed);

/// Moves inner vertices, about one in `every`, so near to a face of a tet around them that this tet's volume
/// becomes `relative` of the cube of the face's longest edge, as long as all tets around stay positive.
TetMesh squashed(TetMesh mesh, double relative, std::uint64_t every, std::uint64_t seed);

/// Stretches by powers of two, which rounds nothing: slivers, needles.
TetMesh stretched(TetMesh mesh, int power_x, int power_y, int power_z);

/// Moves each boundary vertex by up to `amount` per axis; a move is halved until every tet around stays
/// positive. With less than a quarter of a cell the skin cannot meet itself.
TetMesh roughened(TetMesh mesh, double amount, std::uint64_t seed);

/// Halves edges at the skin, the longest first, until there are `factor` times as many vertices: a skin that
/// is finer than the inside, as users' meshes have it, with needles among its faces.
TetMesh with_fine_skin(const TetMesh& mesh, double factor);

/// A mesh and what is hard about it.
struct HardMesh {
  std::string name;
  TetMesh mesh;
};

/// One of each kind, from a few tets to some thousands; all are valid.
std::vector<HardMesh> list_hard_meshes(std::uint64_t seed);

}  // namespace palpate::testing_support
