#include "core/springs/identification/stiffness_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/springs/network/tet_shares.h"

namespace palpate::springs {
namespace {

using Vec6 = std::array<double, 6>;
using Mat6 = std::array<Vec6, 6>;

/// Gradients of the four linear shape functions.
std::array<Vec3, 4> shape_gradients(const std::array<Vec3, 4>& p, double volume) {
  std::array<Vec3, 4> gradients;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto& face = kTetFaces[i];  // outward area vector / (3 V), reversed
    const Vec3 area = 0.5 * cross(p[face[1]] - p[face[0]], p[face[2]] - p[face[0]]);
    gradients[i] = (-1.0 / (3.0 * volume)) * area;
  }
  return gradients;
}

bool shares_vertex(std::size_t e, std::size_t f) {
  return e + f != 5;  // only opposite edges share none
}

/// Solves G_ff x_f = b_f on the free unknowns; the others are zero. G is positive definite.
Vec6 solve_free(const Mat6& gram, const Vec6& rhs, const std::array<bool, 6>& is_free) {
  std::array<std::size_t, 6> at{};
  std::size_t n = 0;
  for (std::size_t i = 0; i < 6; ++i) {
    if (is_free[i]) at[n++] = i;
  }
  const auto size = static_cast<Eigen::Index>(n);
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6> matrix(size, size);
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 6, 1> right(size);
  for (std::size_t i = 0; i < n; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    right[row] = rhs[at[i]];
    for (std::size_t j = 0; j < n; ++j) matrix(row, static_cast<Eigen::Index>(j)) = gram[at[i]][at[j]];
  }
  right = matrix.ldlt().solve(right).eval();
  Vec6 x{};
  for (std::size_t i = 0; i < n; ++i) x[at[i]] = right[static_cast<Eigen::Index>(i)];
  return x;
}

/// The unknown with the smallest number whose sign is wrong: negative and free, or at zero with the objective
/// falling; 6 if there is none.
std::size_t first_wrong(const Mat6& gram, const Vec6& rhs, const Vec6& x,
                        const std::array<bool, 6>& is_free) {
  constexpr double kRounding = 1e-12;
  double scale = 0.0;
  for (const double b : rhs) scale = std::max(scale, std::abs(b));
  for (std::size_t i = 0; i < 6; ++i) {
    if (is_free[i]) {
      if (x[i] < -kRounding * scale) return i;
      continue;
    }
    double slope = -rhs[i];
    for (std::size_t j = 0; j < 6; ++j) slope += gram[i][j] * x[j];
    if (slope < -kRounding * scale) return i;
  }
  return 6;
}

/// min x.G x - 2 b.x over x >= 0 by principal pivoting, smallest number first, which ends for a positive
/// definite G (Murty 1974): at most 2^6 sets.
Vec6 minimise_nonnegative(const Mat6& gram, const Vec6& rhs) {
  std::array<bool, 6> is_free;
  is_free.fill(true);
  Vec6 x = solve_free(gram, rhs, is_free);
  for (int pivots = 0; pivots < 64; ++pivots) {
    const std::size_t wrong = first_wrong(gram, rhs, x, is_free);
    if (wrong == 6) break;
    is_free[wrong] = !is_free[wrong];
    x = solve_free(gram, rhs, is_free);
  }
  for (double& value : x) value = std::max(value, 0.0);
  return x;
}

}  // namespace

std::array<double, 6> fit_tet_stiffness(const std::array<Vec3, 4>& corners, double lambda_pa, double mu_pa) {
  const double volume = signed_volume(corners[0], corners[1], corners[2], corners[3]);
  require(volume > 0.0, "fit_tet_stiffness: the tet is not positive");
  const std::array<Vec3, 4> gradients = shape_gradients(corners, volume);
  std::array<Vec3, 6> direction;
  Mat6 gram{};
  Vec6 rhs{};
  for (std::size_t e = 0; e < 6; ++e) {
    const auto [a, b] = kTetEdges[e];
    const Vec3 along = corners[b] - corners[a];
    direction[e] = (1.0 / length(along)) * along;
    // <K, S_e> = e . (K_aa + K_bb - K_ab - K_ba) e, K_ab = V (lambda g_a g_b^T + mu (g_b g_a^T + g_a.g_b I))
    const Vec3 g = gradients[a] - gradients[b];
    const double ge = dot(g, direction[e]);
    rhs[e] = volume * ((lambda_pa + mu_pa) * ge * ge + mu_pa * length_sq(g));
    gram[e][e] = 4.0;
    for (std::size_t f = 0; f < e; ++f) {
      const double c = dot(direction[e], direction[f]);
      gram[e][f] = gram[f][e] = shares_vertex(e, f) ? c * c : 0.0;
    }
  }
  return minimise_nonnegative(gram, rhs);
}

void set_stiffness_fit(const TetMesh& mesh, const Material& material, SpringNetwork& network) {
  TetShares shares(mesh, network);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const Tet& tet = mesh.tets[t];
    shares.add(t, fit_tet_stiffness(
                      {mesh.points[tet[0]], mesh.points[tet[1]], mesh.points[tet[2]], mesh.points[tet[3]]},
                      material.lambda_pa(), material.mu_pa()));
  }
}

}  // namespace palpate::springs
