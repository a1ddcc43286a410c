#include "core/dynamics/enriched/principal_fields.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/dynamics/linear_algebra/signed_index.h"
#include "core/dynamics/linear_algebra/vertex_field.h"

namespace palpate::dynamics {

PrincipalFields find_principal_fields(std::span<const std::vector<Vec3>> samples, const FieldProduct& product,
                                      std::size_t count) {
  constexpr double kIndependent = 1e-12;
  PrincipalFields out;
  const std::size_t n = samples.size();
  if (n == 0 || count == 0) return out;
  Eigen::MatrixXd gram(signed_index(n), signed_index(n));
  std::vector<Vec3> image(samples[0].size());
  for (std::size_t j = 0; j < n; ++j) {
    require(samples[j].size() == image.size(), "samples of one size");
    product(samples[j], image);
    for (std::size_t i = 0; i < n; ++i) gram(signed_index(i), signed_index(j)) = dot_of(samples[i], image);
  }
  gram = (0.5 * (gram + gram.transpose())).eval();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(gram);
  const Eigen::VectorXd& values = solver.eigenvalues();  // rising
  const double largest = values[signed_index(n - 1)];
  const double sum = gram.trace();
  for (std::size_t k = 0; k < std::min(count, n); ++k) {
    const Eigen::Index place = signed_index(n - 1 - k);
    const double value = values[place];
    if (!(value > kIndependent * largest)) break;
    std::vector<Vec3> field(image.size());
    for (std::size_t i = 0; i < n; ++i)
      add_scaled(field, solver.eigenvectors()(signed_index(i), place) / std::sqrt(value), samples[i]);
    out.fields.push_back(std::move(field));
    out.shares.push_back(value / sum);
  }
  return out;
}

}  // namespace palpate::dynamics
