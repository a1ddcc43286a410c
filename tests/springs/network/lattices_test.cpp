#include "tests/support/lattices.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "core/base/error.h"

namespace palpate::springs {
namespace {

constexpr double kYoung = 7000.0;
constexpr double kSpacing = 0.02;

/// Sums over the springs at one vertex of k U^2 e(x)e(x)e(x)e, as the 6 x 6 components (a b c d) with a..d
/// axes.
struct Moments {
  std::array<std::array<std::array<std::array<double, 3>, 3>, 3>, 3> fourth{};
  std::array<std::array<std::array<double, 3>, 3>, 3> third{};  ///< of k U e(x)e(x)e, e pointing outwards
  double sum = 0.0;
};

Moments moments_at(const LatticeNetwork& lattice, Index vertex) {
  Moments moments;
  const SpringNetwork& network = lattice.network;
  for (std::size_t s = 0; s < network.springs.size(); ++s) {
    const auto [a, b] = network.springs[s];
    if (a != vertex && b != vertex) continue;
    const Vec3 d =
        a == vertex ? lattice.points[b] - lattice.points[a] : lattice.points[a] - lattice.points[b];
    const double u = length(d);
    EXPECT_NEAR(u, network.rest_length_m[s], 1e-15);
    const std::array<double, 3> e{d.x / u, d.y / u, d.z / u};
    const double k = network.stiffness_n_per_m[s];
    moments.sum += k * u * u;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        for (int l = 0; l < 3; ++l) {
          moments.third[i][j][l] += k * u * e[i] * e[j] * e[l];
          for (int m = 0; m < 3; ++m) moments.fourth[i][j][l][m] += k * u * u * e[i] * e[j] * e[l] * e[m];
        }
      }
    }
  }
  return moments;
}

double delta(int i, int j) {
  return i == j ? 1.0 : 0.0;
}

/// Mean of e(x)e(x)e(x)e over the sphere: (d_ij d_lm + d_il d_jm + d_im d_jl) / 15.
double isotropic(int i, int j, int l, int m) {
  return (delta(i, j) * delta(l, m) + delta(i, l) * delta(j, m) + delta(i, m) * delta(j, l)) / 15.0;
}

/// Largest deviation of the fourth moments from 12 E V <e(x)4>, relative to 12 E V.
double anisotropy(const Moments& moments, double volume) {
  const double scale = 12.0 * kYoung * volume;
  double most = 0.0;
  for (int n = 0; n < 81; ++n) {
    const int i = n / 27;
    const int j = n / 9 % 3;
    const int l = n / 3 % 3;
    const int m = n % 3;
    most = std::max(most, std::abs(moments.fourth[i][j][l][m] / scale - isotropic(i, j, l, m)));
  }
  return most;
}

/// Largest deviation of the third moments from -mu sym(delta (x) A) (three placements), relative to mu h^2.
double patch_deviation(const Moments& moments, const std::array<double, 3>& area) {
  const double mu = 0.4 * kYoung;
  double most = 0.0;
  for (int n = 0; n < 27; ++n) {
    const int i = n / 9;
    const int j = n / 3 % 3;
    const int l = n % 3;
    const double wanted = -mu * (delta(i, j) * area[l] + delta(i, l) * area[j] + delta(j, l) * area[i]);
    most = std::max(most, std::abs(moments.third[i][j][l] - wanted) / (mu * kSpacing * kSpacing));
  }
  return most;
}

LatticeBlock block(int nx, int ny, int nz) {
  return {{nx, ny, nz}, kSpacing, kYoung};
}

TEST(Lattices, HexahedralNetworkIsIsotropicInsideForEveryShareOfBodyDiagonals) {
  const double h3 = kSpacing * kSpacing * kSpacing;
  for (const double share : {0.0, 0.3, 1.0}) {
    const LatticeNetwork lattice = build_hexahedral_network(block(2, 2, 2), share);
    const Moments inside = moments_at(lattice, 13);
    EXPECT_LT(anisotropy(inside, h3), 1e-14) << share;
    EXPECT_NEAR(inside.sum / (12.0 * kYoung * h3), 1.0, 1e-14);
    EXPECT_LT(patch_deviation(inside, {0, 0, 0}), 1e-14);
  }
}

TEST(Lattices, EdgesAndFaceDiagonalsHaveOneStiffnessInside) {
  const LatticeNetwork lattice = build_hexahedral_network(block(3, 3, 3));
  for (std::size_t s = 0; s < lattice.network.springs.size(); ++s) {
    const auto [a, b] = lattice.network.springs[s];
    if (a != 21 && b != 21) continue;  // (1, 1, 1): inside
    EXPECT_NEAR(lattice.network.stiffness_n_per_m[s], 0.4 * kYoung * kSpacing, 1e-12);
  }
  EXPECT_EQ(moments_at(lattice, 21).sum > 0.0, true);
}

/// A third of the area vectors of the boundary triangles at a vertex, however the squares are cut in a
/// symmetric way: a quarter of each boundary square.
std::array<double, 3> area_share(int i, int j, int l, int n) {
  const std::array<int, 3> at{i, j, l};
  std::array<double, 3> area{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (at[axis] != 0 && at[axis] != n) continue;
    double squares = 1.0;
    for (std::size_t other = 0; other < 3; ++other) {
      if (other != axis && at[other] != 0 && at[other] != n) squares *= 2.0;
    }
    area[axis] = (at[axis] == 0 ? -1.0 : 1.0) * 0.25 * squares * kSpacing * kSpacing;
  }
  return area;
}

TEST(Lattices, EdgesAndFaceDiagonalsPassThePatchTestAtTheSurfaceToo) {
  const int n = 2;
  const LatticeNetwork plain = build_hexahedral_network(block(n, n, n));
  const LatticeNetwork with_body = build_hexahedral_network(block(n, n, n), 1.0);
  Index vertex = 0;
  double worst_with_body = 0.0;
  for (int l = 0; l <= n; ++l) {
    for (int j = 0; j <= n; ++j) {
      for (int i = 0; i <= n; ++i, ++vertex) {
        EXPECT_LT(patch_deviation(moments_at(plain, vertex), area_share(i, j, l, n)), 1e-14) << vertex;
        worst_with_body =
            std::max(worst_with_body, patch_deviation(moments_at(with_body, vertex), area_share(i, j, l, n)));
      }
    }
  }
  EXPECT_GT(worst_with_body, 0.1);  // corners: body diagonals pull where no stress does
}

TEST(Lattices, BccNetworkIsIsotropicAndBalancedInside) {
  const LatticeNetwork lattice = build_bcc_network(block(3, 3, 3));
  const Index corner = 21;  // (1, 1, 1) of 4 x 4 x 4
  const Index center = 64 + 13;
  const double half_cell = 0.5 * kSpacing * kSpacing * kSpacing;
  for (const Index vertex : {corner, center}) {
    const Moments moments = moments_at(lattice, vertex);
    EXPECT_LT(anisotropy(moments, half_cell), 1e-14);
    EXPECT_LT(patch_deviation(moments, {0, 0, 0}), 1e-14);
  }
  EXPECT_GT(anisotropy(moments_at(lattice, 0), half_cell / 8.0),
            0.01);  // and the oracle sees a ragged corner
}

TEST(Lattices, BadBlocksAreRefused) {
  EXPECT_THROW(build_hexahedral_network(block(0, 1, 1)), InputError);
  EXPECT_THROW(build_hexahedral_network(block(1, 201, 1)), InputError);
  EXPECT_THROW(build_hexahedral_network(block(1, 1, 1), 1.5), InputError);
  EXPECT_THROW(build_hexahedral_network(block(1, 1, 1), std::nan("")), InputError);
  EXPECT_THROW(build_bcc_network({{1, 1, 1}, 0.0, kYoung}), InputError);
  EXPECT_THROW(build_bcc_network({{1, 1, 1}, kSpacing, -1.0}), InputError);
}

}  // namespace
}  // namespace palpate::springs
