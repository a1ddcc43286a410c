// An engine held against the integrator, step by step, on a body in the hands of a tool.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/dynamics/integrators/integrator.h"
#include "core/dynamics/spring_engine/plain_engine.h"
#include "tests/support/dynamics_cases.h"

namespace palpate::testing_support {

/// Lets go what holds a pressed body (make_pressed_body) and puts it on an elastic support, under gravity
/// that swells and a force, with an elastic pad that goes down on one side; the tool on its top stays. The
/// mesh is a unit cube.
void add_palpation(const TetMesh& mesh, dynamics::MotionModel& model);

/// What an engine reports, and the speeds that the integrator cut.
struct ComparedRun {
  dynamics::PlainReport report;
  std::uint64_t speeds_cut = 0;
};

/// Steps both side by side, 1 ms a step, and holds states and forces of the loads against each other: they
/// differ by less than `tolerance` of their size.
template <typename Engine>
ComparedRun compare_with_integrator(const dynamics::MotionModel& model, const dynamics::PlainOptions& options,
                                    std::uint64_t steps, double tolerance) {
  constexpr double kStep = 1e-3;
  dynamics::IntegratorOptions general;
  general.speed_limit_m_s = options.speed_limit_m_s;
  dynamics::Integrator integrator(model, general);
  dynamics::MotionState expected = start_at_rest(model);
  Engine engine(model, options);
  double error = 0.0;
  double size = 0.0;
  ComparedRun run;
  run.report = engine.step(kStep, steps, [&](std::uint64_t) {
    const std::vector<Vec3> told = integrator.forces().group_forces(expected);
    for (std::size_t g = 0; g < told.size(); ++g) {
      error = std::max(error, length(engine.group_forces()[g] - told[g]));
      size = std::max(size, length(told[g]));
    }
    run.speeds_cut += integrator.step(expected, kStep).speeds_cut;
  });
  EXPECT_GT(size, 1.0);
  EXPECT_LT(error, tolerance * size);
  const dynamics::MotionState got = engine.state();
  EXPECT_EQ(got.time_s, expected.time_s);
  EXPECT_LT(field_distance(got.displacement_m, expected.displacement_m),
            tolerance * field_norm(expected.displacement_m));
  EXPECT_LT(field_distance(got.velocity_m_s, expected.velocity_m_s),
            tolerance * field_norm(expected.velocity_m_s));
  return run;
}

}  // namespace palpate::testing_support
