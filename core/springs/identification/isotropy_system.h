// The least-squares rows of isotropy_rows.h for a whole mesh, with their actions.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/mesh/spring_network.h"
#include "core/mesh/tet_mesh.h"
#include "core/springs/identification/isotropy_rows.h"

namespace palpate::springs {

/// The springs around each vertex in compressed rows, the vertices along a space-filling curve.
///
/// Shape:  offsets has one entry a place on the curve and one more; spring, direction (unit, away from the
///         vertex) and patch_factor (patch row weight / rest length; 0 without patch rows) one entry a spring
///         end; vertex one entry a place.
struct IsotropySystem {
  std::size_t springs = 0;
  std::size_t rows_a_vertex = 0;
  std::vector<Index> vertex;
  std::vector<std::size_t> offsets;
  std::vector<Index> spring;
  std::vector<Vec3> direction;
  std::vector<double> patch_factor;
  std::vector<double> target;              ///< b: rows_a_vertex entries a place
  std::vector<std::size_t> block_offsets;  ///< of each place in `blocks`
  std::vector<float> blocks;               ///< the rows' inner products at a vertex, padded columns
};

/// Builds the rows and their right-hand side for the unknowns w = k U^2. Linear time and memory.
IsotropySystem build_isotropy_system(const TetMesh& mesh, const SpringNetwork& network,
                                     double young_modulus_pa, const IsotropyOptions& options);

/// y = A w, rows_a_vertex entries a place; and w = A^T y.
void apply_isotropy_rows(const IsotropySystem& system, std::span<const double> w, std::span<double> y);
/// w = A^T y, of the same system.
void apply_isotropy_rows_transposed(const IsotropySystem& system, std::span<const double> y,
                                    std::span<double> w);

/// The normal equations; the system must outlive them.
NormalEquations isotropy_normal_equations(const IsotropySystem& system);

}  // namespace palpate::springs
