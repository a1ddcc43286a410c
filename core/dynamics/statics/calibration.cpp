#include "core/dynamics/statics/calibration.h"

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/dynamics/linear_algebra/vertex_field.h"
#include "core/dynamics/statics/tangent_system.h"
#include "core/mesh/geometry.h"
#include "core/mesh/topology.h"

namespace palpate::dynamics {
namespace {

/// An orthonormal basis of the symmetric matrices; the first one is the dilatation, I / sqrt(3).
std::array<Mat3, 6> strain_basis() {
  const double half = std::sqrt(0.5);
  const double third = std::sqrt(1.0 / 3.0);
  const double sixth = std::sqrt(1.0 / 6.0);
  return {Mat3{{third, 0, 0, 0, third, 0, 0, 0, third}},
          Mat3{{half, 0, 0, 0, -half, 0, 0, 0, 0}},
          Mat3{{sixth, 0, 0, 0, sixth, 0, 0, 0, -2.0 * sixth}},
          Mat3{{0, half, 0, half, 0, 0, 0, 0, 0}},
          Mat3{{0, 0, half, 0, 0, 0, half, 0, 0}},
          Mat3{{0, 0, 0, 0, 0, half, 0, half, 0}}};
}

/// Of stiffnesses u K u / V along the basis: 3 K along the dilatation, 2 mu along each of the five shears.
EffectiveModuli average(const std::array<double, 6>& stiffness) {
  double shears = 0.0;
  for (std::size_t k = 1; k < 6; ++k) shears += stiffness[k];
  EffectiveModuli moduli;
  moduli.mu_pa = shears / 10.0;
  moduli.lambda_pa = stiffness[0] / 3.0 - 2.0 / 3.0 * moduli.mu_pa;
  return moduli;
}

}  // namespace

MeasuredModuli measure_moduli(const TetMesh& mesh, const ElasticModel& model, const LinearOptions& options) {
  require(!model.volume_force, "moduli come from an energy");
  const std::size_t n = mesh.points.size();
  Loads loads{std::vector<Vec3>(n), {}, std::vector<std::uint8_t>(n), std::vector<Vec3>(n)};
  const std::vector<std::uint8_t> on_boundary = build_boundary_vertex_flags(mesh);
  for (std::size_t v = 0; v < n; ++v) loads.held[v] = on_boundary[v] != 0 ? 7 : 0;
  TangentSystem system(model, loads, options);
  const std::vector<Vec3> rest(n);
  MeasuredModuli measured;
  measured.converged = system.prepare(rest, TangentKind::kExact, 0.0) == LinearStatus::kSolved;
  const double volume = total_volume(mesh);
  std::array<double, 6> affine{};
  std::array<double, 6> relaxed{};
  const std::array<Mat3, 6> basis = strain_basis();
  std::vector<Vec3> u(n);
  std::vector<Vec3> force(n);
  std::vector<Vec3> back(n);
  for (std::size_t k = 0; k < 6; ++k) {
    for (std::size_t v = 0; v < n; ++v) u[v] = basis[k] * mesh.points[v];
    system.apply(u, force);
    affine[k] = relaxed[k] = dot_of(u, force) / volume;
    if (!measured.converged) continue;
    // The inside gives way by K_ii^-1 f_i, which saves f_i . K_ii^-1 f_i.
    const LinearResult result = system.solve(force, 1e-10, back);
    measured.converged = result.status == LinearStatus::kSolved;
    relaxed[k] -= dot_of(force, back) / volume;
  }
  measured.affine = average(affine);
  measured.relaxed = average(relaxed);
  return measured;
}

double calibration_factor(const MeasuredModuli& measured, double mu_pa) {
  const double found = 2.0 * measured.relaxed.mu_pa + 3.0 * measured.relaxed.bulk_pa() / (5.0 / 3.0);
  if (!measured.converged || !(found > 0.0) || !std::isfinite(found))
    throw InputError("calibrate", 0, "springs that resist affine displacements of the boundary",
                     "moduli of " + std::to_string(found / 5.0) + " Pa");
  return 5.0 * mu_pa / found;
}

}  // namespace palpate::dynamics
