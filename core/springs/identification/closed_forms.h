// Spring constants in closed form: sums over the tets around an edge.
#pragma once

#include <optional>

#include "core/mesh/spring_network.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::springs {

// Each sets the stiffness, in N/m, of every spring of `network`, which must be build_spring_network(mesh) in
// metres. Springs between opposite apexes belong to no tet: the formulas by tets give them a share of theirs
// (tet_shares.h). E is Young's modulus in Pa; each formula holds for Poisson's ratio 1/4, the one that an
// isotropic network has. Throws: ContractError if an edge of the mesh has no spring.

/// The same stiffness for all: `given`, or the one with sum k U^2 = 6 E V over springs of rest length U.
void set_uniform(const TetMesh& mesh, double young_modulus_pa, std::optional<double> given,
                 SpringNetwork& network);

/// k = E (sum of V_T) / l^2 over the tets T around the edge of length l. Gives sum k l^2 = 6 E V exactly.
/// Source: A. Van Gelder, Journal of Graphics Tools 3(2), 1998.
void set_van_gelder(const TetMesh& mesh, double young_modulus_pa, SpringNetwork& network);

/// k = sum of (2 sqrt(2) / 25) E l_T, where l_T = cbrt(6 sqrt(2) V_T) is the edge of the regular tet of the
/// same volume. Gives sum k l^2 = 0.96 x 6 E V on regular tets.
/// Source: B. Lloyd, G. Szekely, M. Harders, IEEE Transactions on Visualization and Computer Graphics 13(5),
/// 2007.
void set_lloyd(const TetMesh& mesh, double young_modulus_pa, SpringNetwork& network);

/// k = E A / l, a rod of section A. The paper's rule for A on tetrahedra is not known to us; ours is the area
/// of the interface between the influence volumes of the edge's two vertices (the barycentric dual face),
///
///   A = sum over T of |(c - m) x (d - m)| / 12,
///
/// with m the middle of the edge and c, d the other two vertices of T. Gives sum k l^2 >= 3 E V, with
/// equality where edges cross their interfaces at right angles (regular tets): half as stiff as the solid.
/// Source of k = E A / l: A. Maciel, R. Boulic, D. Thalmann, Surgery Simulation and Soft Tissue Modeling,
/// 2003.
void set_maciel(const TetMesh& mesh, double young_modulus_pa, SpringNetwork& network);

}  // namespace palpate::springs
