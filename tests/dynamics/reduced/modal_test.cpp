// Modes: the closed form of an oscillator, energies that are kept, and motion that refines to the elements'.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/base/error.h"
#include "core/dynamics/reduced/modal_phase.h"
#include "core/mesh/shapes/shapes.h"
#include "reference/closed_form/structured_mesh.h"
#include "tests/support/motion_cases.h"

namespace palpate::dynamics {
namespace {

TEST(ExactStep, OneModeIsTheClosedFormOfTheDampedOscillator) {
  for (const double damping : {0.0, 3.0, 30.0}) {
    const SmallSystem system{{400.0}, {damping}, {}, {}, 0};
    for (const double step_s : {1e-3, 0.05, 2.0}) {  // the last is far beyond any explicit bound
      ExactStep step(system, step_s);
      std::vector<double> eta{0.7};
      std::vector<double> rate{0.0};
      for (int k = 1; k <= 20; ++k) {
        step.advance(eta, rate, {}, {});
        EXPECT_NEAR(eta[0], testing_support::oscillator_at(20.0, damping, 0.7, k * step_s), 1e-12);
      }
    }
  }
}

TEST(ExactStep, ALoadThatRunsStraightIsFollowedWithoutError) {
  // x'' + w^2 x = g t from rest: x = g / w^2 (t - sin(w t) / w).
  const double w = 20.0;
  const double g = 5.0;
  ExactStep step({{w * w}, {0.0}, {g}, {0.0}, 1}, 0.3);
  std::vector<double> eta{0.0};
  std::vector<double> rate{0.0};
  for (int k = 1; k <= 10; ++k) {
    const double t = 0.3 * k;
    step.advance(eta, rate, std::vector<double>{t - 0.3}, std::vector<double>{t});
    EXPECT_NEAR(eta[0], g / (w * w) * (t - std::sin(w * t) / w), 1e-13);
    EXPECT_NEAR(rate[0], g / (w * w) * (1.0 - std::cos(w * t)), 1e-12);
  }
}

TEST(ExactStep, EnergyIsKeptWithoutDampingAndFallsWithIt) {
  const auto energy = [](const SmallSystem& system, const std::vector<double>& eta,
                         const std::vector<double>& rate) {
    double sum = 0.0;
    for (std::size_t k = 0; k < eta.size(); ++k)
      sum += 0.5 * rate[k] * rate[k] + 0.5 * system.squares[k] * eta[k] * eta[k];
    return sum;
  };
  SmallSystem system{{100.0, 2500.0, 1e6}, std::vector<double>(9, 0.0), {}, {}, 0};
  ExactStep step(system, 0.013);
  std::vector<double> eta{1.0, 0.3, 0.02};
  std::vector<double> rate{0.0, 2.0, -1.0};
  const double start = energy(system, eta, rate);
  for (int k = 0; k < 10000; ++k) step.advance(eta, rate, {}, {});
  EXPECT_NEAR(energy(system, eta, rate), start, 1e-9 * start);
  system.damping = {2.0, 0.5, 0.0, 0.5, 3.0, 0.1, 0.0, 0.1, 9.0};  // coupled, positive definite
  ExactStep damped(system, 0.013);
  double before = energy(system, eta, rate);
  for (int k = 0; k < 100; ++k) {
    damped.advance(eta, rate, {}, {});
    const double now = energy(system, eta, rate);
    ASSERT_LT(now, before);
    before = now;
  }
}

TEST(ExactStep, TheStepDoesNotMatterWhereLoadsRunStraight) {
  const SmallSystem system{{100.0, 2500.0}, {2.0, 0.5, 0.5, 3.0}, {4.0, -1.0}, {0.1, 0.2}, 1};
  std::vector<double> coarse{0.0, 0.0};
  std::vector<double> coarse_rate{0.0, 0.0};
  std::vector<double> fine = coarse;
  std::vector<double> fine_rate = coarse_rate;
  ExactStep whole(system, 0.2);
  ExactStep part(system, 0.02);
  whole.advance(coarse, coarse_rate, std::vector<double>{0.0}, std::vector<double>{1.0});
  for (int k = 0; k < 10; ++k)
    part.advance(fine, fine_rate, std::vector<double>{0.1 * k}, std::vector<double>{0.1 * (k + 1)});
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_NEAR(coarse[k], fine[k], 1e-13);
    EXPECT_NEAR(coarse_rate[k], fine_rate[k], 1e-12);
  }
}

/// A bar held at x = 0 and pulled at its end by a traction.
struct Bar {
  TetMesh mesh = reference::build_mapped_block({6, 2, 2}, [](const Vec3& p) {
    return Vec3{0.1 * p.x, 0.02 * p.y, 0.02 * p.z};
  });
  ElementSpace space;
  ElementMatrices body;
  BoundaryProblem problem;

  explicit Bar(int order) {
    problem.material = {1e4, 0.3, 1000.0};
    problem.held.push_back({reference::select_boundary(mesh, [](const Vec3& p) { return p.x < 1e-12; }),
                            {true, true, true},
                            {}});
    const auto end = reference::select_boundary(mesh, [](const Vec3& p) { return p.x > 0.1 - 1e-12; });
    problem.tractions.push_back({{end, std::vector<double>(end.size(), 1.0)}, {3.0, 1.0, -2.0}, 0.0});
    space = build_element_space(mesh, order);
    body = build_element_matrices(mesh, space, problem.material);
  }

  ModalPhase phase(const ModalOptions& options) const {
    std::vector<ModalGroup> groups{
        {build_node_loads(mesh, space, problem, BodyForces::kInclude), {{0.0, 0.5}, {0.0, 1.0}, true}}};
    return {body, space.order, std::move(groups), options, factor_simplicial};
  }
  std::vector<Vec3> rest() const {
    const NodeLoads loads = build_node_loads(mesh, space, problem, BodyForces::kInclude);
    return HeldElements(body, body.stiffness, loads.held, factor_simplicial)
        .rest_under(loads.force_n, loads.held_by_m);
  }
};

double off_from(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double sum = 0.0;
  double size = 0.0;
  for (std::size_t v = 0; v < a.size(); ++v) {
    sum += length_sq(a[v] - b[v]);
    size += length_sq(a[v]);
  }
  return std::sqrt(sum / size);
}

TEST(ModalPhase, ModesAreOrthonormalAndRise) {
  const Bar bar(2);
  const NodeLoads loads = build_node_loads(bar.mesh, bar.space, bar.problem, BodyForces::kInclude);
  const LowestModes found =
      HeldElements(bar.body, bar.body.stiffness, loads.held, factor_simplicial).find_modes(8);
  std::vector<Vec3> product(bar.space.nodes());
  for (std::size_t a = 0; a < 8; ++a) {
    multiply_mass(bar.body, found.modes[a], product);
    for (std::size_t b = 0; b < 8; ++b) {
      double sum = 0.0;
      for (std::size_t v = 0; v < product.size(); ++v) sum += dot(product[v], found.modes[b][v]);
      EXPECT_NEAR(sum, a == b ? 1.0 : 0.0, 1e-9);
    }
    multiply(bar.body.stiffness, found.modes[a], product);
    double square = 0.0;
    for (std::size_t v = 0; v < product.size(); ++v) square += dot(product[v], found.modes[a][v]);
    EXPECT_NEAR(square, found.squares_per_s2[a], 1e-8 * square);
    if (a > 0) {
      EXPECT_GE(found.squares_per_s2[a], found.squares_per_s2[a - 1]);
    }
  }
}

TEST(ModalPhase, TheStaticCorrectionMakesRestExactAndModesAloneConverge) {
  const Bar bar(2);
  const std::vector<Vec3> truth = bar.rest();
  const auto rest = [&](std::size_t modes, bool correction) {
    ModalPhase phase = bar.phase({modes, correction, 0.0, 0.0});
    phase.start({std::vector<Vec3>(truth.size()), std::vector<Vec3>(truth.size())}, 1.0);  // full share
    phase.rest();
    return off_from(truth, phase.state().displacement_m);
  };
  EXPECT_LT(rest(1, true), 1e-9);
  EXPECT_LT(rest(12, true), 1e-9);
  const double few = rest(6, false);
  const double many = rest(60, false);
  EXPECT_GT(few, 1e-4);
  EXPECT_LT(many, 0.5 * few);
}

TEST(ModalPhase, ADampedBarComesToItsRest) {
  const Bar bar(1);
  ModalPhase phase = bar.phase({20, true, 5e-3, 12.0});
  const std::vector<Vec3> truth = bar.rest();
  phase.start({std::vector<Vec3>(truth.size()), std::vector<Vec3>(truth.size())}, 0.0);
  for (int k = 1; k <= 600; ++k) phase.advance(0.01, 0.01 * k);
  EXPECT_LT(off_from(truth, phase.state().displacement_m), 1e-8);
  const ModalMeasure at_rest = phase.measure();
  // What holds bears the load: traction x area, the other way; the group's total is then zero.
  EXPECT_LT(length(at_rest.group_force_n[0]), 1e-6 * 3.0 * 4e-4);
  EXPECT_NEAR(at_rest.load_j, -2.0 * at_rest.elastic_j, 1e-7 * at_rest.elastic_j);
}

TEST(ModalPhase, AStateComesBackThroughStart) {
  const Bar bar(1);
  ModalPhase phase = bar.phase({20, true, 1e-3, 1.0});
  const std::size_t n = bar.space.nodes();
  phase.start({std::vector<Vec3>(n), std::vector<Vec3>(n)}, 0.0);
  for (int k = 1; k <= 30; ++k) phase.advance(0.01, 0.01 * k);
  const NodeState state = phase.state();
  ModalPhase again = bar.phase({20, true, 1e-3, 1.0});
  EXPECT_LT(again.start(state, 0.3), 1e-9);
  EXPECT_LT(off_from(state.displacement_m, again.state().displacement_m), 1e-9);
  EXPECT_LT(off_from(state.velocity_m_s, again.state().velocity_m_s), 1e-9);
  // Fewer modes cannot hold it, and say so.
  ModalPhase fewer = bar.phase({2, false, 1e-3, 1.0});
  EXPECT_GT(fewer.start(state, 0.3), 1e-6);
}

TEST(ModalPhase, RefusesMoreModesThanThereAre) {
  const Bar bar(1);
  EXPECT_THROW(bar.phase({100000, true, 0.0, 0.0}), InputError);
  EXPECT_THROW(bar.phase({0, true, 0.0, 0.0}), InputError);
}

}  // namespace
}  // namespace palpate::dynamics
