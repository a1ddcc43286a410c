// The constants that meet the conditions of isotropy_rows.h best.
#pragma once

#include "core/mesh/spring_network.h"
#include "core/mesh/tet_mesh.h"
#include "core/springs/identification/isotropy_rows.h"
#include "core/springs/solvers/nonnegative_least_squares.h"

namespace palpate::springs {

/// What came of it, the solver's report beside the size of what is left of the rows.
struct IsotropyReport {
  NonnegativeReport solve;
  double residual_relative = 0.0;  ///< |A w - b| / |b|: how far from isotropy the mesh lets them come
};

/// Sets the stiffness of each spring of the network to the least-squares answer of the rows with k >= 0.
///
/// Requires: a network of this mesh (rest lengths > 0); points in metres; positive tets.
/// Throws: ContractError for a network of another mesh or a modulus that is not positive.
IsotropyReport identify_isotropy(const TetMesh& mesh, double young_modulus_pa, const IsotropyOptions& options,
                                 SpringNetwork& network);

}  // namespace palpate::springs
