// Dynamic scenes: what palpate simulate leaves of them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>

#include "experiments/files/places.h"
#include "experiments/processes/process.h"
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

class SimulateMotion : public test::MotionCommand {};

TEST_F(SimulateMotion, APressedBlockIsLetGoAndLeavesFramesAndHistory) {
  const json report = simulate(
      pressed(
          "integrator: symplectic_euler, time_step_s: auto, duration_s: 0.6, damping: {stiffness_s: 0.001, "
          "mass_per_s: 30}, frames: 4, probes_m: [[0.05, 0.05, 0.1]]"),
      "out");
  EXPECT_EQ(report.at("outcome"), "completed");
  EXPECT_EQ(report.at("stable_by"), "eigenvalues");
  EXPECT_GT(report.at("stability_margin").get<double>(), 1.0 / 0.9 - 1e-9);
  EXPECT_NEAR(report.at("simulated_s").get<double>(), 0.6, 1e-9);
  EXPECT_NEAR(report.at("max_displacement_m").get<double>(), 0.01, 1e-4);
  // Let go at 0.06 s, each mode has lost at least exp(-15 x 0.54) of its size, a hundredth leaves room for
  // all.
  EXPECT_LT(report.at("end_displacement_m").get<double>(), 1e-4);
  EXPECT_EQ(report.at("inverted_tets_most"), 0);
  const auto folder = fixture_.folder() / "out";
  EXPECT_EQ(json::parse(test::bytes_of(folder / "summary.json")), report);
  EXPECT_THAT(test::bytes_of(folder / "frames.pvd"), HasSubstr("file=\"frame_00004.vtu\""));
  EXPECT_TRUE(std::filesystem::exists(folder / "frame_00004.vtu"));

  const auto rows = read_csv(folder / "history.csv");
  ASSERT_EQ(rows.front().size(), 16U);
  EXPECT_EQ(rows.front()[10], "tool_1_fz_n");
  EXPECT_EQ(rows.front()[13], "probe_1_uz_m");
  EXPECT_EQ(rows.front()[14], "largest_displacement_m");
  EXPECT_NEAR(std::stod(rows.back()[14]), report.at("end_displacement_m").get<double>(), 1e-15);
  EXPECT_LT(std::stod(rows.back()[15]), std::stod(rows.back()[14]));
  double deepest = 0.0;
  double strongest = 0.0;
  for (std::size_t k = 1; k < rows.size(); ++k) {
    ASSERT_EQ(rows[k].size(), rows.front().size());
    const double time = std::stod(rows[k][0]);
    deepest = std::min(deepest, std::stod(rows[k][13]));
    strongest = std::min(strongest, std::stod(rows[k][10]));
    const bool has_let_go = time > 0.065;  // 0.06 s to the nearest step
    EXPECT_EQ(has_let_go && std::stod(rows[k][10]) != 0.0, false) << time;
  }
  EXPECT_DOUBLE_EQ(deepest, -0.01);  // the top's centre follows the tool
  // E A / l times the depth is 10 N of a bar; held at both ends, and moved fast, it is more.
  EXPECT_LT(strongest, -5.0);
  EXPECT_GT(strongest, -100.0);
}

TEST_F(SimulateMotion, TheSameHashOnOneThreadAndTwoAndInEachRun) {
  const json first = simulate(pressed(kGood), "one");
  EXPECT_EQ(simulate(pressed(kGood), "again").at("state_hash"), first.at("state_hash"));
  EXPECT_EQ(simulate(pressed(kGood), "two", "2").at("state_hash"), first.at("state_hash"));
}

TEST_F(SimulateMotion, EveryIntegratorRuns) {
  for (const dynamics::IntegratorKind kind : dynamics::kIntegrators) {
    const std::string name = dynamics::integrator_name(kind);
    // Positions stop short of a body whose springs turn, so they are asked for so many sweeps.
    const bool is_swept = kind == dynamics::IntegratorKind::kXpbd;
    const std::string solver = is_swept ? "solver: {iterations: 5, tolerance: 0}, " : "";
    const json report = simulate(pressed(solver + "integrator: " + name +
                                         ", time_step_s: 2.0e-4, duration_s: 0.02, frames: 0, damping: "
                                         "{stiffness_s: 0.001, mass_per_s: 1}"),
                                 name);
    EXPECT_EQ(report.at("outcome"), "completed") << name;
    EXPECT_EQ(report.at("integrator"), name);
    EXPECT_EQ(report.at("steps"), 100) << name;
    EXPECT_EQ(report.at("residual_worst").is_number(), kind >= dynamics::IntegratorKind::kPrefactored)
        << name;
    EXPECT_FALSE(std::filesystem::exists(fixture_.folder() / name / "frames.pvd"));
  }
}

TEST_F(SimulateMotion, StepsWithoutASolutionAreSaidAndNotAccepted) {
  // Damping that is so strong against the springs that a thousand iterations do not move the body enough.
  const std::string slow =
      "integrator: prefactored, time_step_s: 0.02, duration_s: 0.2, frames: 0, damping: "
      "{spring_n_s_per_m: 1.0e+6}";
  const json report = simulate(pressed(slow), "out", "1", 1);
  EXPECT_EQ(report.at("outcome"), "unsolved");
  EXPECT_GT(report.at("steps_unsolved").get<int>(), 0);
  EXPECT_EQ(read_csv(fixture_.folder() / "out" / "history.csv").size(), 12U);
}

/// A motion that no test waits for.
const std::string kEndless =
    "integrator: symplectic_euler, time_step_s: 1.0e-4, duration_s: 1.0e+6, frames: 1000000, samples: "
    "1000000";

TEST_F(SimulateMotion, AfterTheTimeOutWhatWasComputedIsThere) {
  for (const std::string engine : {"plain", "general"}) {
    const auto out = fixture_.folder() / engine;
    const auto result = run_program({"simulate", scene(pressed(kEndless + ", engine: " + engine)), "-o",
                                     out.string(), "--timeout", "0.3", "--max-output-gb", "1e6"});
    EXPECT_EQ(result.exit_code, 3);
    EXPECT_THAT(result.error, HasSubstr("what was computed is written; --timeout allows more"));
    const json summary = json::parse(test::bytes_of(out / "summary.json"));
    EXPECT_EQ(summary.at("outcome"), "timed_out");
    EXPECT_LT(summary.at("steps").get<double>(), summary.at("steps_planned").get<double>());
    const auto rows = read_csv(out / "history.csv");
    EXPECT_DOUBLE_EQ(std::stod(rows.back()[0]), summary.at("simulated_s").get<double>());
    EXPECT_THAT(test::bytes_of(out / "frames.pvd"), HasSubstr("frame_00000.vtu"));
  }
}

TEST_F(SimulateMotion, CtrlCLeavesWhatWasComputed) {
  const auto out = fixture_.folder() / "out";
  const std::string program = program_folder() + "/palpate";
  const std::string file = scene(pressed(kEndless));
  ProcessSpec spec;
  spec.standard_error = fixture_.folder() / "error";
  // It is interrupted when it has begun to write, however long that takes.
  spec.arguments = {"/bin/sh",
                    "-c",
                    "\"$0\" simulate \"$1\" -o \"$2\" --max-output-gb 1e6 & p=$!; "
                    "while [ ! -e \"$2/frame_00000.vtu\" ] && kill -0 $p; do sleep 0.02; done; "
                    "kill -INT $p; wait $p",
                    program,
                    file,
                    out.string()};
  const ProcessResult result = run_process(spec);
  EXPECT_EQ(result.exit_code, 130) << test::bytes_of(spec.standard_error);
  EXPECT_THAT(test::bytes_of(spec.standard_error), HasSubstr("interrupted: "));
  const json summary = json::parse(test::bytes_of(out / "summary.json"));
  EXPECT_EQ(summary.at("outcome"), "interrupted");
  const auto rows = read_csv(out / "history.csv");
  EXPECT_DOUBLE_EQ(std::stod(rows.back()[0]), summary.at("simulated_s").get<double>());
}

TEST_F(SimulateMotion, FramesOfAnEarlierRunAreGone) {
  const auto out = fixture_.folder() / "out";
  simulate(pressed(kGood + ", frames: 20"), "out");
  EXPECT_TRUE(std::filesystem::exists(out / "frame_00015.vtu"));
  fixture_.folder().add("out/frame_12.vtu", "mine");
  fixture_.folder().add("out/notes.txt", "mine");
  simulate(pressed(kGood + ", frames: 2"), "out");
  EXPECT_FALSE(std::filesystem::exists(out / "frame_00015.vtu"));
  EXPECT_TRUE(std::filesystem::exists(out / "frame_00002.vtu"));
  EXPECT_TRUE(std::filesystem::exists(out / "frame_12.vtu"));  // not one of ours
  EXPECT_TRUE(std::filesystem::exists(out / "notes.txt"));
  simulate(pressed(kGood + ", frames: 0"), "out");
  EXPECT_FALSE(std::filesystem::exists(out / "frames.pvd"));
}

TEST_F(SimulateMotion, SinglePrecisionSaysWhatRoundingAdds) {
  const std::string still =
      "integrator: symplectic_euler, time_step_s: 1.0e-5, duration_s: 0.2, frames: 0, "
      "precision: single";
  SceneText text = pressed(still);
  text.load = "[{gravity_m_s2: [0, 0, -1.0e-4]}]";  // hardly a motion
  const auto result =
      run_program({"simulate", scene(text), "-o", (fixture_.folder() / "out").string(), "--json"});
  const json report = json::parse(result.out);
  EXPECT_GT(report.at("rounding_gain_over_kinetic").get<double>(), 0.01);
  EXPECT_THAT(result.error, HasSubstr("single precision: rounding of positions adds about"));
  const json loud = simulate(pressed(still), "loud");
  EXPECT_LT(loud.at("rounding_gain_j").get<double>(),
            report.at("rounding_gain_j").get<double>());  // more of it is held
  EXPECT_LT(loud.at("rounding_gain_over_kinetic").get<double>(), 1e-3);
  EXPECT_TRUE(simulate(pressed(kGood), "double").at("rounding_gain_j").is_null());
}

TEST_F(SimulateMotion, ThePlainEngineStepsWhatItCanAndGivesTheSameMotion) {
  const json plain = simulate(pressed(kGood), "plain");
  EXPECT_EQ(plain.at("engine"), "plain");
  EXPECT_EQ(plain.at("precision"), "double");
  EXPECT_TRUE(plain.at("why_general").is_null());
  const json general = simulate(pressed(kGood + ", engine: general"), "general");
  EXPECT_EQ(general.at("engine"), "general");
  EXPECT_NE(general.at("state_hash"), plain.at("state_hash"));
  for (const char* key : {"outcome", "steps", "time_step_s", "inverted_tets_most", "speeds_cut"})
    EXPECT_EQ(general.at(key), plain.at(key)) << key;
  for (const char* key : {"max_displacement_m", "end_displacement_m", "peak_speed_m_s"})
    EXPECT_NEAR(general.at(key).get<double>(), plain.at(key).get<double>(), 1e-12) << key;
  const auto one = read_csv(fixture_.folder() / "plain" / "history.csv");
  const auto other = read_csv(fixture_.folder() / "general" / "history.csv");
  ASSERT_EQ(one.size(), other.size());
  for (std::size_t k = 1; k < one.size(); ++k)
    EXPECT_NEAR(std::stod(one[k][10]), std::stod(other[k][10]), 1e-8) << one[k][0];
  const json single = simulate(pressed(kGood + ", precision: single"), "single");
  EXPECT_EQ(single.at("precision"), "single");
  EXPECT_NEAR(single.at("max_displacement_m").get<double>(), 0.01, 1e-4);
}

TEST_F(SimulateMotion, TheTetEngineStepsEnergiesOfStrainAndGivesTheSameMotion) {
  SceneText text = pressed(kGood);
  text.rest = "strain: large\nmodel: {smoothed: edge_node}\n";
  const json fast = simulate(text, "tets");
  EXPECT_EQ(fast.at("engine"), "tets");
  EXPECT_TRUE(fast.at("why_general").is_null());
  text.analysis = "{dynamic: {" + kGood + ", engine: general}}";
  const json general = simulate(text, "general");
  EXPECT_EQ(general.at("engine"), "general");
  EXPECT_NE(general.at("state_hash"), fast.at("state_hash"));
  for (const char* key : {"outcome", "steps", "time_step_s", "inverted_tets_most", "speeds_cut"})
    EXPECT_EQ(general.at(key), fast.at(key)) << key;
  for (const char* key : {"max_displacement_m", "end_displacement_m", "peak_speed_m_s"})
    EXPECT_NEAR(general.at(key).get<double>(), fast.at(key).get<double>(), 1e-12) << key;
  text.analysis = "{dynamic: {" + kGood + ", engine: tets, precision: single}}";
  const json single = simulate(text, "single", "2");
  EXPECT_EQ(single.at("precision"), "single");
  EXPECT_TRUE(single.at("rounding_gain_j").is_null());
  EXPECT_NEAR(single.at("max_displacement_m").get<double>(), fast.at("max_displacement_m").get<double>(),
              1e-6);
  text.analysis = "{dynamic: {" + kGood + ", engine: plain}}";
  EXPECT_THAT(error_of(text), HasSubstr("this body has strain energies"));
  EXPECT_THAT(error_of(kGood + ", engine: tets"), HasSubstr("this body has springs"));
}

}  // namespace
}  // namespace palpate::experiments
