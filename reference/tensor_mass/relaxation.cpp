#include "reference/tensor_mass/relaxation.h"

#include <cmath>

#include "core/base/error.h"
#include "core/dynamics/linear_algebra/vertex_field.h"

namespace palpate::reference {

using dynamics::add_scaled;
using dynamics::clear_held;
using dynamics::dot_of;
using dynamics::Loads;
using dynamics::Mat3;
using dynamics::norm_of;

namespace {

using Field = std::vector<Vec3>;

bool is_held(const Loads& loads, std::size_t v, std::size_t axis) {
  return ((loads.held[v] >> axis) & 1U) != 0;
}

/// The inverses of the vertex tensors on the free components; zero elsewhere.
std::vector<Mat3> invert_vertex_tensors(const TensorMass& tensors, const Loads& loads) {
  std::vector<Mat3> inverse(tensors.vertex.size());
  for (std::size_t v = 0; v < inverse.size(); ++v) {
    Mat3 k = tensors.vertex[v];
    for (std::size_t i = 0; i < 3; ++i) {
      if (!is_held(loads, v, i)) continue;
      for (std::size_t j = 0; j < 3; ++j) k(i, j) = k(j, i) = i == j ? 1.0 : 0.0;
    }
    inverse[v] = (1.0 / determinant(k)) * transpose(cofactors(k));
    for (std::size_t i = 0; i < 3; ++i) {
      if (is_held(loads, v, i)) inverse[v](i, i) = 0.0;
    }
  }
  return inverse;
}

/// The dead loads and what moved pads pull with.
Field load_forces(const Loads& loads) {
  Field force = loads.force_n;
  for (const dynamics::SupportFace& support : loads.supports) {
    // c (1 + delta_ij) summed over j: each vertex takes 4 c of the pad's movement.
    for (const Index v : support.face) {
      force[v] = force[v] + (4.0 * support.coefficient_n_per_m) * support.by_m;
    }
  }
  return force;
}

}  // namespace

Relaxation relax(const TensorMass& tensors, const Loads& loads, const RelaxationOptions& options) {
  const std::size_t n = tensors.vertex.size();
  require(loads.held.size() == n, "relax: loads of another mesh");
  Relaxation found;
  Field& u = found.displacement_m;
  u = loads.held_by_m;  // zero where nothing is held
  Field residual = load_forces(loads);
  Field pull(n);
  add_tensor_forces(tensors, u, pull);
  const double scale = norm_of(residual) + norm_of(pull);
  add_scaled(residual, 1.0, pull);
  clear_held(loads.held, residual);
  const std::vector<Mat3> inverse = invert_vertex_tensors(tensors, loads);
  Field step(n);
  Field direction(n);
  Field stretched(n);
  double before = 0.0;
  for (;; ++found.iterations) {
    const double norm = norm_of(residual);
    found.residual_relative = scale > 0.0 ? norm / scale : 0.0;
    found.converged = found.residual_relative <= options.tolerance;
    if (found.converged || found.iterations == options.most_iterations || !std::isfinite(norm)) return found;
    for (std::size_t v = 0; v < n; ++v) step[v] = inverse[v] * residual[v];
    const double now = dot_of(residual, step);
    for (std::size_t v = 0; v < n; ++v) {
      direction[v] = found.iterations == 0 ? step[v] : step[v] + (now / before) * direction[v];
      stretched[v] = {};
    }
    before = now;
    add_tensor_forces(tensors, direction, stretched);
    clear_held(loads.held, stretched);
    const double stiffness = -dot_of(direction, stretched);
    if (!(stiffness > 0.0)) return found;
    add_scaled(u, now / stiffness, direction);
    add_scaled(residual, now / stiffness, stretched);
  }
}

double elastic_energy(const TensorMass& elastic, const Field& displacement) {
  Field force(displacement.size());
  add_tensor_forces(elastic, displacement, force);
  return -0.5 * dot_of(displacement, force);
}

}  // namespace palpate::reference
