// palpate simulate and check on scenes whose model is {reduced: modal}.
#include <gmock/gmock.h>

#include <cmath>

#include "tests/support/motion_command.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using test::read_csv;
using test::run_program;
using test::SceneText;
using testing::HasSubstr;

class SimulateModes : public test::MotionCommand {
 protected:
  inline static const std::string kExact =
      "integrator: exponential, time_step_s: 1.0e-3, duration_s: 0.1, damping: {stiffness_s: 0.001}";

  /// The cube, pressed through a pad, its model of modes.
  static SceneText modal(const std::string& dynamic, const std::string& model = "modes: 12") {
    SceneText text = pressed(dynamic);
    text.clamp = "[{half_space: {normal: [0, 0, 1], offset_m: 0}, elastic_pa_per_m: 1.0e+6}]";
    text.load =
        "[{force: {half_space: {normal: [0, 0, -1], offset_m: -0.1}, total_n: [0, 0, -1]}, profile: "
        "{times_s: [0, 0.05], shares: [0, 1], smooth: true}}]";
    text.rest = "model: {reduced: modal, " + model + "}\n";
    return text;
  }
};

/// Under a load that stays the body comes to rest where the same elements are at rest.
TEST_F(SimulateModes, ComeToRestWhereTheElementsDo) {
  const json report = simulate(modal("integrator: exponential, time_step_s: 4.0e-3, duration_s: 4, damping: "
                                     "{mass_per_s: 60}, frames: 3, probes_m: [[0, 0, 0.1]]"),
                               "out");
  EXPECT_EQ(report.at("outcome"), "completed");
  EXPECT_EQ(report.at("engine"), "modes");
  EXPECT_EQ(report.at("steps"), 1000);
  EXPECT_EQ(report.at("holdings"), 1);
  EXPECT_NEAR(report.at("simulated_s").get<double>(), 4.0, 1e-12);
  const auto folder = fixture_.folder() / "out";
  EXPECT_EQ(json::parse(test::bytes_of(folder / "summary.json")), report);
  EXPECT_THAT(test::bytes_of(folder / "frames.pvd"), HasSubstr("file=\"frame_00003.vtu\""));
  const auto rows = read_csv(folder / "history.csv");
  EXPECT_EQ(rows.front()[5], "volume_m3");
  EXPECT_NEAR(std::stod(rows[1][5]), 1e-3, 1e-12);

  SceneText still = modal("");
  still.analysis = "static";
  still.load = "[{force: {half_space: {normal: [0, 0, -1], offset_m: -0.1}, total_n: [0, 0, -1]}}]";
  const auto rest =
      run_program({"simulate", scene(still), "-o", (fixture_.folder() / "rest").string(), "--json"});
  ASSERT_EQ(rest.exit_code, 0) << rest.error;
  const double there = json::parse(rest.out).at("max_displacement_m").get<double>();
  EXPECT_GT(there, 1e-4);
  // What is missing falls as exp(-c t): the slowest mode, damped beyond its oscillation, has left 2e-9 of it
  // by 2 s, and so its square by 4 s.
  EXPECT_NEAR(report.at("end_displacement_m").get<double>(), there, 1e-9 * there);
}

TEST_F(SimulateModes, TheSameStateEachTime) {
  const json first = simulate(modal(kExact), "one");
  EXPECT_EQ(simulate(modal(kExact), "again").at("state_hash"), first.at("state_hash"));
  EXPECT_EQ(simulate(modal(kExact), "two", "2").at("state_hash"), first.at("state_hash"));
}

TEST_F(SimulateModes, AfterTheTimeOutWhatWasComputedIsThere) {
  SceneText text =
      modal("integrator: exponential, time_step_s: 1.0e-5, duration_s: 900, frames: 100000, samples: 100000");
  const auto result = run_program({"simulate", scene(text), "-o", (fixture_.folder() / "out").string(),
                                   "--timeout", "2", "--max-output-gb", "1e6"});
  EXPECT_EQ(result.exit_code, 3) << result.error;
  EXPECT_THAT(result.error, HasSubstr("90000000 steps of 1e-05 s"));
  EXPECT_THAT(result.error, HasSubstr("what was computed is written"));
  const json summary = json::parse(test::bytes_of(fixture_.folder() / "out" / "summary.json"));
  EXPECT_EQ(summary.at("outcome"), "timed_out");
  EXPECT_LT(summary.at("steps").get<double>(), summary.at("steps_planned").get<double>());
  const auto rows = read_csv(fixture_.folder() / "out" / "history.csv");
  EXPECT_DOUBLE_EQ(std::stod(rows.back()[0]), summary.at("simulated_s").get<double>());
}

TEST_F(SimulateModes, WhatTheyCannotDoIsRefusedWithItsPlace) {
  const auto refused = [&](const std::string& dynamic, const std::string& reason) {
    EXPECT_THAT(error_of(modal(dynamic)), AllOf(HasSubstr("scene.yaml:6: reduced.modal"), HasSubstr(reason)))
        << dynamic;
  };
  const std::string rest = ", duration_s: 0.1";
  refused("integrator: trapezoidal, time_step_s: 1.0e-3" + rest, "integrator: exponential");
  refused("integrator: exponential, time_step_s: auto" + rest, "a number of seconds");
  refused(kExact + ", engine: plain", "engine: plain");
  refused(kExact + ", precision: single", "precision: single");
  refused(kExact + ", mass_per_vertex_kg: 1", "mass_per_vertex_kg");
  refused(kExact + ", speed_limit_m_s: 1", "speed_limit_m_s");
  refused("integrator: exponential, time_step_s: 1.0e-3, duration_s: 0.1, damping: {vertex_n_s_per_m: 1}",
          "damping of springs or vertices");
  SceneText large = modal(kExact);
  large.rest += "strain: large\n";
  EXPECT_THAT(error_of(large), HasSubstr("modes are linear, found strain: large"));
  EXPECT_THAT(error_of(modal(kExact, "modes: 0")), HasSubstr("modes"));
  EXPECT_THAT(error_of(modal(kExact, "modes: 1000, elements: p1")), HasSubstr("modes: expected from 1 to"));
  EXPECT_THAT(error_of(modal(kExact, "frozen: f.json")), HasSubstr("frozen"));
  EXPECT_THAT(error_of(modal(kExact, "modes: 3, step_cost: true")),
              HasSubstr("belongs to a static analysis"));
  SceneText springs = modal(kExact);
  springs.rest = "model: {springs: van_gelder}\n";
  EXPECT_THAT(error_of(springs), HasSubstr("integrator: expected one that steps springs.van_gelder"));
  // A body that nothing holds once its pad is gone.
  SceneText loose = modal(kExact);
  loose.clamp = "[]";
  loose.load =
      "[{displace: {half_space: {normal: [0, 0, -1], offset_m: -0.1}, by_m: [0, 0, -0.001], "
      "elastic_pa_per_m: 1.0e+6}, until_s: 0.05}]";
  EXPECT_THAT(error_of(loose), HasSubstr("left free from 0.05 s"));
}

TEST_F(SimulateModes, CheckLooksAtThemWithoutFindingThem) {
  const auto good = run_program({"check", scene(modal(kExact))});
  EXPECT_EQ(good.exit_code, 0) << good.error;
  EXPECT_THAT(good.out, HasSubstr("good, a dynamic scene"));
  const auto bad = run_program({"check", scene(modal("integrator: bdf2, time_step_s: 0.01, duration_s: 1"))});
  EXPECT_EQ(bad.exit_code, 2);
  EXPECT_THAT(bad.error, HasSubstr("the exact steps of modes"));
}

}  // namespace
}  // namespace palpate::experiments
