// The moduli that a network of springs has on its own mesh, and the factor that puts them right.
#pragma once

#include <span>

#include "core/dynamics/elasticity/elastic_model.h"
#include "core/dynamics/linear_algebra/linear_solver.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::dynamics {

/// Effective elastic moduli in Pa: of the energy a unit of volume under affine displacements.
struct EffectiveModuli {
  double lambda_pa = 0.0;
  double mu_pa = 0.0;
  double bulk_pa() const { return lambda_pa + 2.0 / 3.0 * mu_pa; }
};

/// Moduli of a model under affine displacements of all its vertices (`affine`), and with the boundary
/// vertices alone so displaced and the inside in equilibrium (`relaxed`), which is what the body shows. Inner
/// vertices that an affine displacement leaves out of balance make it softer.
struct MeasuredModuli {
  EffectiveModuli affine;
  EffectiveModuli relaxed;
  bool converged = true;  ///< whether all six solves did
};

/// Measures them by six strains E_1..E_6, an orthonormal basis of the symmetric matrices: with C_ab V = u_a .
/// K u_b the isotropic part of C has 3 K = (sum over the dilatations) and 2 mu = (trace of C - 3 K) / 5.
/// Requires: no volume force.
MeasuredModuli measure_moduli(const TetMesh& mesh, const ElasticModel& model, const LinearOptions& options);

/// The factor for all spring constants that makes a network, whose exact moduli would be lambda = mu =
/// `mu_pa`, right on average over the five shears and the dilatation:
///
///   c = 5 mu / (2 mu_relaxed + 3 K_relaxed / (5/3))
///
/// No reference solution is looked at. Throws: InputError if the network resists neither.
double calibration_factor(const MeasuredModuli& measured, double mu_pa);

}  // namespace palpate::dynamics
