#include "core/springs/isotropy_rows.h"

#include <algorithm>
#include <cmath>

#include "core/springs/isotropy_system.h"

namespace palpate::springs {
namespace {

// w to start from: A^T b over the squared column lengths, times the factor that fits best.
std::vector<double> scaled_average(const NormalEquations& equations) {
  const std::size_t count = equations.linear.size();
  std::vector<double> start(count);
  for (std::size_t j = 0; j < count; ++j)
    start[j] = std::max(0.0, equations.linear[j]) / equations.diagonal[j];
  std::vector<double> image(count);
  equations.apply(start, image);
  double along = 0.0;
  double curvature = 0.0;
  for (std::size_t j = 0; j < count; ++j) {
    along += start[j] * equations.linear[j];
    curvature += start[j] * image[j];
  }
  const double factor = curvature > 0.0 ? along / curvature : 0.0;
  for (double& value : start) value *= factor;
  return start;
}

double relative_residual(const IsotropySystem& system, std::span<const double> w) {
  std::vector<double> image(system.target.size());
  apply_isotropy_rows(system, w, image);
  double left = 0.0;
  double whole = 0.0;
  for (std::size_t row = 0; row < image.size(); ++row) {
    left += (image[row] - system.target[row]) * (image[row] - system.target[row]);
    whole += system.target[row] * system.target[row];
  }
  return whole > 0.0 ? std::sqrt(left / whole) : 0.0;
}

}  // namespace

std::array<double, kIsotropyRows> isotropy_coefficients(const Vec3& direction) {
  const auto [x, y, z] = direction;
  const double xx = x * x;
  const double yy = y * y;
  const double zz = z * z;
  const double root6 = std::sqrt(6.0);
  const double root12 = std::sqrt(12.0);
  return {xx * xx,
          yy * yy,
          zz * zz,
          2.0 * xx * x * y,
          2.0 * xx * x * z,
          2.0 * yy * y * x,
          2.0 * yy * y * z,
          2.0 * zz * z * x,
          2.0 * zz * z * y,
          root6 * xx * yy,
          root6 * xx * zz,
          root6 * yy * zz,
          root12 * xx * y * z,
          root12 * yy * x * z,
          root12 * zz * x * y};
}

std::array<double, kIsotropyRows> isotropy_means() {
  const double mixed = std::sqrt(6.0) / 15.0;
  return {0.2, 0.2, 0.2, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, mixed, mixed, mixed, 0.0, 0.0, 0.0};
}

std::array<double, kPatchRows> patch_coefficients(const Vec3& direction) {
  const auto [x, y, z] = direction;
  const double root3 = std::sqrt(3.0);
  return {
      x * x * x,         y * y * y,         z * z * z,         root3 * x * x * y, root3 * x * x * z,
      root3 * y * y * x, root3 * y * y * z, root3 * z * z * x, root3 * z * z * y, std::sqrt(6.0) * x * y * z};
}

std::array<double, kPatchRows> patch_target(const Vec3& area) {
  const double root3 = std::sqrt(3.0);
  return {3.0 * area.x,   3.0 * area.y,   3.0 * area.z,   root3 * area.y, root3 * area.z,
          root3 * area.x, root3 * area.z, root3 * area.x, root3 * area.y, 0.0};
}

IsotropyReport identify_isotropy(const TetMesh& mesh, double young_modulus_pa, const IsotropyOptions& options,
                                 SpringNetwork& network) {
  const IsotropySystem system = build_isotropy_system(mesh, network, young_modulus_pa, options);
  const NormalEquations equations = isotropy_normal_equations(system);
  std::vector<double> w = scaled_average(equations);
  IsotropyReport report;
  report.solve = solve_nonnegative(equations, w, options.solve);
  report.residual_relative = relative_residual(system, w);
  network.stiffness_n_per_m.resize(w.size());
  for (std::size_t j = 0; j < w.size(); ++j)
    network.stiffness_n_per_m[j] = w[j] / (network.rest_length_m[j] * network.rest_length_m[j]);
  return report;
}

}  // namespace palpate::springs
