// Displacements of elastic bodies that are known in closed form.
#pragma once

#include <array>
#include <vector>

#include "core/base/types.h"
#include "core/mesh/boundary_problem.h"

namespace palpate::reference {

/// A displacement gradient or a stress, by rows.
using Matrix3 = std::array<Vec3, 3>;

/// u = shift + gradient x: any constant strain, the field of the patch test.
struct LinearField {
  Matrix3 gradient;
  Vec3 shift;

  Vec3 displacement(const Vec3& x) const {
    return shift + Vec3{dot(gradient[0], x), dot(gradient[1], x), dot(gradient[2], x)};
  }
};

/// A bar along x with the stress `stress_pa` in it and free sides: u = (s / E) (x, -nu y, -nu z).
Vec3 stretched_bar(const Material& material, double stress_pa, const Vec3& x);

/// A bar [0, length] along x between two elastic pads (k u^2 / 2 a unit of area), the one at its far end
/// moved by `moved_m`: for nu = 0 the stress moved / (1 / k_near + length / E + 1 / k_far) is the same
/// everywhere.
struct BarBetweenPads {
  double length_m = 1.0;
  double near_pa_per_m = 1.0;
  double far_pa_per_m = 1.0;
  double moved_m = 0.0;

  double stress_pa(const Material& material) const;
  Vec3 displacement(const Material& material, const Vec3& x) const;
};

/// A bar [0, length] along x held at x = 0, pulled along x by its own weight, for nu = 0:
/// u = density g (length x - x^2 / 2) / E. Quadratic: exact for quadratic elements.
Vec3 hanging_bar(const Material& material, double length_m, double gravity_m_s2, const Vec3& x);

/// A spherical shell under the pressure p from inside (G. Lame, 1852):
///   u_r = p a^3 / (E (b^3 - a^3)) ((1 - 2 nu) r + (1 + nu) b^3 / (2 r^2)),  a <= r <= b.
/// Source: S. Timoshenko and J. N. Goodier, Theory of Elasticity, 3rd edition, 1970, article 136.
struct PressedShell {
  double inner_m = 1.0;
  double outer_m = 2.0;
  double pressure_pa = 0.0;

  Vec3 displacement(const Material& material, const Vec3& x) const;
};

/// Deflection of the end of a beam of square section, clamped at one end, under the force F across its other:
///   F L^3 / (3 E I) + F L / (kappa G A),  I = s^4 / 12, A = s^2, kappa = 10 (1 + nu) / (12 + 11 nu).
/// Sources: S. Timoshenko, Phil. Mag. 41 (1921); kappa: G. R. Cowper, J. Appl. Mech. 33 (1966).
double timoshenko_deflection(const Material& material, double length_m, double side_m, double force_n);

/// A manufactured solution: u = sum over waves of amplitude sin(wave . x + phase), held by the body force
///   f = -div sigma = sum (mu |k|^2 a + (lambda + mu) (k . a) k) sin(k . x + phase).
struct PlaneWave {
  Vec3 amplitude_m;
  Vec3 wave_per_m;
  double phase = 0.0;
};
Vec3 wave_displacement(const std::vector<PlaneWave>& waves, const Vec3& x);
Vec3 wave_body_force(const std::vector<PlaneWave>& waves, const Material& material, const Vec3& x);

/// The neo-Hookean solid W = mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2 stretched along x by `stretch` with
/// free sides: the stretch across, and the force a unit of rest area that it takes.
///   0 = mu (t^2 - 1) + lambda ln(stretch t^2),   P = (mu (stretch^2 - 1) + lambda ln(stretch t^2)) / stretch
/// Requires: stretch > 0, lambda >= 0. Throws: ContractError otherwise.
struct UniaxialStretch {
  double across = 1.0;
  double traction_pa = 0.0;
};
UniaxialStretch stretch_neo_hookean(const Material& material, double stretch);

}  // namespace palpate::reference
