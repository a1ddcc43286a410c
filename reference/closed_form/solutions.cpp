#include "reference/closed_form/solutions.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace palpate::reference {

Vec3 stretched_bar(const Material& material, double stress_pa, const Vec3& x) {
  const double strain = stress_pa / material.young_modulus_pa;
  return {strain * x.x, -material.poisson_ratio * strain * x.y, -material.poisson_ratio * strain * x.z};
}

double BarBetweenPads::stress_pa(const Material& material) const {
  return moved_m / (1.0 / near_pa_per_m + length_m / material.young_modulus_pa + 1.0 / far_pa_per_m);
}

Vec3 BarBetweenPads::displacement(const Material& material, const Vec3& x) const {
  const double stress = stress_pa(material);
  return {stress / near_pa_per_m + stress * x.x / material.young_modulus_pa, 0.0, 0.0};
}

Vec3 hanging_bar(const Material& material, double length_m, double gravity_m_s2, const Vec3& x) {
  const double weight = material.density_kg_m3 * gravity_m_s2;
  return {weight * (length_m * x.x - 0.5 * x.x * x.x) / material.young_modulus_pa, 0.0, 0.0};
}

Vec3 PressedShell::displacement(const Material& material, const Vec3& x) const {
  const double a_cubed = inner_m * inner_m * inner_m;
  const double b_cubed = outer_m * outer_m * outer_m;
  const double nu = material.poisson_ratio;
  const double r = length(x);
  const double factor = pressure_pa * a_cubed / (material.young_modulus_pa * (b_cubed - a_cubed));
  // u_r / r, so that it can multiply the point itself.
  return (factor * ((1.0 - 2.0 * nu) + (1.0 + nu) * b_cubed / (2.0 * r * r * r))) * x;
}

double timoshenko_deflection(const Material& material, double length_m, double side_m, double force_n) {
  const double nu = material.poisson_ratio;
  const double area = side_m * side_m;
  const double bending = material.young_modulus_pa * area * area / 12.0;
  const double kappa = 10.0 * (1.0 + nu) / (12.0 + 11.0 * nu);
  return force_n * length_m * length_m * length_m / (3.0 * bending) +
         force_n * length_m / (kappa * material.mu_pa() * area);
}

Vec3 wave_displacement(const std::vector<PlaneWave>& waves, const Vec3& x) {
  Vec3 sum;
  for (const PlaneWave& wave : waves) {
    sum = sum + std::sin(dot(wave.wave_per_m, x) + wave.phase) * wave.amplitude_m;
  }
  return sum;
}

Vec3 wave_body_force(const std::vector<PlaneWave>& waves, const Material& material, const Vec3& x) {
  const double lambda = material.lambda_pa();
  const double mu = material.mu_pa();
  Vec3 sum;
  for (const PlaneWave& wave : waves) {
    const Vec3& k = wave.wave_per_m;
    const Vec3 direction =
        (mu * length_sq(k)) * wave.amplitude_m + ((lambda + mu) * dot(k, wave.amplitude_m)) * k;
    sum = sum + std::sin(dot(k, x) + wave.phase) * direction;
  }
  return sum;
}

UniaxialStretch stretch_neo_hookean(const Material& material, double stretch) {
  const double lambda = material.lambda_pa();
  const double mu = material.mu_pa();
  require(stretch > 0.0 && lambda >= 0.0 && mu > 0.0,
          "stretch_neo_hookean: stretch and moduli must be positive");
  // In q = ln t the condition mu (exp(2 q) - 1) + lambda (ln stretch + 2 q) = 0 is convex and increasing:
  // Newton from the right end of where its zero can be falls monotonically onto it.
  const double log_stretch = std::log(stretch);
  double q = std::max(0.0, -0.5 * log_stretch);
  for (int step = 0; step < 100; ++step) {
    const double square = std::exp(2.0 * q);
    const double change =
        (mu * (square - 1.0) + lambda * (log_stretch + 2.0 * q)) / (2.0 * mu * square + 2.0 * lambda);
    q -= change;
    if (std::fabs(change) <= 1e-16 * std::max(1.0, std::fabs(q))) break;
  }
  const double log_volume = log_stretch + 2.0 * q;
  return {std::exp(q), (mu * (stretch * stretch - 1.0) + lambda * log_volume) / stretch};
}

}  // namespace palpate::reference
