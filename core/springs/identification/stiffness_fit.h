// Springs on the edges of a tet whose stiffness matrix is nearest to that of the linear finite element.
#pragma once

#include <array>

#include "core/mesh/boundary_problem.h"
#include "core/mesh/spring_network.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::springs {

/// The six constants k >= 0 (order of kTetEdges, N/m) that minimise || K - sum k_e S_e ||_F in one tet with
/// K the 12 x 12 stiffness matrix of the linear element and S_e = (e e^T) (x) [1 -1; -1 1] that of a spring
/// of unit direction e and stiffness 1.
///
/// Exact: 6 unknowns, the signs found by principal pivoting. Requires a positive tet, in metres.
/// Source: after S. Natsupakpong, M. C. Cavusoglu, Graphical Models 72, 2010.
std::array<double, 6> fit_tet_stiffness(const std::array<Vec3, 4>& corners, double lambda_pa, double mu_pa);

/// Sets the stiffness of each spring to the sum over the tets around its edge. The material's own Poisson's
/// ratio enters through the finite elements: above 1/4 the springs get stiffer, they don't get another ratio.
/// Springs between opposite apexes get their share (tet_shares.h).
/// Requires: network is build_spring_network(mesh) in metres. Throws: ContractError if an edge has no spring.
void set_stiffness_fit(const TetMesh& mesh, const Material& material, SpringNetwork& network);

}  // namespace palpate::springs
