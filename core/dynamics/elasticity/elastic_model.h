// An elastic body as springs and strain energies: its energy and its forces.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/dynamics/elasticity/elastic_law.h"
#include "core/dynamics/elasticity/strain_operator.h"
#include "core/dynamics/elasticity/volume_force.h"
#include "core/mesh/spring_network.h"

namespace palpate::dynamics {

/// An energy of smoothed gradients: sum over the domains s of V_s W(I + H_s).
struct StrainTerm {
  StrainOperator op;
  Moduli moduli;
  StrainLaw law = StrainLaw::kCorotated;
};

/// A body whose forces are those of its springs, of its strain terms and, if there is one, of the thesis's
/// volume force.
///
/// Shape:  rest holds one point a vertex, in m.
struct ElasticModel {
  std::vector<Vec3> rest;
  SpringNetwork springs;
  bool springs_are_linear =
      false;  ///< 1/2 k (e . du)^2 with e the rest direction, instead of k/2 (|d| - L)^2
  std::vector<StrainTerm> strain_terms;
  std::optional<VolumeForce> volume_force;  ///< has no energy
};

/// Energy of the springs and strain terms, in J; infinite where a law has none. `displacement` in m, one a
/// vertex.
double elastic_energy(const ElasticModel& model, std::span<const Vec3> displacement);

/// Adds the forces on the vertices, in N: minus the gradient of elastic_energy, and the volume force.
///
///   springs: f_a = k (|d| - L) d / |d|,  d = x_b - x_a,  f_b = -f_a
///   strain terms: f_v = - sum over s of V_s P(I + H_s) g_sv
///
/// Returns:  number of springs of length zero; they have no direction and add nothing.
/// Requires: a finite energy.
/// Source:   thesis eq. 3.2, signs corrected.
std::size_t add_elastic_forces(const ElasticModel& model, std::span<const Vec3> displacement,
                               std::span<Vec3> force);

/// The elongation |d| - L of a spring, without cancellation for small displacements:
/// (2 d0 . du + du . du + |d0|^2 - L^2) / (|d| + L). `rest_edge` is d0, `change` is du, `rest_length` L.
double spring_elongation(const Vec3& rest_edge, const Vec3& change, double rest_length);

}  // namespace palpate::dynamics
