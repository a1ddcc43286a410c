#include "core/dynamics/elasticity/vertex_stiffness.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "core/base/random.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/law_cases.h"

namespace palpate::dynamics {
namespace {

using namespace testing_support;

Mat3 contract_tangent(const Tangent9& c, const Vec3& g) {
  const std::array<double, 3> gradient{g.x, g.y, g.z};
  Mat3 out;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t j = 0; j < 3; ++j) {
        for (std::size_t l = 0; l < 3; ++l)
          out(i, k) += c[9 * (3 * i + j) + 3 * k + l] * gradient.at(j) * gradient.at(l);
      }
    }
  }
  return out;
}

double least_eigenvalue(const Mat3& a) {
  using Rows3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  return Eigen::Map<const Rows3>(a.m.data()).selfadjointView<Eigen::Lower>().eigenvalues()[0];
}

TEST(VertexStiffness, IsTheTangentsBlockAtModerateStrains) {
  SplitMix64 random(3);
  for (const StrainLaw law : kLaws) {
    SCOPED_TRACE(strain_law_name(law));
    for (int k = 0; k < 200; ++k) {
      // A rotation by any angle, and strains within some 10%, where no factor is negative.
      const Mat3 turn = nearest_rotation(kIdentity + random_matrix(random, 1.5));
      const Mat3 h = multiply(turn, kIdentity + random_matrix(random, 0.05)) - kIdentity;
      const Mat3 row = random_matrix(random, 2.0);
      const Vec3 g = row.row(0);
      const Mat3 wanted = contract_tangent(tangent(law, kModuli, h), g);
      const Mat3 off = vertex_stiffness(law, kModuli, h, g) - wanted;
      EXPECT_LT(std::sqrt(contract(off, off)), 1e-12 * std::sqrt(contract(wanted, wanted))) << k;
    }
  }
}

TEST(VertexStiffness, IsSemidefiniteAtAnyStrain) {
  SplitMix64 random(4);
  for (const StrainLaw law : kLaws) {
    SCOPED_TRACE(strain_law_name(law));
    for (const Moduli& moduli : {kModuli, Moduli{0.0, 1.0}, Moduli{1.0, 0.0}, Moduli{50.0, 1.0}}) {
      for (int k = 0; k < 500; ++k) {
        const Mat3 h = random_matrix(random, 2.0);
        if (law == StrainLaw::kNeoHookean && !(determinant(kIdentity + h) > 0.01)) continue;
        const Mat3 row = random_matrix(random, 2.0);
        const Vec3 g = row.row(0);
        const Mat3 block = vertex_stiffness(law, moduli, h, g);
        EXPECT_GE(least_eigenvalue(block), -1e-12 * std::sqrt(contract(block, block))) << k;
      }
    }
  }
}

TEST(VertexDamping, IsTheDampingTangentsBlockWhereNothingMoves) {
  SplitMix64 random(5);
  for (const StrainLaw law : {StrainLaw::kLinear, StrainLaw::kNeoHookean, StrainLaw::kStableNeoHookean}) {
    SCOPED_TRACE(strain_law_name(law));
    for (int k = 0; k < 200; ++k) {
      const Mat3 turn = nearest_rotation(kIdentity + random_matrix(random, 1.5));
      const Mat3 stretch{{11.0, 0.3, 0.0, 0.3, 0.4, 0.1, 0.0, 0.1, 2.0}};
      const Mat3 h = multiply(turn, stretch) - kIdentity;
      const Mat3 row = random_matrix(random, 2.0);
      const Vec3 g = row.row(0);
      const Mat3 wanted = contract_tangent(damping_tangent(law, kModuli, h), g);
      const double size = std::sqrt(contract(wanted, wanted));
      const Mat3 off = vertex_damping(law, kModuli, h, h, g) - wanted;
      EXPECT_LT(std::sqrt(contract(off, off)), 1e-12 * size) << k;
      if (law == StrainLaw::kLinear) continue;
      const Mat3 block = vertex_stiffness(law, kModuli, h, g);
      EXPECT_GT(std::sqrt(contract(wanted - block, wanted - block)), 0.1 * size) << "no stiffness times b";
    }
  }
}

TEST(VertexDamping, IsSemidefiniteInAnyMotion) {
  SplitMix64 random(6);
  for (const StrainLaw law : kLaws) {
    SCOPED_TRACE(strain_law_name(law));
    for (int k = 0; k < 500; ++k) {
      const Mat3 h = random_matrix(random, 2.0);
      if (law == StrainLaw::kNeoHookean && !(determinant(kIdentity + h) > 0.01)) continue;
      const Mat3 before = random_matrix(random, 2.0);
      const Mat3 row = random_matrix(random, 2.0);
      const Mat3 block = vertex_damping(law, kModuli, h, before, row.row(0));
      EXPECT_GE(least_eigenvalue(block), -1e-12 * std::sqrt(contract(block, block))) << k;
    }
  }
}

TEST(VertexStiffness, OneOfAnotherLawIsToldApart) {
  const Mat3 h{{0.1, 0.0, 0.0, 0.0, -0.1, 0.05, 0.0, 0.0, 0.02}};
  const Vec3 g{1.0, 2.0, 3.0};
  const Mat3 off = vertex_stiffness(StrainLaw::kCorotated, kModuli, h, g) -
                   contract_tangent(tangent(StrainLaw::kNeoHookean, kModuli, h), g);
  EXPECT_GT(std::sqrt(contract(off, off)), 0.1);
}

}  // namespace
}  // namespace palpate::dynamics
