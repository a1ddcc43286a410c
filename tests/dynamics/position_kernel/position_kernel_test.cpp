// XPBD in lanes: the steps of one constraint at a time in the same order, the same bits with AVX2 and
// without, padding that does nothing.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>
#include <vector>

#include "core/base/processor.h"
#include "core/dynamics/integrators/position_step.h"
#include "core/dynamics/motion/time_profile.h"
#include "core/dynamics/position_kernel/spring_sweep.h"
#include "core/dynamics/position_kernel/strain_sweep.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/dynamics_cases.h"
#include "tests/support/motion_cases.h"

namespace palpate::dynamics {
namespace {

using namespace testing_support;

constexpr double kStepS = 0.05;

/// Displacements after `steps` of `sweeps` sweeps each, thrown at random.
std::vector<Vec3> move_with(const MotionModel& model, PositionKernel kernel, std::size_t sweeps,
                            std::size_t steps) {
  MotionForces forces(model, 1);
  PositionStep step(forces, {sweeps, 0.0}, kernel);
  MotionState state = start_at_rest(model);
  state.velocity_m_s = make_random_field(model.mass_kg.size(), 0.5, 3);
  std::vector<Vec3> next(state.displacement_m.size());
  for (std::size_t k = 0; k < steps; ++k) {
    const double h = k < steps / 2 ? kStepS : 0.5 * kStepS;
    step.find_displacement(forces, state, h, next);
    for (std::size_t v = 0; v < next.size(); ++v)
      state.velocity_m_s[v] = (1.0 / h) * (next[v] - state.displacement_m[v]);
    state.displacement_m = next;
    state.time_s += h;
  }
  return state.displacement_m;
}

bool has_same_bits(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Vec3)) == 0;
}

/// A body whose lowest layer is held and whose top is moved; `is_partly_held`: the top is free along y.
MotionModel make_held_body(const TetMesh& mesh, double damping_s, bool is_partly_held) {
  MotionModel model = make_pressed_body(mesh, 0.3, VolumeModel::kNone);
  for (std::size_t s = 0; s < model.elastic.springs.springs.size(); ++s)
    model.spring_damping_n_s_per_m[s] = damping_s * model.elastic.springs.stiffness_n_per_m[s];
  for (TimedLoads& group : model.loads) {
    for (std::uint8_t& bits : group.loads.held) {
      if (bits != 0 && !is_partly_held) bits = 7;
    }
  }
  return model;
}

TEST(PositionKernel, SpringsInLanesMoveAsOneAtATime) {
  const TetMesh mesh = build_kuhn_cube(3, 0.2, 5);
  for (const bool is_linear : {false, true}) {
    for (const double damping_s : {0.0, 0.02}) {
      MotionModel model = make_held_body(mesh, damping_s, false);
      model.elastic.springs_are_linear = is_linear;
      const std::vector<Vec3> wanted = move_with(model, PositionKernel::kSingle, 3, 8);
      EXPECT_GT(field_norm(wanted), 0.1);
      // Every operation of a spring in lanes is one of the formula: bit for bit.
      EXPECT_TRUE(has_same_bits(move_with(model, PositionKernel::kPortable, 3, 8), wanted)) << is_linear;
      if (has_avx2()) {
        EXPECT_TRUE(has_same_bits(move_with(model, PositionKernel::kBest, 3, 8), wanted)) << is_linear;
      }
      // Another order of the sweep is told apart.
      std::swap(model.elastic.springs.springs.front(), model.elastic.springs.springs.back());
      std::swap(model.elastic.springs.stiffness_n_per_m.front(),
                model.elastic.springs.stiffness_n_per_m.back());
      std::swap(model.elastic.springs.rest_length_m.front(), model.elastic.springs.rest_length_m.back());
      std::swap(model.spring_damping_n_s_per_m.front(), model.spring_damping_n_s_per_m.back());
      EXPECT_FALSE(has_same_bits(move_with(model, PositionKernel::kPortable, 3, 8), wanted));
    }
  }
}

TEST(PositionKernel, DomainsInLanesMoveAsOneAtATimeToRounding) {
  const TetMesh mesh = build_kuhn_cube(3, 0.2, 5);
  for (const Continuum kind : {Continuum::kTets, Continuum::kEdgeNode}) {
    for (const StrainLaw law : {StrainLaw::kLinear, StrainLaw::kCorotated, StrainLaw::kStableNeoHookean}) {
      for (const double damping_s : {0.0, 0.02}) {
        SCOPED_TRACE(::testing::Message()
                     << static_cast<int>(kind) << ' ' << static_cast<int>(law) << ' ' << damping_s);
        MotionModel model = make_continuum(make_held_body(mesh, 0.0, false), mesh, kind, law);
        model.strain_damping_s = damping_s;
        const std::vector<Vec3> wanted = move_with(model, PositionKernel::kSingle, 3, 8);
        EXPECT_GT(field_norm(wanted), 0.1);
        const std::vector<Vec3> found = move_with(model, PositionKernel::kPortable, 3, 8);
        // 24 sweeps; a rounding of a step grows with those after it as fast as the body may be thrown.
        EXPECT_LT(field_distance(found, wanted), 1e-11 * field_norm(wanted));
        if (has_avx2()) {
          EXPECT_TRUE(has_same_bits(move_with(model, PositionKernel::kBest, 3, 8), found));
        }
        // A modulus that is off by a millionth is told apart.
        for (StrainTerm& term : model.elastic.strain_terms) term.moduli.mu_pa *= 1.0 + 1e-6;
        EXPECT_GT(field_distance(move_with(model, PositionKernel::kPortable, 3, 8), wanted),
                  1e-10 * field_norm(wanted));
      }
    }
  }
}

TEST(PositionKernel, WhatIsHeldAlongSomeAxesMovesAlongTheOthersAlone) {
  const TetMesh mesh = build_kuhn_cube(3, 0.2, 5);
  const MotionModel springs = make_held_body(mesh, 0.02, true);
  MotionModel tets =
      make_continuum(make_held_body(mesh, 0.0, true), mesh, Continuum::kTets, StrainLaw::kStableNeoHookean);
  tets.strain_damping_s = 0.02;
  for (const MotionModel& model : {springs, tets}) {
    const std::vector<Vec3> wanted = move_with(model, PositionKernel::kSingle, 3, 8);
    const std::vector<Vec3> found = move_with(model, PositionKernel::kBest, 3, 8);
    EXPECT_LT(field_distance(found, wanted), 1e-11 * field_norm(wanted));
    const double share = value_at(model.loads[1].profile, 4 * kStepS + 4 * 0.5 * kStepS).share;
    std::size_t held = 0;
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
      if (model.loads[1].loads.held[v] != 5) continue;
      ++held;
      EXPECT_NEAR(found[v].x, 0.1 * share, 1e-14);
      EXPECT_NEAR(found[v].z, -0.1 * share, 1e-14);
      EXPECT_NE(found[v].y, 0.0);
    }
    EXPECT_GT(held, 0U);
  }
}

TEST(PositionKernel, ASpringOfNoLengthHasNoDirection) {
  // Its ends are pushed through each other, so that for a step it has no length: nothing may become NaN.
  MotionModel model = make_oscillator(3.0, 0.0);
  MotionForces forces(model, 1);
  std::array<std::vector<Vec3>, 2> ends;
  std::size_t at = 0;
  for (const PositionKernel kernel : {PositionKernel::kSingle, PositionKernel::kBest}) {
    PositionStep step(forces, {3, 0.0}, kernel);
    MotionState state = start_at_rest(model);
    state.displacement_m[1] = model.elastic.rest[0] - model.elastic.rest[1];
    std::vector<Vec3> next(state.displacement_m.size());
    step.find_displacement(forces, state, kStepS, next);
    EXPECT_EQ(next[1], state.displacement_m[1]);
    state.velocity_m_s[1] = {0.3, 0.0, 0.0};
    step.find_displacement(forces, state, kStepS, next);
    EXPECT_TRUE(is_finite(next[1]));
    EXPECT_NE(next[1], state.displacement_m[1]);
    ends[at++] = next;
  }
  EXPECT_TRUE(has_same_bits(ends[0], ends[1]));
}

TEST(PositionKernel, PaddingDoesNothing) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 5);
  const std::size_t n = mesh.points.size();
  const MotionModel springs = make_held_body(mesh, 0.02, false);
  const MotionModel tets =
      make_continuum(make_held_body(mesh, 0.0, false), mesh, Continuum::kEdgeNode, StrainLaw::kCorotated);
  PositionRows now = make_rows(n);
  PositionRows before = make_rows(n);
  const std::vector<Vec3> u = make_random_field(n, 0.05, 7);
  for (std::size_t v = 0; v < n; ++v) {
    set_row(now, v, u[v]);
    now[kRowNumbers * v + 3] = 0.5;
  }
  // One spring and one domain alone: seven of eight lanes are padding.
  const std::vector<Index> chosen{4};
  const std::vector<std::vector<Index>> colours{{0}};
  SpringSweep one_spring(springs.elastic, springs.spring_damping_n_s_per_m, chosen, colours);
  one_spring.prepare(kStepS);
  StrainSweep one_domain(tets.elastic.strain_terms.front(), n, chosen, colours);
  one_domain.prepare(kStepS, 0.02, now);
  const auto moved_rows = [&](const auto& sweep) {
    PositionRows after = now;
    for (const bool is_backward : {false, true}) {
      sweep(SweptRows{after.data(), before.data()}, SweepOrder{!is_backward, is_backward, false});
    }
    std::vector<std::size_t> moved;
    for (std::size_t v = 0; v <= n; ++v) {
      if (std::memcmp(&after[kRowNumbers * v], &now[kRowNumbers * v], kRowNumbers * sizeof(double)) != 0)
        moved.push_back(v);
    }
    for (std::size_t k = 0; k < kRowNumbers; ++k) EXPECT_EQ(after[kRowNumbers * n + k], 0.0);
    return moved;
  };
  for (const bool with_avx2 : {false, true}) {
    if (with_avx2 && !has_avx2()) continue;
    const auto ends = springs.elastic.springs.springs[4];
    std::vector<std::size_t> wanted{ends[0], ends[1]};
    EXPECT_EQ(moved_rows([&](const SweptRows& rows, const SweepOrder& order) {
                one_spring.sweep(rows, order, with_avx2);
              }),
              wanted);
    const auto vertices = tets.elastic.strain_terms.front().op.vertices_of(4);
    wanted.assign(vertices.begin(), vertices.end());
    EXPECT_EQ(moved_rows([&](const SweptRows& rows, const SweepOrder& order) {
                one_domain.sweep(rows, order, with_avx2);
              }),
              wanted);
  }
}

TEST(PositionKernel, ModuliWithoutARootAreSolvedOneAtATime) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 5);
  MotionModel model =
      make_continuum(make_held_body(mesh, 0.0, false), mesh, Continuum::kTets, StrainLaw::kLinear);
  EXPECT_TRUE(can_sweep_in_lanes(model.elastic.strain_terms.front()));
  Moduli& moduli = model.elastic.strain_terms.front().moduli;
  moduli.lambda_pa = -0.7 * moduli.mu_pa;
  EXPECT_FALSE(can_sweep_in_lanes(model.elastic.strain_terms.front()));
  EXPECT_TRUE(has_same_bits(move_with(model, PositionKernel::kBest, 2, 4),
                            move_with(model, PositionKernel::kSingle, 2, 4)));
}

}  // namespace
}  // namespace palpate::dynamics
