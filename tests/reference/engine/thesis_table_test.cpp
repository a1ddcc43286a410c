// What Table 4.1 of the thesis does, on a small body: errata D6 to D8.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>

#include "core/dynamics/stability/slow_rates.h"
#include "experiments/contests/engine/motion_returns.h"
#include "experiments/scene_reader/scene_motion.h"
#include "experiments/scene_reader/scene_problem.h"
#include "reference/engine/motion_replay.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/scene_text.h"

namespace palpate::experiments {
namespace {

using testing::HasSubstr;

/// The fixture's cube of 0.1 m, its top pressed in by 5 mm and let go.
class ThesisTable41 : public testing::Test {
 protected:
  struct Body {
    reference::MovingBody moving;
    TetMesh mesh;
    reference::MotionSetup setup;
  };

  static Body build(const Scene& scene, const test::ExperimentFixture& fixture) {
    Body body;
    body.mesh = build_scene_mesh(scene.mesh).mesh;
    body.moving = build_moving_body(place_scene(scene, body.mesh), body.mesh, fixture.registry());
    body.setup = build_motion(body.moving, body.mesh, 1);
    return body;
  }

  Body build(const std::string& dynamic) const {
    test::SceneText text;
    text.load =
        "[{displace: {sphere: {center_m: [0.05, 0.05, 0.1], radius_m: 0.06}, by_m: [0, 0, -0.005]}, profile: "
        "{times_s: [0, 0.1], shares: [0, 1], smooth: true}, until_s: 0.2}]";
    text.analysis = "{dynamic: {preset: thesis_table_4_1, duration_s: 1.2, frames: 0" + dynamic + "}}";
    return build(read_scene(fixture_.folder().add("scene.yaml", text.yaml())), fixture_);
  }

  /// The scene with a model of its own, or none, for 0.03 s.
  Body build_short(const std::string& rest) const {
    test::SceneText text;
    text.load = "[{displace: {half_space: {normal: [0, 0, -1], offset_m: -0.1}, by_m: [0, 0, -0.01]}}]";
    text.analysis = "{dynamic: {preset: thesis_table_4_1, duration_s: 0.03, allow_unstable: true}}";
    text.rest = rest;
    return build(read_scene(fixture_.folder().add("scene.yaml", text.yaml())), fixture_);
  }

  static nlohmann::json run(const Body& body, std::vector<MotionReturn>& returns) {
    reference::MotionOutput output({}, body.moving.motion, body.mesh);
    nlohmann::json report = run_motion_setup(body.moving, body.mesh, body.setup, {600.0, nullptr}, output);
    returns = find_returns(body.moving.motion, read_levels(output.files().history_csv()));
    return report;
  }

  /// The times, and the last two columns.
  static std::vector<MotionLevel> read_levels(const std::string& csv) {
    std::vector<MotionLevel> levels;
    std::istringstream lines(csv);
    std::string line;
    std::getline(lines, line);
    while (std::getline(lines, line)) {
      std::vector<double> cells;
      std::istringstream row(line);
      for (std::string cell; std::getline(row, cell, ',');) cells.push_back(std::stod(cell));
      levels.push_back({cells.front(), cells.at(cells.size() - 2), cells.back()});
    }
    return levels;
  }

  test::ExperimentFixture fixture_;
};

TEST_F(ThesisTable41, TheOrganIsAlmostFrozen) {
  const Body body = build("");
  EXPECT_GT(body.setup.stable.step_s, body.setup.step_s);  // the step is stable, by a little
  EXPECT_LT(body.setup.stable.step_s, 1.5 * body.setup.step_s);
  std::vector<MotionReturn> returns;
  const auto report = run(body, returns);
  ASSERT_EQ(returns.size(), 1U);
  EXPECT_GT(returns[0].error(), 0.5);  // after a second; a soft organ is back after a tenth
  EXPECT_EQ(report.at("speeds_cut"), 0);
  dynamics::MotionModel still = body.setup.phases.back().model;
  const dynamics::SlowRates rates = dynamics::find_slow_rates(still);
  ASSERT_TRUE(rates.converged);
  EXPECT_GT(rates.slowest_decay_s(), 20.0);
}

TEST_F(ThesisTable41, TheDampingSetsTheStepNotTheSprings) {
  Body body = build("");
  dynamics::MotionModel& model = body.setup.phases.back().model;
  const double with = predict_stable_step(model, dynamics::IntegratorKind::kSymplecticEuler).step_s;
  model.spring_damping_n_s_per_m.clear();
  model.environment_damping_n_s_per_m.clear();
  EXPECT_GT(predict_stable_step(model, dynamics::IntegratorKind::kSymplecticEuler).step_s, 50.0 * with);
}

TEST_F(ThesisTable41, TheSpeedLimitHidesThatThePrintedDampingIsUnstable) {
  const Body body = build(", damping: {springs: isotropic}, allow_unstable: true");
  EXPECT_LT(body.setup.stable.step_s, body.setup.step_s);
  std::vector<MotionReturn> returns;
  const auto report = run(body, returns);
  EXPECT_NE(report.at("outcome"), "diverged");
  EXPECT_GT(report.at("speeds_cut").get<std::uint64_t>(), 1000U);
  EXPECT_NEAR(report.at("peak_speed_m_s").get<double>(), report.at("speed_limit_m_s").get<double>(), 1e-9);
}

TEST_F(ThesisTable41, TheThesissPresetIsItsTable) {
  const Body body = build_short("");
  const reference::MotionSetup& setup = body.setup;
  EXPECT_EQ(setup.method, "springs.uniform");
  EXPECT_EQ(setup.step_s, 3e-4);
  EXPECT_EQ(setup.steps, 100U);
  EXPECT_NEAR(setup.integrator.speed_limit_m_s, 20.0 * 0.05, 1e-12);  // a cube of 0.1 m
  const dynamics::MotionModel& model = setup.phases.front().model;
  for (const double mass : model.mass_kg) EXPECT_EQ(mass, 1.0);
  for (const double stiffness : model.elastic.springs.stiffness_n_per_m) EXPECT_EQ(stiffness, 100.0);
  for (const double damping : model.spring_damping_n_s_per_m) EXPECT_EQ(damping, 500.0);
  for (const double damping : model.environment_damping_n_s_per_m) EXPECT_EQ(damping, 800.0);
  EXPECT_EQ(model.spring_damping, dynamics::SpringDamping::kAxial);
  ASSERT_TRUE(model.elastic.volume_force.has_value());
  EXPECT_NEAR(model.elastic.volume_force->stiffness_n_per_m3, 100.0 / (0.05 * 0.05), 1e-6);
  EXPECT_FALSE(model.elastic.springs_are_linear);
}

TEST_F(ThesisTable41, ThePresetTakesSpringsOfTheScenesOwn) {
  const auto model_of = [&](const std::string& rest) {
    const Body body = build_short(rest);
    EXPECT_EQ(body.setup.step_s, 3e-4);
    return body.setup.phases.front().model;
  };
  const std::string springs = "model: {springs: thesis_corrected, row_weight: 100}\n";
  const auto as_identified = model_of(springs).elastic;
  const auto scaled = model_of("model: {springs: thesis_corrected, row_weight: 100, mean_n_per_m: 250}\n");
  const std::vector<double>& k = as_identified.springs.stiffness_n_per_m;
  const std::vector<double>& scaled_k = scaled.elastic.springs.stiffness_n_per_m;
  const double mean = std::accumulate(k.begin(), k.end(), 0.0) / static_cast<double>(k.size());
  EXPECT_GT(std::abs(mean - 250.0), 1.0);
  for (std::size_t s = 0; s < k.size(); ++s) EXPECT_NEAR(scaled_k[s], k[s] * 250.0 / mean, 1e-9);
  EXPECT_GT(*std::max_element(k.begin(), k.end()), 1.5 * mean);  // they are not all alike
  // Masses, damping and the volume force's constant stay the table's.
  for (const double mass : scaled.mass_kg) EXPECT_EQ(mass, 1.0);
  for (const double damping : scaled.spring_damping_n_s_per_m) EXPECT_EQ(damping, 500.0);
  for (const auto* elastic : {&as_identified, &scaled.elastic})
    EXPECT_NEAR(elastic->volume_force->stiffness_n_per_m3, 100.0 / (0.05 * 0.05), 1e-6);
  const auto refusal = [&](const std::string& rest) {
    try {
      model_of(rest);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_THAT(refusal("model: {springs: lloyd, volume: tet}\n"), HasSubstr("sets volume by itself"));
  EXPECT_THAT(refusal("model: {smoothed: blend}\n"), HasSubstr("takes springs alone"));
  EXPECT_THAT(refusal("model: {springs: uniform, stiffness_n_per_m: 0}\n"),
              HasSubstr("stiffness_n_per_m: expected a number, at least 1e-12"));
}

}  // namespace
}  // namespace palpate::experiments
