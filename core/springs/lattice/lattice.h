// A regular lattice laid over a body and cut to it: cubic cells, with or without a node in the middle.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/base/enum_names.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::springs {

/// kHexahedral has nodes at the corners of its cells, kBodyCentred in their middles too.
enum class LatticeKind { kHexahedral, kBodyCentred };

/// By the name that methods have.
inline constexpr EnumNames<LatticeKind, 2> kLatticeKindNames{"lattice", {"hexahedral", "bcc"}};

/// What becomes of cells that the body fills in part, phi being the filled share:
///
///   kKeep    cells with phi > `fraction` count whole
///   kRemove  cells with phi >= `fraction` count whole
///   kWeight  every cell that the body meets counts by max(phi, `fraction`)
///
/// The other cells are not there.
enum class LatticeBoundary { kKeep, kRemove, kWeight };

/// By the option `boundary`.
inline constexpr EnumNames<LatticeBoundary, 3> kLatticeBoundaryNames{"boundary",
                                                                     {"keep", "remove", "weight"}};

/// A lattice that is asked for.
struct LatticeOptions {
  LatticeKind kind = LatticeKind::kHexahedral;
  LatticeBoundary boundary = LatticeBoundary::kWeight;
  std::optional<double> fraction;  ///< in [0, 1]; nothing: 0 for kKeep, 0.5 for kRemove, 0.01 for kWeight
  double spacing_m = 0.0;          ///< side of a cell; 0: found so that there are `vertices` nodes
  std::size_t vertices = 0;        ///< 0: as many as the body's mesh has
  double turn_deg = 0.0;           ///< the lattice's axes, turned about (1, 1, 1)
};

/// Places counted in cells: p = (axes (x - origin)) / spacing.
struct LatticeFrame {
  Vec3 origin_m;
  std::array<Vec3, 3> axes{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};  ///< of length 1
  double spacing_m = 1.0;

  Vec3 to_cells(const Vec3& x) const;
  Vec3 to_body(const Vec3& cells) const;
  /// A vector of lattice coordinates, not scaled.
  Vec3 turn(const Vec3& v) const { return v.x * axes[0] + v.y * axes[1] + v.z * axes[2]; }
};

/// The cells that are there, numbered, and their nodes.
///
/// Shape:  one entry a cell in place (i, j, k), filled, share and corners; centres has one too for a
///         body-centred lattice, and none else. Corner x + 2 y + 4 z of a cell is at its place + (x, y, z).
struct Lattice {
  LatticeKind kind = LatticeKind::kHexahedral;
  LatticeFrame frame;
  std::array<int, 3> size{};   ///< of the grid that the cells are taken from
  std::vector<Index> cell_at;  ///< the cell at i + size[0] (j + size[1] k); kNoIndex: none
  std::vector<std::array<int, 3>> place;
  std::vector<double> filled;  ///< phi: the share that the body fills
  std::vector<double> share;   ///< how much of its springs and mass counts, in (0, 1]
  std::vector<std::array<Index, 8>> corners;
  std::vector<Index> centres;
  std::vector<Vec3> nodes;      ///< in m; corners first
  std::size_t loose_cells = 0;  ///< left out: no faces join them to the others
  double body_volume_m3 = 0.0;

  std::size_t cells() const { return place.size(); }
  double cell_volume_m3() const { return frame.spacing_m * frame.spacing_m * frame.spacing_m; }
  /// The cell at a place; kNoIndex where there is none, or outside of the grid.
  Index at(const std::array<int, 3>& where) const;
  /// Cells that the body does not fill.
  std::size_t cut_cells() const;
  /// Sum of the cells' shares over the body's volume.
  double volume_ratio() const;
};

/// Lays a grid in the middle of the body's box, measures the cells and takes those that `boundary` says. A
/// cell that no chain of faces joins to the largest group hinges on an edge or a corner, or floats: it is
/// left out. Where `spacing_m` is 0 it is the one, of at most eight tries, whose number of nodes is nearest
/// to `vertices` (nodes ~ spacing^-2.6), and the first that is within 2%.
///
/// Throws: InputError for options out of range, more than 2^25 places, no cell, or groups of cells with more
///         than 1% of what all cells hold that hang on no face.
Lattice build_lattice(const TetMesh& body, const LatticeOptions& options);

}  // namespace palpate::springs
