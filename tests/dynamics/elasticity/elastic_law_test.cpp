#include "core/dynamics/elasticity/elastic_law.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/random.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/law_cases.h"

namespace palpate::dynamics {
namespace {

using namespace testing_support;

/// Of a symmetric matrix, rising.
template <int N>
Eigen::Vector<double, N> eigenvalues(const std::array<double, static_cast<std::size_t>(N* N)>& a) {
  return Eigen::Map<const Eigen::Matrix<double, N, N>>(a.data())
      .template selfadjointView<Eigen::Lower>()
      .eigenvalues();
}

TEST(ElasticLaw, NearestRotationIsTheRotationOfThePolarDecomposition) {
  SplitMix64 random(11);
  for (int k = 0; k < 200; ++k) {
    const Mat3 f = kIdentity + random_matrix(random, 1.5);
    const Mat3 r = nearest_rotation(f);
    EXPECT_LT(norm(multiply_transposed(r, r) - kIdentity), 1e-14);
    EXPECT_NEAR(determinant(r), 1.0, 1e-14);
    const Mat3 s = multiply_transposed(r, f);
    EXPECT_LT(norm(s - transpose(s)), 1e-13 * norm(f)) << "case " << k << ", det " << determinant(f);
    // At most one eigenvalue of S is negative, and then the one of the least size.
    const auto values = eigenvalues<3>((0.5 * (s + transpose(s))).m);
    EXPECT_GE(values[1] + values[0], -1e-12);
    EXPECT_EQ(values[0] < 0.0, determinant(f) < 0.0);
  }
}

TEST(ElasticLaw, NearestRotationOfDegenerateMatricesIsARotation) {
  for (const Mat3& f : {Mat3{}, outer({1, 2, 3}, {0, 1, 0}), (-1.0) * kIdentity,
                        outer({1, 0, 0}, {0, 1, 0}) + outer({0, 1, 0}, {1, 0, 0})}) {
    const Mat3 r = nearest_rotation(f);
    EXPECT_LT(norm(multiply_transposed(r, r) - kIdentity), 1e-14);
    EXPECT_NEAR(determinant(r), 1.0, 1e-14);
  }
}

TEST(ElasticLaw, StressIsTheDerivativeOfTheEnergy) {
  SplitMix64 random(5);
  const double step = std::cbrt(2e-16);  // error of a central difference: step^2
  for (const StrainLaw law : kLaws) {
    for (int k = 0; k < 50; ++k) {
      const Mat3 h = random_matrix(random, 0.25);
      const Mat3 p = stress(law, kModuli, h);
      for (std::size_t i = 0; i < 9; ++i) {
        Mat3 more = h;
        Mat3 less = h;
        more.m[i] += step;
        less.m[i] -= step;
        const double slope =
            (energy_density(law, kModuli, more) - energy_density(law, kModuli, less)) / (2.0 * step);
        EXPECT_NEAR(p.m[i], slope, 1e-7) << strain_law_name(law);
      }
    }
  }
}

TEST(ElasticLaw, TangentIsTheDerivativeOfTheStress) {
  SplitMix64 random(6);
  const double step = std::cbrt(2e-16);
  for (const StrainLaw law : kLaws) {
    for (int k = 0; k < 50; ++k) {
      // Beyond 0.4 corotated cases with a negative determinant come in.
      const Mat3 h = random_matrix(random, law == StrainLaw::kCorotated && k % 2 == 0 ? 0.8 : 0.25);
      const Tangent9 c = tangent(law, kModuli, h);
      double largest = 1.0;
      for (const double entry : c) largest = std::max(largest, std::abs(entry));
      for (std::size_t i = 0; i < 9; ++i) {
        Mat3 more = h;
        Mat3 less = h;
        more.m[i] += step;
        less.m[i] -= step;
        const Mat3 slope = (0.5 / step) * (stress(law, kModuli, more) - stress(law, kModuli, less));
        for (std::size_t j = 0; j < 9; ++j) {
          // The curvature grows with the cube of the tangent's size where singular values nearly cancel.
          EXPECT_NEAR(c[9 * j + i], slope.m[j], 1e-8 * largest * largest * largest) << strain_law_name(law);
          EXPECT_NEAR(c[9 * j + i], c[9 * i + j], 1e-13 * largest);
        }
      }
    }
  }
}

TEST(ElasticLaw, AgreesWithLinearElasticityToSecondOrder) {
  SplitMix64 random(7);
  const Mat3 direction = random_matrix(random, 1.0);
  for (const StrainLaw law : {StrainLaw::kCorotated, StrainLaw::kNeoHookean, StrainLaw::kStableNeoHookean}) {
    double before = 0.0;
    for (const double size : {1e-2, 5e-3, 2.5e-3}) {
      const Mat3 h = size * direction;
      const double off =
          std::abs(energy_density(law, kModuli, h) - energy_density(StrainLaw::kLinear, kModuli, h));
      if (before > 0.0) {
        EXPECT_NEAR(before / off, 8.0, 0.5) << strain_law_name(law);  // what is left is cubic
      }
      before = off;
    }
    const Tangent9 rest = tangent(law, kModuli, {});
    const Tangent9 linear = tangent(StrainLaw::kLinear, kModuli, {});
    for (std::size_t k = 0; k < 81; ++k) EXPECT_NEAR(rest[k], linear[k], 1e-14);
  }
}

TEST(ElasticLaw, RotationsChangeNothing) {
  SplitMix64 random(8);
  for (const StrainLaw law : {StrainLaw::kCorotated, StrainLaw::kNeoHookean, StrainLaw::kStableNeoHookean}) {
    for (int k = 0; k < 20; ++k) {
      const Mat3 r = make_rotation({0.6, 0.0, 0.8}, 0.3 * k);
      EXPECT_LT(norm(stress(law, kModuli, r - kIdentity)), 1e-14);
      const Mat3 h = random_matrix(random, 0.2);
      const Mat3 turned = multiply(r, kIdentity + h) - kIdentity;
      EXPECT_NEAR(energy_density(law, kModuli, turned), energy_density(law, kModuli, h), 1e-14);
      EXPECT_LT(norm(stress(law, kModuli, turned) - multiply(r, stress(law, kModuli, h))), 1e-13);
    }
  }
  // The linear law is the oracle's counter-example: a right angle costs energy there.
  const Mat3 quarter = make_rotation({0, 0, 1}, 1.5707963267948966) - kIdentity;
  EXPECT_NEAR(energy_density(StrainLaw::kLinear, kModuli, quarter), 2.0 * 2.0 + 0.5 * 3.0 * 4.0, 1e-12);
}

TEST(ElasticLaw, ClosedForms) {
  // Uniform dilatation by s: S = s I.
  const double s = 1.1;
  const Mat3 h = (s - 1.0) * kIdentity;
  EXPECT_NEAR(energy_density(StrainLaw::kCorotated, kModuli, h), 2.0 * 3.0 * 0.01 + 0.5 * 3.0 * 0.09, 1e-14);
  const double log_j = 3.0 * std::log(s);
  EXPECT_NEAR(energy_density(StrainLaw::kNeoHookean, kModuli, h),
              1.0 * (3.0 * s * s - 3.0) - 2.0 * log_j + 1.5 * log_j * log_j, 1e-13);
  const double change = s * s * s - 1.0;
  EXPECT_NEAR(energy_density(StrainLaw::kStableNeoHookean, kModuli, h),
              3.0 * s * s - 3.0 - 2.0 * change + 2.5 * change * change, 1e-14);
  // Inside out by a mirror, J = -1: finite, and the mirrored gradient is pushed back.
  const Mat3 mirror{{0, 0, 0, 0, 0, 0, 0, 0, -2}};
  EXPECT_NEAR(energy_density(StrainLaw::kStableNeoHookean, kModuli, mirror), 2.0 * 2.0 + 2.5 * 4.0, 1e-14);
  EXPECT_LT(stress(StrainLaw::kStableNeoHookean, kModuli, mirror)(2, 2), 0.0);
  EXPECT_TRUE(std::isinf(energy_density(StrainLaw::kNeoHookean, kModuli, (-2.0) * kIdentity)));
}

TEST(ElasticLaw, ProjectionKeepsWhatIsPositiveAndRemovesWhatIsNot) {
  SplitMix64 random(9);
  const Mat3 small = random_matrix(random, 0.02);
  const Tangent9 stiff = tangent(StrainLaw::kLinear, kModuli, small);
  const Tangent9 same = project_to_semidefinite(stiff);
  for (std::size_t k = 0; k < 81; ++k) EXPECT_NEAR(same[k], stiff[k], 1e-13);
  const Mat3 squeezed = (-0.3) * kIdentity;  // rotations lower the energy under compression
  const Tangent9 soft = tangent(StrainLaw::kCorotated, kModuli, squeezed);
  const auto least = [](const Tangent9& c) { return eigenvalues<9>(c)[0]; };
  EXPECT_LT(least(soft), -1.0);
  EXPECT_GT(least(project_to_semidefinite(soft)), -1e-12);
}

TEST(ElasticLaw, UnknownNamesAreRefused) {
  for (const StrainLaw law : kLaws) EXPECT_EQ(parse_strain_law(strain_law_name(law)), law);
  EXPECT_THROW(parse_strain_law("hookean"), InputError);
}

}  // namespace
}  // namespace palpate::dynamics
