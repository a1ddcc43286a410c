// Damping of strain energies: of the rate of their own strain, so that what turns as a whole is not resisted.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/base/random.h"
#include "core/dynamics/motion/motion_forces.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/law_cases.h"
#include "tests/support/motion_cases.h"

namespace palpate::dynamics {
namespace {

using namespace testing_support;

constexpr std::array kTurning{StrainLaw::kCorotated, StrainLaw::kNeoHookean, StrainLaw::kStableNeoHookean};
constexpr Moduli kViscous{3.0, 2.0};

/// A displacement gradient; of the corotated law every third turns the inside out.
Mat3 random_gradient(StrainLaw law, SplitMix64& random, int k) {
  Mat3 h = random_matrix(random, 0.3);
  if (law == StrainLaw::kCorotated && k % 3 == 0)
    h = multiply(kIdentity + h, {{1, 0, 0, 0, 1, 0, 0, 0, -0.7}}) - kIdentity;
  return h;
}

/// The root of F^T F, by its eigenvectors.
Mat3 right_stretch(const Mat3& f) {
  using Rows3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  const Mat3 square = multiply_transposed(f, f);
  const Eigen::SelfAdjointEigenSolver<Rows3> eigen(Eigen::Map<const Rows3>(square.m.data()));
  Mat3 out;
  Eigen::Map<Rows3>(out.m.data()) = eigen.operatorSqrt();
  return out;
}

TEST(StrainDamping, PowerIsThatOfTheRateOfTheLawsOwnStrain) {
  SplitMix64 random(21);
  const double step = 1e-5;  // error of a central difference: its square; of the roots: 1e-15 / step
  for (int k = 0; k < 60; ++k) {
    const Mat3 h = random_gradient(StrainLaw::kCorotated, random, k);
    const Mat3 rate = random_matrix(random, 1.0);
    const Mat3 f = kIdentity + h;
    const Mat3 u_rate = (0.5 / step) * (right_stretch(f + step * rate) - right_stretch(f - step * rate));
    const double power = contract(damping_stress(StrainLaw::kCorotated, kViscous, h, rate), rate);
    EXPECT_NEAR(power, 4.0 * contract(u_rate, u_rate) + 3.0 * trace(u_rate) * trace(u_rate), 1e-7) << k;
  }
  for (int k = 0; k < 60; ++k) {
    const Mat3 h = random_gradient(StrainLaw::kNeoHookean, random, k);
    const Mat3 rate = random_matrix(random, 1.0);
    const Mat3 f = kIdentity + h;
    const auto log_j = [&](double s) { return std::log(determinant(f + s * rate)); };
    const double dilatation = (log_j(step) - log_j(-step)) / (2.0 * step);
    const Moduli bulk{3.0, 0.0};
    EXPECT_NEAR(contract(damping_stress(StrainLaw::kNeoHookean, bulk, h, rate), rate),
                3.0 * dilatation * dilatation, 1e-7 * (1.0 + dilatation * dilatation));
    // 2 mu d : d with d = F^-T (C' / 2) F^-1, C = F^T F.
    const Mat3 inverse = transpose((1.0 / determinant(f)) * cofactors(f));
    const Mat3 c_rate = multiply_transposed(f, rate) + multiply_transposed(rate, f);
    const Mat3 d = multiply(transpose(inverse), multiply(0.5 * c_rate, inverse));
    EXPECT_NEAR(contract(damping_stress(StrainLaw::kNeoHookean, {0.0, 2.0}, h, rate), rate),
                4.0 * contract(d, d), 1e-12 * (1.0 + contract(d, d)));
  }
}

TEST(StrainDamping, ASpinIsNotResistedAndNoMomentExerted) {
  SplitMix64 random(22);
  for (const StrainLaw law : kTurning) {
    for (int k = 0; k < 60; ++k) {
      const Mat3 h = random_gradient(law, random, k);
      const Mat3 f = kIdentity + h;
      const Mat3 rate = random_matrix(random, 1.0);
      const Mat3 any = random_matrix(random, 1.0);
      const Mat3 p = damping_stress(law, kViscous, h, rate);
      const Mat3 spun = damping_stress(law, kViscous, h, rate + multiply(any - transpose(any), f));
      EXPECT_LT(norm(spun - p), 1e-12 * (1.0 + norm(p))) << strain_law_name(law) << ' ' << k;
      const Mat3 moment = multiply(p, transpose(f));
      EXPECT_LT(norm(moment - transpose(moment)), 1e-13 * (1.0 + norm(p))) << strain_law_name(law);
      EXPECT_GE(contract(p, rate), 0.0);
    }
  }
  // The rate of eps, which was taken for all laws once, resists the spin of a body that has turned.
  const Mat3 quarter = make_rotation({0, 0, 1}, 1.5707963267948966);
  const Mat3 spin{{0, -1, 0, 1, 0, 0, 0, 0, 0}};
  EXPECT_GT(norm(damping_stress(StrainLaw::kLinear, kViscous, quarter - kIdentity, multiply(spin, quarter))),
            1.0);
}

TEST(StrainDamping, TheTangentIsItsMatrixAndTheLinearOneAtRest) {
  SplitMix64 random(23);
  const Tangent9 linear = tangent(StrainLaw::kLinear, kViscous, {});
  for (const StrainLaw law : kLaws) {
    const Tangent9 rest = damping_tangent(law, kViscous, {});
    for (std::size_t k = 0; k < 81; ++k) EXPECT_NEAR(rest[k], linear[k], 1e-14) << strain_law_name(law);
    for (int k = 0; k < 30; ++k) {
      const Mat3 h = random_gradient(law, random, k);
      const Mat3 rate = random_matrix(random, 1.0);
      const Mat3 p = damping_stress(law, kViscous, h, rate);
      const Tangent9 c = damping_tangent(law, kViscous, h);
      for (std::size_t i = 0; i < 9; ++i) {
        double sum = 0.0;
        for (std::size_t j = 0; j < 9; ++j) {
          sum += c[9 * i + j] * rate.m[j];
          EXPECT_NEAR(c[9 * i + j], c[9 * j + i], 1e-12);
        }
        EXPECT_NEAR(sum, p.m[i], 1e-12);
      }
    }
  }
}

TEST(StrainDamping, AGradientWithoutATurnGivesANumber) {
  for (const Mat3& f : {Mat3{}, outer({1, 2, 3}, {0, 1, 0}), (-1.0) * kIdentity}) {
    const Mat3 p = damping_stress(StrainLaw::kCorotated, kViscous, f - kIdentity, kIdentity);
    EXPECT_TRUE(std::isfinite(norm(p)));
  }
}

/// A body with one way of damping a strain energy; springs, where it has them, damp along themselves.
struct DampedBody {
  std::string name;
  MotionModel model;
};

std::vector<DampedBody> make_damped_bodies(const TetMesh& mesh) {
  const Material material{1000.0, 0.4, 1000.0};
  std::vector<DampedBody> bodies;
  for (const StrainLaw law : kTurning) {
    for (const VolumeModel volume :
         {VolumeModel::kTet, VolumeModel::kNodeAverage, VolumeModel::kNodeSmoothed}) {
      MotionModel model = make_free_body(mesh, 0.02, volume);
      for (StrainTerm& term : model.elastic.strain_terms) term.law = law;
      bodies.push_back({std::string(volume_model_name(volume)) + ", " + strain_law_name(law), model});
    }
    for (const StrainDomain domain : {StrainDomain::kTet, StrainDomain::kEdge, StrainDomain::kNode}) {
      MotionModel model = make_free_body(mesh, 0.02);
      model.spring_damping_n_s_per_m.clear();
      model.elastic =
          build_blend_model(mesh, material, {StrainSize::kLarge, law, 0.7, domain, StrainDomain::kTet}).model;
      bodies.push_back(
          {std::string("blend at ") + strain_domain_name(domain) + ", " + strain_law_name(law), model});
    }
  }
  return bodies;
}

/// What damping adds to the forces.
std::vector<Vec3> damping_forces(const MotionModel& model, const std::vector<Vec3>& u,
                                 const std::vector<Vec3>& v) {
  MotionForces forces(model, 1);
  std::vector<Vec3> moving(u.size());
  std::vector<Vec3> still(u.size());
  forces.evaluate(u, v, 0.0, moving);
  forces.evaluate(u, std::vector<Vec3>(u.size()), 0.0, still);
  for (std::size_t i = 0; i < u.size(); ++i) moving[i] = moving[i] - still[i];
  return moving;
}

Vec3 angular_momentum(const MotionModel& model, const MotionState& state) {
  Vec3 sum;
  for (std::size_t i = 0; i < model.mass_kg.size(); ++i)
    sum = sum +
          model.mass_kg[i] * cross(model.elastic.rest[i] + state.displacement_m[i], state.velocity_m_s[i]);
  return sum;
}

/// Turned by `angle` about z and spinning at `rate` about the axis (1, 2, 3), deformed by up to `strain`.
MotionState make_spinning(const MotionModel& model, double angle, double rate, double strain) {
  MotionState state = start_at_rest(model);
  const Mat3 turn = make_rotation({0, 0, 1}, angle);
  const std::vector<Vec3> bent = make_random_field(model.mass_kg.size(), strain, 4);
  for (std::size_t i = 0; i < bent.size(); ++i) {
    const Vec3 x = turn * (model.elastic.rest[i] + bent[i]);
    state.displacement_m[i] = x - model.elastic.rest[i];
    state.velocity_m_s[i] = cross((rate / std::sqrt(14.0)) * Vec3{1, 2, 3}, x);
  }
  return state;
}

TEST(StrainDamping, ForcesOfABodyHaveNoSumNoMomentAndTakeEnergy) {
  const TetMesh mesh = build_kuhn_cube(2, 0.1, 3);
  for (const DampedBody& body : make_damped_bodies(mesh)) {
    const MotionState spinning = make_spinning(body.model, 2.0, 1.0, 0.05);
    const std::vector<Vec3> v = make_random_field(mesh.points.size(), 1.0, 5);
    const std::vector<Vec3> force = damping_forces(body.model, spinning.displacement_m, v);
    Vec3 sum;
    Vec3 moment;
    double power = 0.0;
    double size = 0.0;
    for (std::size_t i = 0; i < force.size(); ++i) {
      sum = sum + force[i];
      moment = moment + cross(mesh.points[i] + spinning.displacement_m[i], force[i]);
      power += dot(force[i], v[i]);
      size += length(force[i]);
    }
    EXPECT_LT(length(sum), 1e-13 * size) << body.name;
    EXPECT_LT(length(moment), 1e-12 * size) << body.name;
    EXPECT_LT(power, -0.01 * size) << body.name;  // of velocities of about 1 m/s
    const std::vector<Vec3> spun = damping_forces(body.model, spinning.displacement_m, spinning.velocity_m_s);
    EXPECT_LT(field_norm(spun), 1e-12 * size) << body.name;
  }
}

TEST(StrainDamping, AFreeBodyGoesOnTurning) {
  const TetMesh mesh = build_kuhn_cube(1, 0.0, 1);
  for (const DampedBody& body : make_damped_bodies(mesh)) {
    const MotionState start = make_spinning(body.model, 0.0, 1.0, 0.0);
    for (const IntegratorKind kind : {IntegratorKind::kSymplecticEuler, IntegratorKind::kImplicitEuler}) {
      IntegratorOptions options;
      options.kind = kind;
      const MotionState end = march(body.model, options, start, 3.2, 160);
      const Vec3 before = angular_momentum(body.model, start);
      const double off = length(angular_momentum(body.model, end) - before) / length(before);
      // Symplectic Euler keeps x' x v' = x x (v + h a) for forces without a moment: rounding is all.
      // Linearised, a step of 20 ms at 1 rad/s takes some (h w)^2 of the turning with it.
      EXPECT_LT(off, kind == IntegratorKind::kSymplecticEuler ? 1e-10 : 160 * 4e-4) << body.name;
      EXPECT_LT(length(measure_momentum(body.model, end) - measure_momentum(body.model, start)),
                1e-10 * length(before))
          << body.name;
    }
  }
}

TEST(StrainDamping, OfTheLinearLawIsSteadyAboutThePlacesAtRest) {
  const TetMesh mesh = build_kuhn_cube(2, 0.1, 3);
  const Material material{1000.0, 0.4, 1000.0};
  MotionModel model = make_free_body(mesh, 0.02);
  model.spring_damping_n_s_per_m.clear();
  model.elastic = build_blend_model(mesh, material, {}).model;
  const std::vector<Vec3> u = make_random_field(mesh.points.size(), 0.05, 4);
  const std::vector<Vec3> v = make_random_field(mesh.points.size(), 1.0, 5);
  const std::vector<Vec3> force = damping_forces(model, u, v);
  Vec3 sum;
  Vec3 moment;
  double size = 0.0;
  for (std::size_t i = 0; i < force.size(); ++i) {
    sum = sum + force[i];
    moment = moment + cross(mesh.points[i], force[i]);
    size += length(force[i]);
  }
  EXPECT_LT(length(sum), 1e-12 * size);
  EXPECT_LT(length(moment), 1e-12 * size);
}

}  // namespace
}  // namespace palpate::dynamics
