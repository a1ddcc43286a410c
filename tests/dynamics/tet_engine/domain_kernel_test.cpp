#include "core/dynamics/tet_engine/domain_kernel.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/base/large_pages.h"
#include "core/base/processor.h"
#include "core/base/random.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/law_cases.h"

namespace palpate::dynamics {
namespace {

using namespace testing_support;

Mat3 random_rotation(SplitMix64& random) {
  const Vec3 axis{random.uniform() + 0.1, random.uniform(), random.uniform() - 0.5};
  return make_rotation((1.0 / length(axis)) * axis, 6.0 * random.uniform());
}

/// One displacement gradient and its rate.
struct Case {
  Mat3 h;
  Mat3 rate;
};

/// As the engine sees them.
template <typename Real>
Case rounded(Case exact) {
  for (Mat3* each : {&exact.h, &exact.rate}) {
    for (double& entry : each->m) entry = static_cast<double>(static_cast<Real>(entry));
  }
  return exact;
}

/// Eight domains of four vertices whose gradients are the axes: the force on vertex k is column k of -V P.
template <typename Real>
struct Axes {
  static constexpr std::size_t kRows = 4 * kGroupDomains;

  explicit Axes(const std::vector<Case>& cases) : u(4 * kRows), v(4 * kRows), values(group_values(4)) {
    for (std::size_t lane = 0; lane < kGroupDomains; ++lane) {
      values[lane] = Real(1);
      for (std::size_t k = 0; k < 4; ++k) {
        const std::size_t row = 4 * (4 * lane + k);
        at[kGroupDomains * k + lane] = static_cast<std::uint16_t>(row);
        if (k == 0) continue;
        for (std::size_t i = 0; i < 3; ++i) {
          values[kGroupDomains * (3 * k - 2 + i) + lane] = i + 1 == k ? Real(1) : Real(0);
          u[row + i] = static_cast<Real>(cases[lane].h(i, k - 1));
          v[row + i] = static_cast<Real>(cases[lane].rate(i, k - 1));
        }
      }
    }
  }

  /// P of each domain.
  std::vector<Mat3> stresses(const DomainLaw& law, bool with_avx2) const {
    LargeVector<Real> force(4 * kRows);
    const DomainRun<Real> run{4, 1, values.data(), at.data()};
    LargeVector<Real> seen = u;
    for (std::size_t k = 0; law.law == StrainLaw::kLinear && k < seen.size(); ++k)
      seen[k] += static_cast<Real>(law.damping_s) * v[k];
    if (with_avx2) {
      add_domain_forces_avx2(law, run, {seen.data(), v.data()}, force.data());
    } else {
      add_domain_forces(law, run, {seen.data(), v.data()}, force.data());
    }
    std::vector<Mat3> out(kGroupDomains);
    for (std::size_t lane = 0; lane < kGroupDomains; ++lane) {
      for (std::size_t k = 1; k < 4; ++k) {
        for (std::size_t i = 0; i < 3; ++i)
          out[lane](i, k - 1) = -static_cast<double>(force[4 * (4 * lane + k) + i]);
      }
    }
    return out;
  }

  LargeVector<Real> u;
  LargeVector<Real> v;
  LargeVector<Real> values;
  std::array<std::uint16_t, 4 * kGroupDomains> at{};
};

Mat3 expected_stress(const DomainLaw& law, const Case& at) {
  const Moduli viscous{law.damping_s * law.moduli.lambda_pa, law.damping_s * law.moduli.mu_pa};
  Mat3 p = stress(law.law, law.moduli, at.h);
  if (law.damping_s != 0.0) p += damping_stress(law.law, viscous, at.h, at.rate);
  return p;
}

/// The largest |P - P of elastic_law.h| in units of a rounding of `Real` times the moduli, the size of H and
/// the rate, and what products of F make of them. elastic_law.h itself has R to roundings of 1 in double.
template <typename Real>
double worst_error(const DomainLaw& law, const std::vector<Case>& cases, bool with_avx2,
                   const DomainLaw& told) {
  const std::vector<Mat3> found = Axes<Real>(cases).stresses(law, with_avx2);
  double worst = 0.0;
  for (std::size_t k = 0; k < cases.size(); ++k) {
    const Case at = rounded<Real>(cases[k]);
    const double f = norm(kIdentity + at.h);
    const double size = (norm(at.h) + law.damping_s * norm(at.rate)) * (1.0 + f * f * f);
    const double unit = std::numeric_limits<Real>::epsilon() * size + std::numeric_limits<double>::epsilon();
    const double error = norm(found[k] - expected_stress(told, at));
    worst = std::max(worst, error / (unit * (2.0 * kModuli.mu_pa + 3.0 * kModuli.lambda_pa)));
  }
  return worst;
}

std::vector<Case> make_cases(std::uint64_t seed, double strain, bool is_turned) {
  SplitMix64 random(seed);
  std::vector<Case> out;
  for (std::size_t k = 0; k < kGroupDomains; ++k) {
    Mat3 h = random_matrix(random, strain);
    if (is_turned) h = multiply(random_rotation(random), kIdentity + h) - kIdentity;
    out.push_back({h, random_matrix(random, strain)});
  }
  return out;
}

// The longest chain of roundings has some forty, and the quartic's derivative and J, at least a quarter of
// what they are at rest here, enlarge what comes before them.
constexpr double kRoundings = 40.0;

template <typename Real>
void compare_with_elastic_law() {
  for (const StrainLaw law : kLaws) {
    for (const double damping : {0.0, 0.7}) {
      const DomainLaw own{law, kModuli, damping};
      for (std::uint64_t seed = 0; seed < 40; ++seed) {
        for (const double strain : {1e-6, 1e-3, 0.1, 0.25}) {
          for (const bool is_turned : {false, true}) {
            const std::vector<Case> cases = make_cases(seed, strain, is_turned);
            EXPECT_LT(worst_error<Real>(own, cases, false, own), kRoundings)
                << strain_law_name(law) << " damping " << damping << " seed " << seed << " strain " << strain
                << (is_turned ? " turned" : "") << ", bytes " << sizeof(Real);
          }
        }
      }
    }
  }
}

TEST(DomainKernel, StressIsThatOfTheLaw) {
  compare_with_elastic_law<float>();
  compare_with_elastic_law<double>();
}

TEST(DomainKernel, AWrongStressIsRejected) {
  // A thousandth of one modulus, and the damping of another law, are seen in either precision.
  const std::vector<Case> cases = make_cases(3, 0.25, true);
  for (const StrainLaw law : kLaws) {
    const DomainLaw own{law, kModuli, 0.7};
    EXPECT_GT(worst_error<float>(own, cases, false, {law, {3.003, 2.0}, 0.7}), kRoundings);
    EXPECT_GT(worst_error<double>(own, cases, false, {law, {3.0, 2.002}, 0.7}), kRoundings);
    EXPECT_GT(worst_error<float>(own, cases, false, {law, kModuli, 0.701}), kRoundings);
  }
}

TEST(DomainKernel, WhatSeriesCannotReachIsStillThatOfTheLaw) {
  // Turned inside out, squeezed to a plane or a line, swollen tenfold: and among them what is well.
  SplitMix64 random(5);
  for (int round = 0; round < 50; ++round) {
    std::vector<Case> cases;
    for (const Vec3& s :
         {Vec3{1.1, 0.9, -0.8}, Vec3{1.0, 0.7, 0.0}, Vec3{1.0, 0.01, 0.02}, Vec3{10, 9, 11},
          Vec3{0.2, 0.1, 0.1}, Vec3{1.0, 1.1, 0.9}, Vec3{4.0, 0.5, 0.3}, Vec3{2.0, 0.8, -0.1}}) {
      const Mat3 stretch{{s.x, 0, 0, 0, s.y, 0, 0, 0, s.z}};
      const Mat3 f = multiply(multiply(random_rotation(random), stretch), random_rotation(random));
      cases.push_back({f - kIdentity, random_matrix(random, 0.3)});
    }
    // R turns by a rounding over the least sum of two stretches, 0.03 here; damping over its square.
    const DomainLaw own{StrainLaw::kCorotated, kModuli, 0.0};
    EXPECT_LT(worst_error<float>(own, cases, false, own), kRoundings / 0.03);
    EXPECT_LT(worst_error<double>(own, cases, false, own), kRoundings / 0.03);
    const DomainLaw damped{StrainLaw::kCorotated, kModuli, 0.7};
    EXPECT_LT(worst_error<double>(damped, cases, false, damped), kRoundings / 0.0009);
    std::vector<Case> positive = cases;
    for (const std::size_t k : {0, 1, 7}) positive[k] = cases[5];
    const DomainLaw rubber{StrainLaw::kNeoHookean, kModuli, 0.7};
    // F^-T has 1 / J, and what rounds F moves J by as much over it.
    EXPECT_LT(worst_error<double>(rubber, positive, false, rubber), kRoundings / (2e-4 * 2e-4));
  }
}

TEST(DomainKernel, ALawWithoutStressGivesNoNumberThereAlone) {
  std::vector<Case> cases = make_cases(1, 0.1, true);
  cases[3].h = {{-2.0, 0, 0, 0, 0, 0, 0, 0, 0}};
  const DomainLaw law{StrainLaw::kNeoHookean, kModuli, 0.0};
  const std::vector<Mat3> p = Axes<float>(cases).stresses(law, false);
  for (std::size_t k = 0; k < p.size(); ++k) EXPECT_EQ(std::isnan(p[k].m[0]), k == 3) << k;
}

TEST(DomainKernel, ARotationIsNotResisted) {
  SplitMix64 random(9);
  for (const StrainLaw law : {StrainLaw::kCorotated, StrainLaw::kNeoHookean, StrainLaw::kStableNeoHookean}) {
    std::vector<Case> cases;
    for (std::size_t k = 0; k < kGroupDomains; ++k) {
      const Mat3 f = random_rotation(random);
      const Mat3 spin{{0.0, -0.3, 0.2, 0.3, 0.0, -0.1, -0.2, 0.1, 0.0}};
      cases.push_back({f - kIdentity, multiply(spin, f)});
    }
    for (const Mat3& p : Axes<double>(cases).stresses({law, kModuli, 5.0}, false)) EXPECT_LT(norm(p), 1e-13);
    for (const Mat3& p : Axes<float>(cases).stresses({law, kModuli, 5.0}, false)) EXPECT_LT(norm(p), 1e-4);
  }
}

/// Random domains over rows that they share.
template <typename Real>
struct RandomRun {
  RandomRun(std::uint64_t seed, std::size_t vertices, double size) : count(vertices), random(seed) {
    for (std::size_t k = 0; k < 4 * kRows; ++k) {
      u.push_back(k % 4 == 3 ? Real(0) : draw(size));
      v.push_back(k % 4 == 3 ? Real(0) : draw(size));
    }
    for (std::size_t g = 0; g < kGroups; ++g) {
      for (std::size_t i = 0; i < group_values(vertices); ++i) values.push_back(draw(i < 8 ? 0.5 : 2.0));
      for (std::size_t i = 0; i < kGroupDomains * vertices; ++i)
        at.push_back(static_cast<std::uint16_t>(4 * random.below(kRows)));
    }
  }

  Real draw(double size) { return static_cast<Real>(size * (2.0 * random.uniform() - 0.9)); }

  LargeVector<Real> forces(const DomainLaw& law, bool with_avx2) const {
    LargeVector<Real> force(4 * kRows, Real(0.25));
    const DomainRun<Real> run{count, kGroups, values.data(), at.data()};
    if (with_avx2) {
      add_domain_forces_avx2(law, run, {u.data(), v.data()}, force.data());
    } else {
      add_domain_forces(law, run, {u.data(), v.data()}, force.data());
    }
    return force;
  }

  static constexpr std::size_t kRows = 60;
  static constexpr std::size_t kGroups = 9;
  std::size_t count;
  SplitMix64 random;
  LargeVector<Real> u;
  LargeVector<Real> v;
  LargeVector<Real> values;
  LargeVector<std::uint16_t> at;
};

template <typename Real>
void compare_instruction_sets() {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    for (const std::size_t vertices : {4, 7, 15}) {
      for (const StrainLaw law : kLaws) {
        // Some that elastic_law.h has to take; neo-Hookean ones without a stress would not be equal to
        // themselves.
        const RandomRun<Real> run(seed, vertices, law == StrainLaw::kNeoHookean ? 0.02 : 0.2);
        for (const double damping : {0.0, 0.3}) {
          const DomainLaw own{law, kModuli, damping};
          EXPECT_EQ(run.forces(own, true), run.forces(own, false))
              << strain_law_name(law) << " seed " << seed;
        }
      }
    }
  }
}

TEST(DomainKernel, WithAvx2TheBitsAreTheSame) {
  if (!has_avx2()) GTEST_SKIP() << "no AVX2 here; the engine takes the other form";
  compare_instruction_sets<float>();
  compare_instruction_sets<double>();
}

}  // namespace
}  // namespace palpate::dynamics
