// Rest of a tensor-mass body under its loads.
#pragma once

#include <cstddef>
#include <vector>

#include "core/dynamics/elasticity/loads.h"
#include "reference/tensor_mass/tensors.h"

namespace palpate::reference {

struct RelaxationOptions {
  double tolerance = 1e-10;  ///< of residual_relative
  std::size_t most_iterations = 20000;
};

/// What came of it. `converged` is false where the iterations ran out, or a direction has no stiffness.
struct Relaxation {
  std::vector<Vec3> displacement_m;  ///< one a vertex
  bool converged = false;
  std::size_t iterations = 0;
  double residual_relative =
      0.0;  ///< |forces that are left| / |loads and the forces of what is held|, free components
};

/// Relaxes the vertices until the forces that `tensors` (supports included, see add_supports) and `loads`
/// exert on the free components vanish, by conjugate gradients with the inverse vertex tensors as
/// preconditioner: each vertex steps by what its own tensor and the force on it say. Deterministic.
Relaxation relax(const TensorMass& tensors, const dynamics::Loads& loads, const RelaxationOptions& options);

/// Energy of the elastic body alone, without supports and loads, in J, at `displacement`.
double elastic_energy(const TensorMass& elastic, const std::vector<Vec3>& displacement);

}  // namespace palpate::reference
