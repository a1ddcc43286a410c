// Dynamic scenes: what palpate simulate refuses, and says beforehand.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>

#include "core/mesh/io/medit.h"
#include "reference/elastic_models/motion_files.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/motion_command.h"
#include "tests/support/scene_text.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using test::read_csv;
using test::run_program;
using test::SceneText;
using testing::HasSubstr;

class SimulateRefusals : public test::MotionCommand {};

TEST_F(SimulateRefusals, AStepOverTheBoundIsRefusedUnlessItIsAllowed) {
  const std::string fast = "integrator: symplectic_euler, time_step_s: 0.02, duration_s: 10, frames: 0";
  const std::string error = error_of(fast);
  EXPECT_THAT(error,
              HasSubstr("scene.yaml:6: a time step of 0.02 s is over the bound of symplectic_euler at rest"));
  EXPECT_THAT(error, HasSubstr("allow_unstable: true"));
  const json report = simulate(pressed(fast + ", allow_unstable: true"), "out", "1", 1);
  EXPECT_EQ(report.at("outcome"), "diverged");
  EXPECT_LT(report.at("stability_margin").get<double>(), 1.0);
  EXPECT_TRUE(report.at("first_bad_vertex").is_number());
  EXPECT_TRUE(report.at("state_is_finite").get<bool>());
  EXPECT_GT(report.at("energy_end").at("kinetic_j").get<double>(), 0.0);
  // The last state is in all that is written: a vertex that is 1000 sizes of 0.1 m away.
  EXPECT_GT(report.at("end_displacement_m").get<double>(), 50.0);
  EXPECT_EQ(report.at("max_displacement_m"), report.at("end_displacement_m"));
  EXPECT_LT(report.at("steps").get<std::uint64_t>(), report.at("steps_planned").get<std::uint64_t>());
  const auto rows = read_csv(fixture_.folder() / "out" / "history.csv");
  EXPECT_DOUBLE_EQ(std::stod(rows.back()[0]), report.at("simulated_s").get<double>());
  EXPECT_THAT(test::bytes_of(fixture_.folder() / "out" / "history.csv"), testing::Not(HasSubstr("nan")));
}

TEST_F(SimulateRefusals, WhatMakesNoSenseIsRefusedWithItsPlace) {
  const std::string rest = ", duration_s: 1";
  for (const std::string bad : {"0", "-1", ".nan", ".inf"}) {
    EXPECT_THAT(error_of("integrator: symplectic_euler, time_step_s: " + bad + rest),
                HasSubstr("scene.yaml:6"));
    EXPECT_THAT(error_of("integrator: symplectic_euler, time_step_s: auto, duration_s: " + bad),
                HasSubstr("duration_s: expected"));
    EXPECT_THAT(error_of(kGood + ", mass_per_vertex_kg: " + bad), HasSubstr("mass_per_vertex_kg: expected"));
    EXPECT_THAT(error_of(kGood + ", speed_limit_m_s: " + bad), HasSubstr("speed_limit_m_s: expected"));
  }
  EXPECT_THAT(error_of("integrator: verlet, time_step_s: auto" + rest),
              HasSubstr("unknown integrator \"verlet\""));
  EXPECT_THAT(error_of("integrator: velocity_verle, time_step_s: auto" + rest),
              HasSubstr("did you mean \"velocity_verlet\""));
  EXPECT_THAT(error_of("preset: thesis_table_41" + rest), HasSubstr("did you mean \"thesis_table_4_1\""));
  EXPECT_THAT(error_of("preset: thesis_table_4_1, time_step_s: 0.1" + rest),
              HasSubstr("sets time_step_s by itself"));
  EXPECT_THAT(error_of("integrator: implicit_euler, time_step_s: auto" + rest), HasSubstr("has no bound"));
  EXPECT_THAT(error_of("integrator: explicit_euler, time_step_s: auto" + rest),
              HasSubstr("no step of explicit_euler"));
  EXPECT_THAT(error_of("integrator: symplectic_euler, time_step_s: 1.0e-30, duration_s: 1"),
              HasSubstr("at most 1e12 steps"));
  EXPECT_THAT(error_of(kGood + ", damping: {stiffness_s: -1}"), HasSubstr("scene.yaml:6"));
  EXPECT_THAT(error_of("integrator: symplectic_euler, time_step_s: auto, damping: {mass_per_s: .nan}" + rest),
              HasSubstr("mass_per_s: expected"));
}

TEST_F(SimulateRefusals, BadInputThatIsFoundLateLeavesNoFolder) {
  error_of("integrator: symplectic_euler, time_step_s: 0.02, duration_s: 10");
  EXPECT_FALSE(std::filesystem::exists(fixture_.folder() / "out"));
  const auto deep = fixture_.folder() / "deep" / "er" / "out";
  const auto result =
      run_program({"simulate", scene(pressed("integrator: explicit_euler, time_step_s: auto, duration_s: 1")),
                   "-o", deep.string()});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_FALSE(std::filesystem::exists(fixture_.folder() / "deep"));
  std::filesystem::create_directories(deep);  // what was there before stays
  run_program({"simulate", scene(pressed("integrator: explicit_euler, time_step_s: auto, duration_s: 1")),
               "-o", deep.string()});
  EXPECT_TRUE(std::filesystem::exists(deep));
}

TEST_F(SimulateRefusals, AToolThatLeavesTheOrganIsRefused) {
  SceneText text = pressed(kGood);
  text.load =
      "[{displace: {sphere: {center_m: [0.05, 0.05, 0.15], radius_m: 0.01}, by_m: [0, 0, -0.01]}, profile: "
      "{times_s: [0, 0.05], shares: [0, 1]}}]";
  EXPECT_THAT(error_of(text), HasSubstr("scene.yaml"));
  text.load = "[{displace: {half_space: {normal: [0, 0, -1], offset_m: -30}, by_m: [0, 0, -0.01]}}]";
  EXPECT_THAT(error_of(text), HasSubstr("scene.yaml"));
}

TEST_F(SimulateRefusals, AnEngineThatCannotIsRefusedWithWhat) {
  EXPECT_THAT(error_of(kGood + ", engine: plane"),
              HasSubstr("unknown engine \"plane\"; did you mean \"plain\""));
  EXPECT_THAT(error_of(kGood + ", precision: half"), HasSubstr("single or double"));
  EXPECT_THAT(error_of(kGood + ", engine: general, precision: single"),
              HasSubstr("asks for the general one"));
  EXPECT_THAT(error_of("engine: plain, integrator: velocity_verlet, time_step_s: auto, duration_s: 0.1"),
              HasSubstr("scene.yaml:6: engine: the plain engine takes springs"));
  SceneText text = pressed(kGood + ", engine: plain");
  text.rest = "strain: large\nmodel: {springs: van_gelder, volume: node_average}\n";
  text.material = "{young_modulus_pa: 10000, poisson_ratio: 0.4, density_kg_m3: 1000}";
  EXPECT_THAT(error_of(text), HasSubstr("this body has strain energies"));
  text.rest = "model: {springs: van_gelder}\n";
  EXPECT_THAT(error_of(text), HasSubstr("this body has linearised springs"));
  text = pressed("preset: thesis_table_4_1, duration_s: 0.03, allow_unstable: true");
  text.rest = "";
  const json preset = simulate(text, "preset");
  EXPECT_EQ(preset.at("engine"), "general");
  EXPECT_EQ(preset.at("why_general"), "a volume force");
}

TEST_F(SimulateRefusals, AToolThatIsOffTheOrganOrLeavesItIsRefused) {
  SceneText beside = pressed(kGood);
  beside.load = "[{displace: {sphere: {center_m: [0.05, 0.05, 0.3], radius_m: 0.01}, by_m: [0, 0, -0.01]}}]";
  EXPECT_THAT(error_of(beside), HasSubstr("scene.yaml:5"));
  SceneText leaves = pressed(kGood);
  leaves.load =
      "[{displace: {half_space: {normal: [0, 0, -1], offset_m: -0.1}, by_m: [0, 0, 0.01]}, profile: "
      "{times_s: [0, 0.05], shares: [0, -50]}}]";
  EXPECT_THAT(error_of(leaves),
              AllOf(HasSubstr("scene.yaml:5: the tool leaves the organ: it is moved by 0.5 m, "
                              "and the organ is "),
                    HasSubstr(" m long")));
}

TEST_F(SimulateRefusals, LoadsWithTimesAreChecked) {
  SceneText text = pressed(kGood);
  text.load = "[{gravity_m_s2: [0, 0, -1], from_s: 0.05, until_s: 0.01}]";
  EXPECT_THAT(error_of(text), HasSubstr("until_s: expected a time after from_s"));
  text.load = "[{gravity_m_s2: [0, 0, -1], profile: {times_s: [1, 0], shares: [0, 1]}}]";
  EXPECT_THAT(error_of(text), HasSubstr("times that increase"));
  text.load = "[{gravity_m_s2: [0, 0, -1], until_s: 0.1}]";
  text.analysis = "static";
  EXPECT_THAT(error_of(text), HasSubstr("belong to a dynamic analysis"));
  text = pressed(kGood);
  text.rest = "model: {springs: van_gelder, tolerance: 1.0e-3}\n";
  EXPECT_THAT(error_of(text), HasSubstr("tolerance belongs to a static analysis"));
  text = pressed("integrator: prefactored, time_step_s: 0.001, duration_s: 0.01");
  text.rest = "model: {springs: van_gelder, volume: thesis}\n";
  EXPECT_THAT(error_of(text), HasSubstr("a model that has an energy for prefactored"));
}

TEST_F(SimulateRefusals, WhatAMotionWouldPassOverInSilence) {
  const auto refused = [&](const SceneText& text, const std::string& part) {
    EXPECT_THAT(error_of(text), HasSubstr(part));
    const auto checked = run_program({"check", scene(text)});
    EXPECT_EQ(checked.exit_code, 2);
    EXPECT_THAT(checked.error, HasSubstr(part));
  };
  refused(pressed("integrator: bdf2, time_step_s: 0.2, duration_s: 0.1"),
          "scene.yaml:6: time_step_s: expected at most the duration of 0.1 s, found 0.2 s");
  refused(
      pressed(kGood + ", probes_m: [[0, 0, 0.05], [0, 0, 1]]"),
      "scene.yaml:6: probes_m: expected points of the body, found one whose nearest vertex is 900 mm away");
  const auto noted = [&](const SceneText& text, const std::string& part) {
    const auto checked = run_program({"check", scene(text)});
    EXPECT_EQ(checked.exit_code, 0) << checked.error;
    EXPECT_THAT(checked.error, HasSubstr(part));
  };
  noted(pressed(kGood + ", solver: {iterations: 5}"),
        "scene.yaml:6: solver has no use: the integrator iterates nothing");
  noted(pressed("integrator: bdf2, time_step_s: 0.001, duration_s: 0.01, solver: {substeps: 2}"),
        "scene.yaml:6: substeps have no use but with xpbd and vbd");
  SceneText late = pressed(kGood);
  late.load =
      "[{displace: {half_space: {normal: [0, 0, -1], offset_m: -0.1}, by_m: [0, 0, -0.01]}, from_s: 100}, "
      "{gravity_m_s2: [0, 0, -1]}]";
  noted(late, "scene.yaml:5: this load begins at 100 s, and the motion ends at 0.1 s");
  late.load =
      "[{displace: {half_space: {normal: [0, 0, -1], offset_m: -0.1}, by_m: [0, 0, -0.01]}, profile: "
      "{times_s: "
      "[0, 2, 3], shares: [0, 0, 1]}}, {gravity_m_s2: [0, 0, -1]}]";
  noted(late, "scene.yaml:5: this load's profile is 0 until the motion ends at 0.1 s");
  noted(pressed("integrator: symplectic_euler, time_step_s: 1.0e-5, duration_s: 0.1, safety: 0.5"),
        "scene.yaml:6: safety has no use: time_step_s is given");
  SceneText smoothed = pressed(kGood.substr(0, kGood.find(", damping")) +
                               ", damping: {spring_n_s_per_m: 100, springs: isotropic}");
  smoothed.rest = "strain: large\nmodel: {smoothed: edge_node}\n";
  noted(smoothed, "scene.yaml:6: damping: spring_n_s_per_m has no use: smoothed.edge_node has no springs");
  noted(smoothed, "scene.yaml:6: damping: springs has no use: smoothed.edge_node has no springs");
  smoothed.rest = "strain: large\nmodel: {springs: van_gelder}\n";
  for (const SceneText& used : {smoothed, pressed(kGood + ", safety: 0.5")}) {
    const auto checked = run_program({"check", scene(used)});
    EXPECT_EQ(checked.exit_code, 0) << checked.error;
    EXPECT_EQ(checked.error, "");
  }
}

TEST_F(SimulateRefusals, ABodyOfNoOrgansSizeIsNotedByCheckToo) {
  SceneText text;
  for (const char* mesh :
       {"{make: cube, vertices: 100, length_m: 1.0e-9}", "{file: cube.mesh, length_m: 1.0e-9}"}) {
    text.mesh = mesh;
    const auto checked = run_program({"check", scene(text)});
    EXPECT_EQ(checked.exit_code, 0) << checked.error;
    EXPECT_THAT(checked.error, HasSubstr("with length_m: 1e-09 the body is 1e-09 m long: is that its size?"))
        << mesh;
    EXPECT_EQ(std::count(checked.error.begin(), checked.error.end(), '\n'), 1) << checked.error;
  }
}

TEST_F(SimulateRefusals, FramesThatWouldFillTheDiskAreRefusedBeforeTheRun) {
  SceneText text =
      pressed("integrator: symplectic_euler, time_step_s: 1.0e-6, duration_s: 10, frames: 10000000");
  const std::string error = error_of(text);
  EXPECT_THAT(error,
              HasSubstr("GB, more than 2 GB: ask for fewer frames, or allow more with --max-output-gb"));
  EXPECT_FALSE(std::filesystem::exists(fixture_.folder() / "out"));
  const auto result = run_program(
      {"simulate", scene(text), "-o", (fixture_.folder() / "out").string(), "--max-output-gb", "1e8"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.error, HasSubstr(" left"));
}

TEST_F(SimulateRefusals, TheEstimateOfTheOutputIsFromAboveAndNotWild) {
  const TetMesh mesh = read_medit(fixture_.folder() / "cube.mesh").mesh;
  const json report = simulate(pressed(kGood + ", frames: 4"), "out");
  double bytes = 0.0;
  for (const json& file : report.at("files"))
    bytes += static_cast<double>(std::filesystem::file_size(file.get<std::string>()));
  const double estimate =
      reference::estimate_output_bytes(mesh, 6, report.at("steps").get<std::uint64_t>(), 13);
  EXPECT_GT(estimate, bytes);
  EXPECT_LT(estimate, 10.0 * bytes);
}

TEST_F(SimulateRefusals, AFreeBodyFallsAndIsChecked) {
  SceneText text = pressed("integrator: velocity_verlet, time_step_s: 1.0e-3, duration_s: 0.1, frames: 0");
  text.clamp = "[]";
  text.load = "[{gravity_m_s2: [0, 0, -9.81]}]";
  const auto checked = run_program({"check", scene(text)});
  EXPECT_EQ(checked.exit_code, 0) << checked.error;
  EXPECT_THAT(checked.out, HasSubstr("good, a dynamic scene of 125 vertices"));
  const json report = simulate(text, "out");
  EXPECT_NEAR(report.at("end_displacement_m").get<double>(), 0.5 * 9.81 * 0.01, 1e-12);
  EXPECT_NEAR(report.at("peak_speed_m_s").get<double>(), 0.981, 1e-12);
}

}  // namespace
}  // namespace palpate::experiments
