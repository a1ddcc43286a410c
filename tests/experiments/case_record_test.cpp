#include "experiments/case_record.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

/// Repeats of one answer in a contest whose judge goes by the outcome that the report names.
class JudgedRepeats : public testing::Test {
 protected:
  json judge(const std::string& outcome, const std::string& output) {
    ContestantAnswer answer;
    answer.outcome = "ok";
    answer.report = {{"outcome", outcome}};
    answer.output = folder_.add("output", output);
    json record = {{"outcome", "ok"}, {"report", answer.report}, {"notes", json::array()}};
    const auto figures = [&](const std::filesystem::path&) {
      ++judged_;
      json found = {{"valid", outcome == "converged"}, {"findings", json::array()}};
      if (outcome != "converged") found["findings"].push_back("its outcome is " + outcome);
      return found;
    };
    judge_answer({figures, [](json&) {}, "displacement"}, {plan_, case_, contestant_, {}}, answer, earlier_,
                 record);
    earlier_.push_back(record);
    return record;
  }

  test::ScratchFolder folder_;
  Plan plan_;
  Case case_;
  PlanContestant contestant_;
  std::vector<json> earlier_;
  int judged_ = 0;
};

TEST_F(JudgedRepeats, TheSameOutputIsJudgedOnce) {
  EXPECT_EQ(judge("converged", "1,2,3").at("outcome"), "accepted");
  EXPECT_EQ(judge("converged", "1,2,3").at("outcome"), "accepted");
  EXPECT_EQ(judged_, 1);
}

TEST_F(JudgedRepeats, AnotherOutputIsAViolation) {
  judge("converged", "1,2,3");
  EXPECT_EQ(judge("converged", "1,2,4").at("outcome"), "rejected");
  EXPECT_EQ(judged_, 2);
}

TEST_F(JudgedRepeats, TheSameBytesWithAnotherOutcomeAreJudgedAnew) {
  judge("converged", "1,2,3");
  const json record = judge("diverged", "1,2,3");
  EXPECT_EQ(record.at("outcome"), "rejected");
  EXPECT_EQ(record.at("message"), "its outcome is diverged");
}

}  // namespace
}  // namespace palpate::experiments
