#include "core/dynamics/stability/slow_rates.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/base/error.h"
#include "core/dynamics/integrators/integrator.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/motion_cases.h"

namespace palpate::dynamics {
namespace {

using namespace testing_support;

/// A chain of n masses along x between two walls; it moves along x alone.
struct Chain {
  std::size_t masses = 0;
  double mass = 0.5;
  double stiffness = 40.0;
  double spring_damping = 0.0;
  double drag = 0.0;

  MotionModel build() const {
    MotionModel model;
    const std::size_t n = masses + 2;
    Loads walls{std::vector<Vec3>(n), {}, std::vector<std::uint8_t>(n, 6), std::vector<Vec3>(n)};
    walls.held.front() = walls.held.back() = 7;
    for (std::size_t v = 0; v < n; ++v)
      model.elastic.rest.push_back({0.1 * static_cast<double>(v), 0.0, 0.0});
    for (Index v = 0; v + 1 < n; ++v) {
      model.elastic.springs.springs.push_back({v, v + 1});
      model.elastic.springs.rest_length_m.push_back(
          length(model.elastic.rest[v + 1] - model.elastic.rest[v]));
      model.elastic.springs.stiffness_n_per_m.push_back(stiffness);
      model.spring_damping_n_s_per_m.push_back(spring_damping);
    }
    model.mass_kg.assign(n, mass);
    model.environment_damping_n_s_per_m.assign(n, drag);
    model.loads.push_back({walls, {}});
    return model;
  }

  /// Both roots of mode j, from 1: k_j = 2 k (1 - cos(j pi / (n + 1))), d_j = gamma + c k_j / k.
  std::vector<std::complex<double>> roots(std::size_t mode) const {
    const double share =
        2.0 *
        (1.0 - std::cos(static_cast<double>(mode) * std::numbers::pi / static_cast<double>(masses + 1)));
    const double damping = (drag + spring_damping * share) / mass;
    const std::complex<double> root =
        std::sqrt(std::complex<double>(damping * damping - 4.0 * stiffness * share / mass));
    return {0.5 * (-damping + root), 0.5 * (-damping - root)};
  }
};

TEST(SlowRates, AnOverdampedChainHasItsClosedForm) {
  const Chain chain{30, 0.5, 40.0, 5.0, 800.0};
  const SlowRates rates = find_slow_rates(chain.build());
  ASSERT_TRUE(rates.converged);
  ASSERT_EQ(rates.lambda_per_s.size(), 6U);
  for (std::size_t j = 0; j < 6; ++j) {
    const std::complex<double> expected = chain.roots(j + 1).front();
    EXPECT_LT(std::abs(rates.lambda_per_s[j] - expected), 1e-9 * std::abs(expected)) << j;
  }
  EXPECT_NEAR(rates.slowest_decay_s(), -1.0 / chain.roots(1).front().real(), 1e-6 * rates.slowest_decay_s());
}

TEST(SlowRates, AnUnderdampedChainComesInPairs) {
  const Chain chain{25, 0.5, 40.0, 0.3, 0.2};
  const SlowRates rates = find_slow_rates(chain.build());
  ASSERT_TRUE(rates.converged);
  for (std::size_t j = 0; j < 6; ++j) {
    const std::complex<double> upper = chain.roots(j / 2 + 1).front();
    const std::complex<double> expected = j % 2 == 0 ? std::conj(upper) : upper;
    EXPECT_LT(std::abs(rates.lambda_per_s[j] - expected), 1e-8 * std::abs(expected)) << j;
  }
}

TEST(SlowRates, ABodyComesBackAtTheSlowestRate) {
  const TetMesh mesh = build_kuhn_cube(3, 0.2, 5);
  for (const VolumeModel volume : {VolumeModel::kNone, VolumeModel::kThesis}) {
    MotionModel model = make_pressed_body(mesh, 0.2, volume);
    model.loads.pop_back();
    model.loads.front().loads.force_n.assign(mesh.points.size(), {});
    for (double& drag : model.environment_damping_n_s_per_m) drag *= 10.0;  // overdamped
    const SlowRates rates = find_slow_rates(model);
    ASSERT_TRUE(rates.converged);
    const double decay = rates.slowest_decay_s();
    MotionState state = start_at_rest(model);
    state.displacement_m.back() = {1e-6, 0.0, 0.0};
    IntegratorOptions options;
    options.kind = IntegratorKind::kRungeKutta4;
    const auto steps = static_cast<std::uint64_t>(std::ceil(decay / 0.02));
    state = march(model, options, state, 8.0 * decay, 8 * steps);  // the faster ones are gone
    const double before = field_norm(state.displacement_m);
    state = march(model, options, state, decay, steps);
    EXPECT_NEAR(before / field_norm(state.displacement_m), std::exp(1.0), 0.01 * std::exp(1.0));
  }
}

TEST(SlowRates, AFreeBodyDoesNotComeBack) {
  EXPECT_THROW(find_slow_rates(make_free_body(build_kuhn_cube(2, 0.0, 1), 0.1)), InputError);
  Chain floppy{5};
  MotionModel model = floppy.build();
  for (std::uint8_t& held : model.loads.front().loads.held) held = 0;
  EXPECT_THROW(find_slow_rates(model), InputError);
}

}  // namespace
}  // namespace palpate::dynamics
