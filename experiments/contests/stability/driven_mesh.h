// Meshes driven to extremes: slivers, graded sizes, far and tiny coordinates.
#pragma once

#include <cstdint>

#include "core/mesh/tet_mesh.h"

namespace palpate::experiments {

/// What is done to a mesh, in this order.
struct ExtremeMesh {
  double size_m = 0.1;      ///< scaled to this longest side; 0: not
  double size_ratio = 1.0;  ///< elements at one end over those at the other; 1: as they are
  double sliver_deg = 0.0;  ///< smallest dihedral angle of tets that are flattened; 0: none are
  double coordinate_scale = 1.0;
  double coordinate_shift_m = 0.0;
  std::uint64_t seed = 1;
};

/// A mesh and what came of the wishes.
struct DrivenMesh {
  TetMesh mesh;
  std::size_t flattened = 0;  ///< tets
  double min_dihedral_deg = 0.0;
};

/// With s the place along the longest side, from 0 to 1, a graded mesh is the cone x = r^s, y = r^s ln(r) y /
/// L, z alike, brought back to the longest side: its elements keep about their shapes. A vertex of a tet is
/// moved towards the opposite face until the tet's smallest dihedral angle is the one wanted, if all tets
/// around stay positive; one tet in twenty is tried, seeded.
///
/// Throws: InputError for a size, ratio, scale or shift that is not finite or out of range.
DrivenMesh drive_mesh(TetMesh mesh, const ExtremeMesh& wanted);

}  // namespace palpate::experiments
