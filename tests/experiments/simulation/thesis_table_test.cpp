// What Table 4.1 of the thesis does, on a small body: errata D6 to D8.
#include <gtest/gtest.h>

#include "core/dynamics/stability/slow_rates.h"
#include "experiments/scene_reader/scene_problem.h"
#include "experiments/simulation/motion_returns.h"
#include "experiments/simulation/motion_setup.h"
#include "experiments/simulation/simulate_motion.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/scene_text.h"

namespace palpate::experiments {
namespace {

/// The fixture's cube of 0.1 m, its top pressed in by 5 mm and let go.
class ThesisTable41 : public testing::Test {
 protected:
  struct Body {
    Scene placed;
    TetMesh mesh;
    MotionSetup setup;
  };

  Body build(const std::string& dynamic) const {
    test::SceneText text;
    text.load =
        "[{displace: {sphere: {center_m: [0.05, 0.05, 0.1], radius_m: 0.06}, by_m: [0, 0, -0.005]}, profile: "
        "{times_s: [0, 0.1], shares: [0, 1], smooth: true}, until_s: 0.2}]";
    text.analysis = "{dynamic: {preset: thesis_table_4_1, duration_s: 1.2, frames: 0" + dynamic + "}}";
    const Scene scene = read_scene(fixture_.folder().add("scene.yaml", text.yaml()));
    Body body;
    body.mesh = build_scene_mesh(scene.mesh).mesh;
    body.placed = place_scene(scene, body.mesh);
    body.setup = build_motion(body.placed, body.mesh, fixture_.registry(), 1);
    return body;
  }

  static nlohmann::json run(const Body& body, std::vector<MotionReturn>& returns) {
    MotionOutput output({}, body.placed, body.mesh);
    nlohmann::json report = run_motion_setup(body.placed, body.mesh, body.setup, {600.0, nullptr}, output);
    returns = find_returns(body.placed, output.levels());
    return report;
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

}  // namespace
}  // namespace palpate::experiments
