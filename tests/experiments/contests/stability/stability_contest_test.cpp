// The contest stability: plans that are wrong are refused with their line; every ending is a result, and a
// step that is not the predicted one is not accepted.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "core/base/error.h"
#include "experiments/contests/contest.h"
#include "experiments/plan_reader/case_list.h"
#include "experiments/records/record_file.h"
#include "experiments/runner/contest_table.h"
#include "experiments/runner/read_plan.h"
#include "tests/support/experiment_fixture.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

std::filesystem::path add_plan(const test::ExperimentFixture& fixture, const std::string& contestants,
                               const std::string& extremes, const std::string& rest = "") {
  return fixture.folder().add(
      "plan.yaml",
      "schema: palpate/plan/1\nquestion: How long may a step be?\ncontest: stability\ncontestants: " +
          contestants + "\nextremes: " + extremes + "\nmeshes: [{name: cube, file: cube.mesh}]\n" + rest);
}

/// A plan whose error is known. Contestants stand on line 4, extremes on line 5, the rest on line 7.
struct BadPlan {
  const char* name;
  const char* contestants;
  const char* extremes;
  const char* rest;
  int line;
  const char* message;
};

void PrintTo(const BadPlan& plan, std::ostream* out) {
  *out << plan.name;
}

class StabilityPlanErrors : public testing::TestWithParam<BadPlan> {};

TEST_P(StabilityPlanErrors, NamesLineAndReason) {
  const test::ExperimentFixture fixture;
  const auto plan = add_plan(fixture, GetParam().contestants, GetParam().extremes, GetParam().rest);
  const std::string message = fixture.error_of_plan(plan);
  EXPECT_THAT(message, HasSubstr("plan.yaml:" + std::to_string(GetParam().line) + ":"));
  EXPECT_THAT(message, HasSubstr(GetParam().message));
}

constexpr const char* kEuler = "[motion.symplectic_euler]";

const BadPlan kBadPlans[] = {
    {"unknown_integrator", "[motion.symplectic_eular]", "[{name: nominal}]", "", 4,
     "did you mean \"motion.symplectic_euler\"?"},
    {"other_contest", "[tensor_mass]", "[{name: nominal}]", "", 4, "is in the contest deform"},
    {"no_extremes", kEuler, "[]", "", 5, "expected at least one"},
    {"extreme_twice", kEuler, "[{name: a}, {name: a}]", "", 5, "extreme \"a\" twice"},
    {"unknown_mesh", kEuler, "[{name: a, meshes: [cub]}]", "", 5, "did you mean \"cube\"?"},
    {"mesh_twice", kEuler, "[{name: a, meshes: [cube, cube]}]", "", 5, "mesh \"cube\" twice"},
    {"unknown_label", kEuler, "[{name: a, contestants: [motion.plain_float]}]", "", 5, "unknown label"},
    {"no_labels", kEuler, "[{name: a, contestants: []}]", "", 5, "at least one label"},
    {"unknown_option", kEuler, "[{name: a, set: {mass_facto: 2}}]", "", 5, "did you mean"},
    {"negative_mass", kEuler, "[{name: a, sweep: {mass_factor: [1, -1]}}]", "", 5, "mass_factor"},
    {"step_is_no_number", kEuler, "[{name: a, sweep: {step_factor: [.nan]}}]", "", 5, "step_factor"},
    {"no_values", kEuler, "[{name: a, sweep: {mass_factor: []}}]", "", 5, "at least one value"},
    {"set_and_swept", kEuler, "[{name: a, set: {steps: 5}, sweep: {steps: [6]}}]", "", 5, "set already"},
    {"unknown_simplifier", kEuler, "[{name: a, simplify: none}]", "", 5, "unknown simplifier"},
    {"sweep", kEuler, "[{name: a}]", "sweep: {vertices: [100]}", 7, "sweeps in its extremes"},
    {"scenes", kEuler, "[{name: a}]", "scenes: [bar]", 7, "belongs to the contest deform"},
    {"cases", kEuler, "[{name: a}]", "cases: []", 7, "belongs to the contest verify"},
};

INSTANTIATE_TEST_SUITE_P(All, StabilityPlanErrors, testing::ValuesIn(kBadPlans),
                         [](const auto& plan) { return std::string(plan.param.name); });

TEST(StabilityContest, CasesAreExtremesCrossedWithTheirMeshesContestantsAndValues) {
  const test::ExperimentFixture fixture;
  const Plan plan = read_plan(
      add_plan(
          fixture, "[motion.symplectic_euler, {method: motion.plain_float, label: float}]",
          "\n  - {name: a, contestants: [float], set: {steps: 7}, sweep: {strain: [1.0e-3, 1], seed: [1, 2]}}"
          "\n  - {name: b}"),
      fixture.registry());
  const std::vector<Case> cases = build_cases(plan, fixture.registry());
  std::vector<std::string> ids;
  ids.reserve(cases.size());
  for (const Case& c : cases) ids.push_back(c.id);
  EXPECT_THAT(ids, ElementsAre("cube/float/a/strain=1.0e-3/seed=1", "cube/float/a/strain=1.0e-3/seed=2",
                               "cube/float/a/strain=1/seed=1", "cube/float/a/strain=1/seed=2",
                               "cube/motion.symplectic_euler/b", "cube/float/b"));
  EXPECT_EQ(cases[0].options.at("steps"), 7);
  EXPECT_EQ(cases[0].options.at("strain"), 1e-3);
  EXPECT_EQ(cases[1].options.at("seed"), 2);
  EXPECT_EQ(cases[0].sweep.at("extreme"), "a");
  EXPECT_EQ(cases[4].options.at("steps"), 1000);
}

std::map<std::string, json> run(const std::filesystem::path& plan, const std::filesystem::path& out,
                                int exit_code, const std::string& more = "--no-report") {
  const test::ProgramResult result = test::run_program({"run", plan.string(), "--out", out.string(), more});
  EXPECT_EQ(result.exit_code, exit_code) << result.out << result.error;
  std::map<std::string, json> records;
  for (const json& record : read_records(out / "records.jsonl")) records[record.at("case")] = record;
  return records;
}

TEST(StabilityContest, EveryEndingIsAResult) {
  const test::ExperimentFixture fixture;
  const auto plan = add_plan(fixture, kEuler,
                             "\n  - {name: nominal, set: {steps: 200}}"
                             "\n  - {name: beyond, set: {task: run, step_factor: 5}}"
                             "\n  - {name: overflow, set: {task: run, step_factor: 1.0e+250}}");
  const auto records = run(plan, fixture.folder() / "run", 0);
  ASSERT_EQ(records.size(), 3U);
  const std::string who = "cube/motion.symplectic_euler/";
  for (const auto& [id, record] : records) EXPECT_EQ(record.at("outcome"), "accepted") << id;
  EXPECT_NEAR(records.at(who + "nominal").at("judge").at("measured_over_predicted").get<double>(), 1.0, 0.02);
  EXPECT_LE(records.at(who + "nominal").at("judge").at("row_sum_over_measured").get<double>(), 1.0);
  EXPECT_EQ(records.at(who + "beyond").at("judge").at("ending"), "diverged");
  EXPECT_EQ(records.at(who + "overflow").at("judge").at("ending"), "non_finite");
}

TEST(StabilityContest, ARunThatWasGivenUpIsNotAccepted) {
  const test::ExperimentFixture fixture;
  const auto plan = add_plan(fixture, kEuler, "[{name: late, set: {task: run, time_limit_s: 0}}]");
  const auto records = run(plan, fixture.folder() / "run", 1);
  const json& late = records.at("cube/motion.symplectic_euler/late");
  EXPECT_EQ(late.at("outcome"), "rejected");
  EXPECT_EQ(late.at("judge").at("ending"), "too_slow");
  EXPECT_THAT(late.at("message").get<std::string>(), HasSubstr("how it ends is not known"));
}

TEST(StabilityContest, AProcessThatTakesTooLongWasTooSlowAndTheRunGoesOn) {
  const test::ExperimentFixture fixture;
  const auto plan =
      add_plan(fixture, kEuler,
               "\n  - {name: forever, set: {task: run, steps: 1000000000, time_limit_s: 1.0e+9}}"
               "\n  - {name: short, set: {task: run, steps: 10}}",
               "run: {timeout_s: 4}\n");
  const auto records = run(plan, fixture.folder() / "run", 3);
  const json& slow = records.at("cube/motion.symplectic_euler/forever");
  EXPECT_EQ(slow.at("outcome"), "timed_out");
  EXPECT_EQ(slow.at("judge").at("ending"), "too_slow");
  EXPECT_EQ(slow.at("judge").at("valid"), false);
  EXPECT_THAT(slow.at("message").get<std::string>(), HasSubstr("s"));
  EXPECT_EQ(records.at("cube/motion.symplectic_euler/short").at("outcome"), "accepted");
}

TEST(StabilityContest, RunsOnWhatASimplifierLeaves) {
  const test::ExperimentFixture fixture;
  const auto plan =
      add_plan(fixture, kEuler, "[{name: simplified, simplify: cut, set: {task: run, steps: 10}}]",
               "simplify: [{method: test.copy, label: cut}]\n");
  const auto records = run(plan, fixture.folder() / "run", 0);
  const json& record = records.at("cube/motion.symplectic_euler/simplified");
  EXPECT_EQ(record.at("mesh").at("name"), "cube/simplify=cut");
}

TEST(StabilityContest, GoesOnWhereItWasStopped) {
  const test::ExperimentFixture fixture;
  const auto plan = add_plan(
      fixture, kEuler, "[{name: a, set: {task: run, steps: 10}, sweep: {step_factor: [0.1, 0.9, 10]}}]");
  const auto folder = fixture.folder() / "parts";
  test::run_program({"run", plan.string(), "--out", folder.string(), "--no-report", "--case",
                     "cube/motion.symplectic_euler/a/step_factor=0.9"});
  EXPECT_EQ(read_records(folder / "records.jsonl").size(), 1U);
  const auto result =
      test::run_program({"run", plan.string(), "--out", folder.string(), "--no-report", "--resume"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(read_records(folder / "records.jsonl").size(), 3U);
}

}  // namespace
}  // namespace palpate::experiments
