// Vertices that their springs say too little of, or hold too little.
#pragma once

#include <vector>

#include "core/mesh/spring_network.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::springs {

/// The bound of find_degenerate_vertices.
inline constexpr double kFlatFan = 0.03;

/// Vertices whose constants rest on too few directions: those of one tet, and flat fans, whose springs lie
/// within kFlatFan of a plane (root mean square of the sine of the angle between spring and plane). Sorted.
std::vector<Index> find_degenerate_vertices(const TetMesh& mesh, const SpringNetwork& network);

/// The bound of find_hanging_vertices.
inline constexpr double kHanging = 1e-6;

/// Vertices that their springs don't hold: the least eigenvalue of sum k e e^T over the springs at the vertex
/// is below kHanging of what it is on average where they are as stiff as the solid, 4 E V_m / (mean U^2).
/// Such a vertex can move without resistance while all others stand still, so the network has no stable
/// equilibrium. Sorted. Requires: young_modulus_pa > 0.
std::vector<Index> find_hanging_vertices(const TetMesh& mesh, const SpringNetwork& network,
                                         double young_modulus_pa);

}  // namespace palpate::springs
