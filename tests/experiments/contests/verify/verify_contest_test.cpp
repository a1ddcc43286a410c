// The contest verify: plans that are wrong are refused with their line; right answers pass, wrong ones don't.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "core/base/error.h"
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

std::filesystem::path add_verify_plan(const test::ExperimentFixture& fixture, const std::string& contestants,
                                      const std::string& cases, const std::string& rest = "") {
  return fixture.folder().add(
      "plan.yaml", "schema: palpate/plan/1\nquestion: Is it right?\ncontest: verify\ncontestants: " +
                       contestants + "\ncases: " + cases + "\n" + rest);
}

/// A plan whose error is known. Contestants stand on line 4, cases on line 5, the rest on line 6.
struct BadVerifyPlan {
  const char* name;
  const char* contestants;
  const char* cases;
  const char* rest;
  int line;
  const char* message;
};

void PrintTo(const BadVerifyPlan& plan, std::ostream* out) {
  *out << plan.name;
}

class VerifyPlanErrors : public testing::TestWithParam<BadVerifyPlan> {};

TEST_P(VerifyPlanErrors, NamesLineAndReason) {
  const test::ExperimentFixture fixture;
  const auto plan = add_verify_plan(fixture, GetParam().contestants, GetParam().cases, GetParam().rest);
  const std::string message = fixture.error_of_plan(plan);
  EXPECT_THAT(message, HasSubstr("plan.yaml:" + std::to_string(GetParam().line) + ":"));
  EXPECT_THAT(message, HasSubstr(GetParam().message));
}

constexpr const char* kGoodCase =
    "[{case: patch_test, cells: [2], expect: [{contestants: [tensor_mass], solution_l2: {max: 1}}]}]";

const BadVerifyPlan kBadVerifyPlans[] = {
    {"unknown_case", "[tensor_mass]",
     "[{case: patch_tets, cells: [2], expect: [{contestants: [tensor_mass], solution_l2: {max: 1}}]}]", "", 5,
     "did you mean \"patch_test\"?"},
    {"falling_cells", "[tensor_mass]",
     "[{case: patch_test, cells: [4, 2], expect: [{contestants: [tensor_mass], solution_l2: {max: 1}}]}]", "",
     5, "more cells than before"},
    {"no_cells", "[tensor_mass]",
     "[{case: patch_test, cells: [], expect: [{contestants: [tensor_mass], solution_l2: {max: 1}}]}]", "", 5,
     "at least one number of cells"},
    {"unknown_label", "[tensor_mass]",
     "[{case: patch_test, cells: [2], expect: [{contestants: [tensor_mas], solution_l2: {max: 1}}]}]", "", 5,
     "did you mean \"tensor_mass\"?"},
    {"unknown_measure", "[tensor_mass]",
     "[{case: patch_test, cells: [2], expect: [{contestants: [tensor_mass], solution_l3: {max: 1}}]}]", "", 5,
     "did you mean \"solution_l2\"?"},
    {"no_bound", "[tensor_mass]", "[{case: patch_test, cells: [2], expect: [{contestants: [tensor_mass]}]}]",
     "", 5, "expected a bound"},
    {"no_contestants", "[tensor_mass]", "[{case: patch_test, cells: [2], expect: [{solution_l2: {max: 1}}]}]",
     "", 5, "the key \"contestants\""},
    {"label_twice", "[tensor_mass]",
     "[{case: patch_test, cells: [2], expect: [{contestants: [tensor_mass, tensor_mass], solution_l2: {max: "
     "1}}]}]",
     "", 5, "twice in one case"},
    {"order_of_one_mesh", "[tensor_mass]",
     "[{case: patch_test, cells: [2], expect: [{contestants: [tensor_mass], solution_order: {min: 1}}]}]", "",
     5, "needs two meshes"},
    {"case_twice", "[tensor_mass]",
     "\n  - {case: patch_test, cells: [2], expect: [{contestants: [tensor_mass], solution_l2: {max: 1}}]}"
     "\n  - {case: patch_test, cells: [4], expect: [{contestants: [tensor_mass], solution_l2: {max: 1}}]}",
     "", 7, "case \"patch_test\" twice"},
    {"nothing_expected", "[tensor_mass, test.field]", kGoodCase, "", 5, "nothing is expected of test.field"},
    {"simplifier", "[test.copy]", kGoodCase, "", 4, "is in the contest simplify"},
    {"accept", "[tensor_mass]", kGoodCase, "accept: {solution_l2: {max: 1}}", 6, "bounds in \"expect\""},
    {"sweep", "[tensor_mass]", kGoodCase, "sweep: {vertices: [100]}", 6, "sweeps the cells"},
    {"meshes", "[tensor_mass]", kGoodCase, "meshes: [{name: cube, make: cube}]", 6,
     "belongs to the contest simplify"},
    {"scenes", "[tensor_mass]", kGoodCase, "scenes: [bar]", 6, "belongs to the contest deform"},
};

INSTANTIATE_TEST_SUITE_P(All, VerifyPlanErrors, testing::ValuesIn(kBadVerifyPlans),
                         [](const auto& plan) { return std::string(plan.param.name); });

TEST(VerifyContest, CasesAreThoseOfWhichSomethingIsExpectedFromCoarseToFine) {
  const test::ExperimentFixture fixture;
  const Plan plan =
      read_plan(add_verify_plan(fixture, "[tensor_mass, test.field]",
                                "\n  - {case: patch_test, cells: [2, 4], expect: [{contestants: "
                                "[tensor_mass], solution_l2: {max: 1}}]}"
                                "\n  - {case: bar_tension, cells: [1], expect: [{contestants: "
                                "[test.field], solution_l2: {max: 1}}]}"),
                fixture.registry());
  const std::vector<Case> cases = build_cases(plan, fixture.registry());
  std::vector<std::string> ids;
  ids.reserve(cases.size());
  for (const Case& c : cases) ids.push_back(c.id);
  EXPECT_THAT(ids, ElementsAre("patch_test/tensor_mass/cells=2", "patch_test/tensor_mass/cells=4",
                               "bar_tension/test.field/cells=1"));
  EXPECT_THAT(select_cases(cases, "patch_test/tensor_mass/cells=4"),
              ElementsAre(0, 1));  // the order needs both
  EXPECT_THAT(select_cases(cases, "patch_test/tensor_mass/cells=2"), ElementsAre(0));
}

/// Runs a plan and returns its records by case.
std::map<std::string, json> run_verify(const std::filesystem::path& plan, const std::filesystem::path& out,
                                       int exit_code) {
  const test::ProgramResult result =
      test::run_program({"run", plan.string(), "--out", out.string(), "--no-report"});
  EXPECT_EQ(result.exit_code, exit_code) << result.out << result.error;
  std::map<std::string, json> records;
  for (const json& record : read_records(out / "records.jsonl")) records[record.at("case")] = record;
  return records;
}

TEST(VerifyContest, ARightAnswerPassesAndItsOrderIsObserved) {
  const test::ExperimentFixture fixture;
  const auto plan =
      add_verify_plan(fixture, "[{method: tensor_mass, set: {rtol: 1.0e-12}}]",
                      "\n  - {case: patch_test, cells: [2], expect: [{contestants: [tensor_mass], "
                      "solution_l2: {max: 1.0e-10}}]}"
                      "\n  - {case: manufactured, cells: [2, 4, 8], expect: [{contestants: "
                      "[tensor_mass], solution_order: {min: 1.8}}]}"
                      "\n  - {case: cantilever, cells: [2], expect: [{contestants: [tensor_mass], "
                      "value_error: {max: 0.5}}]}");
  const auto records = run_verify(plan, fixture.folder() / "run", 0);
  ASSERT_EQ(records.size(), 5U);
  for (const auto& [id, record] : records) EXPECT_EQ(record.at("outcome"), "accepted") << id;
  EXPECT_FALSE(records.at("patch_test/tensor_mass/cells=2").at("judge").contains("solution_order"));
  EXPECT_FALSE(records.at("manufactured/tensor_mass/cells=2").at("judge").contains("solution_order"));
  const json& fine = records.at("manufactured/tensor_mass/cells=8").at("judge");
  const json& coarse = records.at("manufactured/tensor_mass/cells=4").at("judge");
  const double order =
      std::log2(coarse.at("solution_l2").get<double>() / fine.at("solution_l2").get<double>());
  EXPECT_NEAR(fine.at("solution_order").get<double>(), order, 1e-12);
  const json& beam = records.at("cantilever/tensor_mass/cells=2").at("judge");
  EXPECT_GT(beam.at("value").get<double>() / beam.at("value_known").get<double>(), 0.5);
  EXPECT_LT(beam.at("value").get<double>() / beam.at("value_known").get<double>(),
            1.0);  // linear elements are too stiff
}

TEST(VerifyContest, AWrongAnswerIsRejected) {
  const test::ExperimentFixture fixture;
  const auto plan =
      add_verify_plan(fixture,
                      "\n  - test.field\n  - {method: tensor_mass, set: {rtol: 0.1}}\n  - {method: "
                      "tensor_mass, label: impatient, set: "
                      "{iterations: 1}}",
                      "\n  - {case: bar_tension, cells: [2], expect: [{contestants: [test.field, "
                      "tensor_mass, impatient], solution_l2: "
                      "{max: 1.0e-10}}]}");
  const auto records = run_verify(plan, fixture.folder() / "run", 1);
  const auto why = [&](const char* label) {
    const json& record = records.at(std::string("bar_tension/") + label + "/cells=2");
    EXPECT_EQ(record.at("outcome"), "rejected") << label;
    return record.at("message").get<std::string>();
  };
  EXPECT_THAT(why("test.field"), HasSubstr("at most 1e-10 is accepted"));
  EXPECT_THAT(why("tensor_mass"), HasSubstr("solution_l2 is"));
  EXPECT_THAT(why("impatient"), HasSubstr("its outcome is not_converged"));
}

TEST(VerifyContest, GoesOnWhereItWasStoppedWithTheSameOrder) {
  const test::ExperimentFixture fixture;
  const auto plan =
      add_verify_plan(fixture, "[tensor_mass]",
                      "[{case: manufactured, cells: [2, 4], expect: [{contestants: [tensor_mass], "
                      "solution_order: {min: 1}}]}]");
  const auto whole = run_verify(plan, fixture.folder() / "whole", 0);
  const auto folder = fixture.folder() / "parts";
  test::run_program({"run", plan.string(), "--out", folder.string(), "--no-report", "--case",
                     "manufactured/tensor_mass/cells=2"});
  const auto result =
      test::run_program({"run", plan.string(), "--out", folder.string(), "--no-report", "--resume"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  for (const json& record : read_records(folder / "records.jsonl"))
    EXPECT_EQ(record.at("judge"), whole.at(record.at("case")).at("judge"));
}

}  // namespace
}  // namespace palpate::experiments
