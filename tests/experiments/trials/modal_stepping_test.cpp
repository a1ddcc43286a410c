// How many modes do: real modes on real motions, held against the same elements stepped whole by another
// program; and answers that were broken on purpose.
#include "experiments/trials/modal_stepping.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <numbers>

#include "core/mesh/io/medit.h"
#include "experiments/scene_reader/scene_problem.h"
#include "experiments/text/yaml_value.h"
#include "experiments/trials/motion_trial.h"
#include "reference/door/moving_body.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/scene_text.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using testing::HasSubstr;
using testing::StartsWith;

constexpr double kInfinite = std::numeric_limits<double>::infinity();

FitStepping modes_of(std::size_t modes) {
  return {"modes_" + std::to_string(modes), reference::kExponential, false, nullptr, modes};
}

/// A bar that hangs from its left end and is loaded at once at its right one: it rings, with waves along it.
class ModesOnAMotion : public testing::Test {
 protected:
  ModesOnAMotion() {
    test::SceneText text;
    text.mesh = "{make: bar, vertices: 60, length_m: 0.1}";
    text.material = "{young_modulus_pa: 10000, poisson_ratio: 0.3, density_kg_m3: 1000}";
    text.clamp = "[{half_space: {normal: [1, 0, 0], share: 0.1}, elastic_pa_per_m: 1.0e+6}]";
    text.load =
        "[{force: {half_space: {normal: [-1, 0, 0], share: 0.1}, total_n: [0.05, 0.01, 0]}, profile: "
        "{times_s: [0, 0.01], shares: [0, 1]}}]";
    text.analysis =
        "{dynamic: {integrator: exponential, time_step_s: 0.01, duration_s: 0.25, damping: {mass_per_s: 5}}}";
    text.rest = "model: {reduced: modal, elements: p1, modes: 1}\n";
    const std::filesystem::path file = fixture_.folder().add("scene.yaml", text.yaml());
    const Scene scene = read_scene(file);
    const TetMesh mesh = build_scene_mesh(scene.mesh).mesh;
    task_.mesh = fixture_.folder() / "body.mesh";
    write_medit(task_.mesh, mesh);
    task_.scene = read_yaml(file).json();
    task_.probes_m = spread_probes(mesh.points, kTrialProbes);
    task_.most_error = 0.05;
    task_.time_limit_s = 3000.0;  // of a machine that does other things too
    task_.folder = fixture_.folder() / "trials";
  }

  bool has_whole() const {
    const auto entry = registry_.find("moving_fem.p1");
    return entry && entry->contestant->unavailable().empty();
  }

  /// All contestants, with reduced.modal_replay behind a program that passes its answer on as `change` (lines
  /// of Python on `rows`) makes it.
  Registry broken_by(const std::string& change) const {
    std::vector<Contestant> all = registry_.contestants();
    for (Contestant& one : all) {
      const bool is_it = std::any_of(one.methods.begin(), one.methods.end(), [](const MethodSpec& method) {
        return method.name == "reduced.modal_replay";
      });
      if (!is_it) continue;
      const std::filesystem::path script = fixture_.folder().add(
          "broken.py",
          "import json, subprocess, sys\nimport pathlib\n"
          "code = subprocess.run(['" +
              one.program.string() +
              "'] + sys.argv[1:]).returncode\n"
              "if code: sys.exit(code)\n"
              "request = json.load(open(sys.argv[1]))\n"
              "path = pathlib.Path(sys.argv[1]).parent / request['history_out']\n"
              "answer = json.load(open(path))\nrows = answer['rows']\n"
              "probes = [k for k, name in enumerate(answer['columns']) if name.startswith('probe_')]\n" +
              change + "json.dump(answer, open(path, 'w'))\n");
      one.command = {"/usr/bin/python3", script.string()};
    }
    return Registry(std::move(all));
  }

  test::ExperimentFixture fixture_;
  Registry registry_ = load_registry();
  SteppingTask task_;
  int looked_ = 0;
};

TEST_F(ModesOnAMotion, TheFewestThatHoldAreTakenAndTooFewAreNot) {
  ASSERT_TRUE(has_whole()) << "moving_fem.p1 is not built";
  // In the order of the file, which is not that of their number.
  const auto tries = try_modes(task_, {modes_of(60), modes_of(1), modes_of(30)}, registry_);
  ASSERT_EQ(tries.size(), 3U);
  EXPECT_THAT(tries[1].why_not, StartsWith("leaves "));
  ASSERT_TRUE(tries[1].error.has_value());
  EXPECT_GT(*tries[1].error, 2.0 * task_.most_error);
  EXPECT_LT(*tries[1].error, 1.0);
  ASSERT_EQ(tries[2].why_not, "");
  EXPECT_LE(*tries[2].error, task_.most_error);
  EXPECT_GT(*tries[2].error, 0.0);
  EXPECT_GT(*tries[2].setup_s, 0.0);
  EXPECT_GT(tries[2].memory_bytes, 1'000'000U);
  EXPECT_EQ(tries[2].cost_s.size(), 3U);
  EXPECT_GT(tries[2].cost(), 0.0);
  EXPECT_LT(tries[2].step_s, 0.25 / 150.0);
  EXPECT_THAT(tries[0].why_not, HasSubstr("it has more modes than modes_30, which holds"));
  EXPECT_EQ(choose_stepping(tries), &tries[2]);
}

TEST_F(ModesOnAMotion, ThoseThatTakeMoreMemoryThanThereIsAreNoChoice) {
  ASSERT_TRUE(has_whole()) << "moving_fem.p1 is not built";
  task_.memory_bytes = 1000;
  const SteppingTry tried = try_modes(task_, {modes_of(30)}, registry_).front();
  EXPECT_THAT(tried.why_not, HasSubstr(" bytes, over 1000"));
  EXPECT_GT(tried.memory_bytes, 1'000'000U);
}

TEST_F(ModesOnAMotion, ABrokenAnswerIsNotVerified) {
  ASSERT_TRUE(has_whole()) << "moving_fem.p1 is not built";
  const auto look = [&](const std::string& change) {
    task_.folder = fixture_.folder() / std::to_string(looked_++);
    return try_modes(task_, {modes_of(30)}, broken_by(change)).front();
  };
  ASSERT_EQ(look("").why_not, "");  // what is passed on as it is holds
  const SteppingTry larger = look("for row in rows:\n  for k in probes: row[k] *= 1.2\n");
  EXPECT_THAT(larger.why_not, StartsWith("leaves "));
  EXPECT_NEAR(*larger.error, 0.2, task_.most_error);
  EXPECT_THAT(look("rows[50][probes[7]] = None\n").why_not, HasSubstr("not finite"));
  EXPECT_THAT(look("del rows[40:]\n").why_not, HasSubstr("not finite"));
}

TEST_F(ModesOnAMotion, WithoutTheElementsSteppedWholeNothingIsVerified) {
  std::vector<Contestant> all = registry_.contestants();
  for (Contestant& one : all) {
    if (one.contest == "motion" && one.folder == "fenicsx") one.command = {"/bin/false"};
  }
  const SteppingTry tried = try_modes(task_, {modes_of(5)}, Registry(std::move(all))).front();
  EXPECT_THAT(tried.why_not, StartsWith("its motion was not verified: moving_fem.p1 "));
  EXPECT_FALSE(tried.error.has_value());
  EXPECT_EQ(tried.cost(), kInfinite);
}

TEST(WhyNoModes, NamesWhatTheSceneHas) {
  const test::ExperimentFixture fixture;
  const Registry registry = load_registry();
  const std::vector<FitStepping> steppings{modes_of(5)};
  const auto why = [&](const std::string& dynamic, const std::string& rest = "") {
    test::SceneText text;
    text.mesh = "{make: bar, vertices: 60, length_m: 0.1}";
    text.analysis = dynamic.empty() ? "static" : "{dynamic: {duration_s: 1, " + dynamic + "}}";
    text.rest = rest;
    return why_no_modes(read_scene(fixture.folder().add("scene.yaml", text.yaml())), steppings,
                        {{"elements", "p2"}}, registry);
  };
  const std::string good = "integrator: symplectic_euler, time_step_s: auto";
  const auto whole = registry.find("moving_fem.p2");
  if (whole && whole->contestant->unavailable().empty()) {
    EXPECT_EQ(why(good), "");
    EXPECT_EQ(why(good + ", damping: {stiffness_s: 0.001, mass_per_s: 1}"), "");
  }
  EXPECT_THAT(why(""), HasSubstr("no motion"));
  EXPECT_THAT(why("preset: thesis_table_4_1"), HasSubstr("preset"));
  EXPECT_THAT(why(good, "strain: large\n"), HasSubstr("large strain"));
  EXPECT_THAT(why(good + ", mass_per_vertex_kg: 1"), HasSubstr("mass_per_vertex_kg"));
  EXPECT_THAT(why(good + ", speed_limit_m_s: 1"), HasSubstr("speed_limit_m_s"));
  EXPECT_THAT(why(good + ", damping: {vertex_n_s_per_m: 1}"), HasSubstr("damped"));
  const test::ExperimentFixture other;
  test::SceneText moving;
  moving.mesh = "{make: bar, vertices: 60, length_m: 0.1}";
  moving.analysis = "{dynamic: {duration_s: 1, " + good + "}}";
  const Scene scene = read_scene(other.folder().add("scene.yaml", moving.yaml()));
  EXPECT_THAT(
      why_no_modes(scene, {{"explicit", "symplectic_euler", false, nullptr}}, json::object(), registry),
      HasSubstr("no stepping"));
  EXPECT_THAT(why_no_modes(scene, steppings, json::object(), Registry({})),
              HasSubstr("moving_fem.p2, which their motion is held against, is unavailable"));
}

/// One component that follows `f` at `count` + 1 times from 0 to 1.
template <typename F>
ProbeHistory history_of(std::size_t count, const F& f) {
  ProbeHistory out;
  for (std::size_t k = 0; k <= count; ++k) {
    out.time_s.push_back(static_cast<double>(k) / static_cast<double>(count));
    out.row.push_back({f(out.time_s.back())});
  }
  return out;
}

TEST(DifferenceAtRows, CountsWhatIsNotSeenBetweenTheRows) {
  const auto line = [](double t) { return 2.0 * t; };
  const auto wave = [](double t) { return std::sin(20.0 * std::numbers::pi * t); };
  EXPECT_NEAR(difference_at_rows(history_of(3, line), history_of(40, line)), 0.0, 1e-12);
  EXPECT_NEAR(
      difference_at_rows(history_of(7, [&](double t) { return 1.25 * line(t); }), history_of(40, line)), 0.25,
      1e-12);
  // Ten rows at the zeros of a wave of ten periods: between them nothing is there.
  EXPECT_NEAR(difference_at_rows(history_of(10, wave), history_of(400, wave)), 1.0, 1e-9);
  // Straight pieces of h through a sine of w are off by (w h)^2 / sqrt(120) of its rms at most.
  const double wh = 20.0 * std::numbers::pi / 200.0;
  EXPECT_NEAR(difference_at_rows(history_of(200, wave), history_of(20'000, wave)), wh * wh / std::sqrt(120.0),
              0.02 * wh * wh);
}

TEST(DifferenceAtRows, WhatIsNoNumberOrEndsEarlyIsInfinite) {
  const auto line = [](double t) { return 2.0 * t; };
  ProbeHistory broken = history_of(10, line);
  broken.row[4][0] = std::nan("");
  EXPECT_EQ(difference_at_rows(broken, history_of(10, line)), kInfinite);
  ProbeHistory half = history_of(10, line);
  half.time_s.resize(6);
  half.row.resize(6);
  EXPECT_EQ(difference_at_rows(half, history_of(10, line)), kInfinite);
  EXPECT_EQ(difference_at_rows({}, history_of(10, line)), kInfinite);
  EXPECT_EQ(difference_at_rows(history_of(10, line), history_of(10, [](double) { return 0.0; })), kInfinite);
}

}  // namespace
}  // namespace palpate::experiments
