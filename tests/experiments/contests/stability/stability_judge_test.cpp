// What the judge makes of answers of the contest stability: it goes by the histories, and a contestant that
// says something else is rejected with both named. The test contestant answers as symplectic Euler does and
// then changes its answer.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <string>

#include "experiments/records/record_file.h"
#include "tests/support/experiment_fixture.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class StabilityJudge : public testing::Test {
 protected:
  /// The record of the test contestant that behaves so, with these options.
  json record_of(const std::string& behave, const std::string& options = "") {
    const auto plan = fixture_.folder().add(
        behave + ".yaml",
        "schema: palpate/plan/1\nquestion: Who is believed?\ncontest: stability\ncontestants: "
        "[test.stepper]\n"
        "meshes: [{name: cube, file: cube.mesh}]\nextremes:\n  - {name: a, set: {behave: " +
            behave + options + "}}\n");
    const auto out = fixture_.folder() / ("run_" + behave);
    last_ = test::run_program({"run", plan.string(), "--out", out.string(), "--no-report"});
    const auto records = read_records(out / "records.jsonl");
    EXPECT_EQ(records.size(), 1U) << last_.error;
    return records.at(0);
  }

  test::ExperimentFixture fixture_;
  test::ProgramResult last_;
};

TEST_F(StabilityJudge, AnHonestAnswerIsAcceptedWithTheJudgesFigures) {
  const json record = record_of("honest");
  EXPECT_EQ(record.at("outcome"), "accepted") << record.at("message");
  const json& judge = record.at("judge");
  const json& reported = record.at("reported");
  EXPECT_EQ(judge.at("valid"), true);
  EXPECT_EQ(judge.at("runs").size(), 4U);
  EXPECT_EQ(judge.at("ending"), judge.at("runs")[1].at("ending"));
  EXPECT_EQ(judge.at("bracket").at("lower"), "stable");
  EXPECT_EQ(judge.at("bracket").at("upper"), "grows");
  EXPECT_EQ(judge.at("measured_step_s"), reported.at("measured_step_s"));
  EXPECT_EQ(judge.at("measured_over_predicted"), record.at("report").at("measured_over_predicted"));
  EXPECT_EQ(reported.at("measured_by"), "trials");
  EXPECT_FALSE(judge.contains("predicted_step_s"));
  EXPECT_TRUE(record.at("output_hash").is_string());
  EXPECT_THAT(record.at("mesh_file").get<std::string>(), HasSubstr(".json"));
}

TEST_F(StabilityJudge, ABracketOfLargeMotionsIsJudgedByItsRuns) {
  const json record =
      record_of("honest", ", regime: large, start: stretch, strain: 0.5, damping: none, steps: 300");
  EXPECT_EQ(record.at("outcome"), "accepted") << record.at("message");
  EXPECT_EQ(record.at("judge").at("bracket").at("by"), "runs");
  EXPECT_GT(record.at("judge").at("measured_step_s").get<double>(), 0.0);
}

TEST_F(StabilityJudge, GrowthThatIsCalledSteadyIsRejectedAndBothAreNamed) {
  const json record = record_of("call_it_steady", ", task: run, step_factor: 3");
  EXPECT_EQ(record.at("outcome"), "rejected");
  EXPECT_EQ(record.at("judge").at("ending"), "diverged");
  EXPECT_EQ(record.at("judge").at("valid"), false);
  EXPECT_EQ(record.at("reported").at("outcome"), "steady");
  EXPECT_THAT(record.at("violations").dump(),
              HasSubstr("run 1 it says steady, by its history it is diverged"));
  EXPECT_EQ(last_.exit_code, 1);
}

TEST_F(StabilityJudge, ABracketIsHeldAtBothEnds) {
  for (const auto& [behave, message] :
       std::map<std::string, std::string>{{"lower_grows", "is stable, by its history it is not"},
                                          {"upper_is_stable", "is too long, by its history it is stable"},
                                          {"no_bracket", "and shows no bracket"},
                                          {"longer_step", "the middle of its bracket is"}}) {
    const json record = record_of(behave);
    EXPECT_EQ(record.at("outcome"), "rejected") << behave;
    EXPECT_THAT(record.at("violations").dump(), HasSubstr(message)) << behave;
    EXPECT_FALSE(record.at("judge").contains("measured_step_s")) << behave;
    EXPECT_FALSE(record.at("judge").contains("measured_over_predicted")) << behave;
  }
}

TEST_F(StabilityJudge, FewerStepsThanWereAskedForAreNoAnswer) {
  const json record = record_of("few_steps", ", task: run");
  EXPECT_EQ(record.at("outcome"), "rejected") << record.at("message");
  EXPECT_THAT(record.at("violations").dump(), HasSubstr("200 were asked for"));
}

TEST_F(StabilityJudge, ABrokenFileIsABadAnswerWithOneMessage) {
  for (const auto& [behave, message] : std::map<std::string, std::string>{
           {"no_history", "it wrote no history"},
           {"no_outcome", "its report has no outcome"},
           {"truncated", "its answer cannot be read: history.json"},
           {"missing_rows", "runs[0]: expected a row at least every 10 steps"},
           {"no_rows", "runs[0]: expected rows from step 0 on"},
           {"other_farthest", "the farthest vertex of its last displacement"},
           {"other_mesh", "vertices"},
           {"words_for_numbers", "runs[0].rows[3]: expected a finite number, found \"none\""},
           {"other_schema", "history.json: schema: expected palpate/stability_answer/1"},
           {"runs_are_numbers", "report: runs[0]: expected an object, found 1"}}) {
    const json record = record_of(behave, ", task: run");
    EXPECT_EQ(record.at("outcome"), "bad_answer") << behave << ": " << record.at("message");
    EXPECT_THAT(record.at("message").get<std::string>(), HasSubstr(message)) << behave;
    EXPECT_TRUE(record.at("judge").is_null()) << behave;
  }
}

TEST_F(StabilityJudge, TheSameAnswerHasTheSameBytes) {
  const json first = record_of("honest");
  std::filesystem::remove_all(fixture_.folder() / "run_honest");
  EXPECT_EQ(record_of("honest").at("output_hash"), first.at("output_hash"));
}

}  // namespace
}  // namespace palpate::experiments
