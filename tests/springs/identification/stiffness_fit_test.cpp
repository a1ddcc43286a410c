#include "core/springs/identification/stiffness_fit.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/mesh/geometry.h"
#include "core/mesh/shapes/shapes.h"
#include "core/springs/network/network.h"
#include "tests/support/small_meshes.h"

namespace palpate::springs {
namespace {

using Mat12 = std::array<std::array<double, 12>, 12>;
using Mat3 = std::array<std::array<double, 3>, 3>;

/// Inverse of the matrix with rows a, b, c; its columns are the gradients of three barycentric coordinates.
Mat3 inverse_of_rows(const Vec3& a, const Vec3& b, const Vec3& c) {
  const double det = dot(a, cross(b, c));
  const Vec3 u = (1.0 / det) * cross(b, c);
  const Vec3 v = (1.0 / det) * cross(c, a);
  const Vec3 w = (1.0 / det) * cross(a, b);
  return {{{u.x, v.x, w.x}, {u.y, v.y, w.y}, {u.z, v.z, w.z}}};
}

/// The strain of a unit move of one degree of freedom, from the gradients of the shape functions.
Mat3 unit_strain(const std::array<Vec3, 4>& p, std::size_t dof) {
  const Mat3 inverse = inverse_of_rows(p[1] - p[0], p[2] - p[0], p[3] - p[0]);
  const std::size_t vertex = dof / 3;
  std::array<double, 3> gradient{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j)
      gradient[i] += (vertex == 0 ? -1.0 : (vertex == j + 1 ? 1.0 : 0.0)) * inverse[i][j];
  }
  Mat3 strain{};
  for (std::size_t i = 0; i < 3; ++i) {
    strain[dof % 3][i] += 0.5 * gradient[i];
    strain[i][dof % 3] += 0.5 * gradient[i];
  }
  return strain;
}

/// K_ij = V (lambda tr e_i tr e_j + 2 mu e_i : e_j), by the strains themselves.
Mat12 element_stiffness(const std::array<Vec3, 4>& p, double lambda, double mu) {
  const double volume = signed_volume(p[0], p[1], p[2], p[3]);
  Mat12 k{};
  for (std::size_t i = 0; i < 12; ++i) {
    for (std::size_t j = 0; j < 12; ++j) {
      const Mat3 a = unit_strain(p, i);
      const Mat3 b = unit_strain(p, j);
      double contraction = 0.0;
      for (std::size_t n = 0; n < 9; ++n) contraction += a[n / 3][n % 3] * b[n / 3][n % 3];
      k[i][j] = volume * (lambda * (a[0][0] + a[1][1] + a[2][2]) * (b[0][0] + b[1][1] + b[2][2]) +
                          2.0 * mu * contraction);
    }
  }
  return k;
}

Mat12 spring_stiffness(const std::array<Vec3, 4>& p, std::size_t edge) {
  const auto a = static_cast<std::size_t>(kTetEdges[edge][0]);
  const auto b = static_cast<std::size_t>(kTetEdges[edge][1]);
  const Vec3 d = p[b] - p[a];
  const double l = length(d);
  const std::array<double, 3> e{d.x / l, d.y / l, d.z / l};
  Mat12 s{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      s[3 * a + i][3 * a + j] = s[3 * b + i][3 * b + j] = e[i] * e[j];
      s[3 * a + i][3 * b + j] = s[3 * b + i][3 * a + j] = -e[i] * e[j];
    }
  }
  return s;
}

Mat12 residual(const std::array<Vec3, 4>& p, double lambda, double mu, const std::array<double, 6>& k) {
  Mat12 r = element_stiffness(p, lambda, mu);
  for (std::size_t e = 0; e < 6; ++e) {
    const Mat12 s = spring_stiffness(p, e);
    for (std::size_t n = 0; n < 144; ++n) r[n / 12][n % 12] -= k[e] * s[n / 12][n % 12];
  }
  return r;
}

double product(const Mat12& a, const Mat12& b) {
  double sum = 0.0;
  for (std::size_t n = 0; n < 144; ++n) sum += a[n / 12][n % 12] * b[n / 12][n % 12];
  return sum;
}

std::array<Vec3, 4> random_tet(SplitMix64& random) {
  while (true) {
    std::array<Vec3, 4> p;
    for (Vec3& v : p) v = {random.uniform(), random.uniform(), random.uniform()};
    if (signed_volume(p[0], p[1], p[2], p[3]) < 0.0) std::swap(p[2], p[3]);
    if (signed_volume(p[0], p[1], p[2], p[3]) > 0.003) return p;
  }
}

TEST(StiffnessFit, MeetsTheOptimalityConditionsOfTheDenseProblem) {
  constexpr std::uint64_t kSeed = 17;
  SplitMix64 random(kSeed);
  int at_zero = 0;
  for (int n = 0; n < 300; ++n) {
    const std::array<Vec3, 4> p = random_tet(random);
    const double mu = 1.0;
    const double lambda = n % 3 == 0 ? 1.0 : (n % 3 == 1 ? 9.0 : -0.3);
    const std::array<double, 6> k = fit_tet_stiffness(p, lambda, mu);
    const Mat12 r = residual(p, lambda, mu, k);
    const double scale =
        std::sqrt(product(element_stiffness(p, lambda, mu), element_stiffness(p, lambda, mu)));
    for (std::size_t e = 0; e < 6; ++e) {
      const double slope =
          -product(r, spring_stiffness(p, e)) / scale;  // of half the squared distance, by k_e
      ASSERT_GE(k[e], 0.0);
      if (k[e] > 0.0) {
        ASSERT_NEAR(slope, 0.0, 1e-10) << "seed " << kSeed << " case " << n;
      } else {
        ASSERT_GE(slope, -1e-10) << "seed " << kSeed << " case " << n;
        ++at_zero;
      }
    }
  }
  EXPECT_GT(at_zero, 0);  // the bound was met
}

TEST(StiffnessFit, RegularTetsHaveSixEqualSprings) {
  const TetMesh mesh = palpate::testing_support::make_regular_tet();
  SpringNetwork network = build_spring_network(mesh);
  set_stiffness_fit(mesh, {1000.0, 0.25, 0.0}, network);
  for (const double k : network.stiffness_n_per_m)
    EXPECT_NEAR(k, network.stiffness_n_per_m[0], 1e-12 * network.stiffness_n_per_m[0]);
  EXPECT_GT(network.stiffness_n_per_m[0], 0.0);
}

TEST(StiffnessFit, IsTheSumOverTheTetsAroundAnEdge) {
  const TetMesh mesh = build_kuhn_cube(2, 0.25, 6);
  const Material material{5000.0, 0.3, 0.0};
  SpringNetwork network = build_spring_network(mesh);
  set_stiffness_fit(mesh, material, network);
  std::vector<double> expected(network.springs.size(), 0.0);
  const auto tet_springs = build_tet_springs(mesh, network);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const Tet& tet = mesh.tets[t];
    const auto k = fit_tet_stiffness(
        {mesh.points[tet[0]], mesh.points[tet[1]], mesh.points[tet[2]], mesh.points[tet[3]]},
        material.lambda_pa(), material.mu_pa());
    for (std::size_t e = 0; e < 6; ++e) expected[tet_springs[t][e]] += k[e];
  }
  EXPECT_EQ(network.stiffness_n_per_m, expected);
}

TEST(StiffnessFit, InvertedTetsAreAFaultOfTheCaller) {
  EXPECT_THROW(fit_tet_stiffness({{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}}}, 1.0, 1.0), ContractError);
}

}  // namespace
}  // namespace palpate::springs
