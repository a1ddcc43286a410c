#include "core/springs/identification/isotropy_fit.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "core/springs/identification/isotropy_system.h"

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
