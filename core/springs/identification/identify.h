// Spring constants that make a network move like an elastic solid: each method a named function of mesh and
// material.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/mesh/boundary_problem.h"
#include "core/mesh/spring_network.h"
#include "core/mesh/tet_mesh.h"
#include "core/springs/identification/identify_options.h"

namespace palpate::springs {

/// What came of it.
struct IdentifyReport {
  SpringMethod method = SpringMethod::kUniform;
  std::size_t zero_springs = 0;
  double kkt_relative = 0.0;  ///< 0 for closed forms
  std::size_t iterations = 0;
  bool converged = true;
  double stiffness_ratio_mean = 0.0;  ///< over vertices, of sum over its springs of k U^2 / (12 E V_m)
  std::vector<Index>
      degenerate_vertices;  ///< one tet, or a flat fan: their constants rest on too few directions
  std::vector<Index> hanging_vertices;  ///< find_hanging_vertices
  std::vector<std::string> warnings;    ///< one line each; they name the first few vertices
};

/// Identifies the stiffness of each spring for Young's modulus and Poisson's ratio. Springs alone give 1/4
/// whatever the ratio is, and a warning says so (a volume model carries the rest; fit to mu then: E_s = 2.5
/// mu). The formulas and where they come from: docs/springs.md.
///
/// Requires: points in metres, positive tets, no isolated vertices.
/// Throws: InputError as check_material; for an option out of range. ContractError for a mesh that breaks
/// what is required.
SpringNetwork identify_springs(const TetMesh& mesh, const Material& material, SpringMethod method,
                               const IdentifyOptions& options, IdentifyReport& report);

}  // namespace palpate::springs
