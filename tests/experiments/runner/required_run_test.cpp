// What a plan requires of its report decides the exit code: whole runs, with the report that comes with them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/experiment_fixture.h"

namespace palpate::experiments {
namespace {

using test::ProgramResult;
using test::run_program;
using testing::HasSubstr;
using testing::Not;

/// `moved` has a vertex of its skin elsewhere, so its volume drifts; `copy` is the input.
constexpr const char* kContestants =
    "\n  - {method: test.copy, label: copy}\n"
    "  - {method: test.copy, label: moved, set: {behave: move_skin}}";

ProgramResult run_requiring(const test::ExperimentFixture& fixture, const std::string& what,
                            const std::vector<std::string>& more = {}) {
  const auto plan = fixture.add_plan(kContestants, "charts: [overview]\n" + what + "\n");
  std::vector<std::string> arguments{"run", plan.string(), "--out", (fixture.folder() / "run").string()};
  arguments.insert(arguments.end(), more.begin(), more.end());
  ProgramResult result = run_program(arguments);
  std::filesystem::remove_all(fixture.folder() / "run");
  return result;
}

std::string comparison(const std::string& of, const std::string& peer, const std::string& required) {
  return "comparisons:\n  - {of: " + of + ", against_best_of: [" + peer +
         "], measures: [volume_drift_relative]" + required + "}";
}

TEST(RequiredRun, AComparisonThatDoesNotHoldEndsWithOneAndIsNamed) {
  const test::ExperimentFixture fixture;
  const ProgramResult held = run_requiring(fixture, comparison("copy", "moved", ", required: true"));
  EXPECT_EQ(held.exit_code, 0) << held.error << held.out;
  EXPECT_THAT(held.out, Not(HasSubstr("does not hold")));
  const ProgramResult failed = run_requiring(fixture, comparison("moved", "copy", ", required: true"));
  EXPECT_EQ(failed.exit_code, 1) << failed.error << failed.out;
  EXPECT_THAT(failed.out,
              HasSubstr("required, and does not hold: the comparison of moved with copy: 1 short"));
  EXPECT_THAT(failed.error, Not(HasSubstr("the report failed")));
  const ProgramResult shown = run_requiring(fixture, comparison("moved", "copy", ""));
  EXPECT_EQ(shown.exit_code, 0) << shown.error << shown.out;
}

TEST(RequiredRun, AClaimThatDoesNotReproduceEndsWithOne) {
  const test::ExperimentFixture fixture;
  const ProgramResult failed = run_requiring(
      fixture, "claim: {text: t, measure: volume_drift_relative, better: copy, than: copy, required: true}");
  EXPECT_EQ(failed.exit_code, 1) << failed.error << failed.out;
  std::string said = failed.out;  // whose lines are as long as the terminal is wide
  std::replace(said.begin(), said.end(), '\n', ' ');
  EXPECT_THAT(
      said, HasSubstr("required, and does not hold: the claim that copy beats copy: it does not reproduce"));
}

TEST(RequiredRun, WithoutAReportItIsSaidThatNobodyLooks) {
  const test::ExperimentFixture fixture;
  const ProgramResult result =
      run_requiring(fixture, comparison("moved", "copy", ", required: true"), {"--no-report"});
  EXPECT_EQ(result.exit_code, 0) << result.error << result.out;
  EXPECT_THAT(result.error, HasSubstr("nobody looks at what the plan requires"));
  EXPECT_THAT(run_requiring(fixture, comparison("moved", "copy", ", required: false"), {"--no-report"}).error,
              Not(HasSubstr("nobody looks")));
}

}  // namespace
}  // namespace palpate::experiments
