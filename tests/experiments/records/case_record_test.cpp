#include "experiments/records/case_record.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <thread>

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
    json record = {
        {"outcome", "ok"}, {"report", answer.report}, {"notes", json::array()}, {"output_hash", nullptr}};
    const auto figures = [&](const std::filesystem::path&) {
      std::ofstream(folder_ / "judged", std::ios::app) << "x";  // the judge is another process
      if (outcome == "endless") std::this_thread::sleep_for(std::chrono::hours(1));
      json found = {{"valid", outcome == "converged"}, {"findings", json::array()}};
      if (outcome != "converged") found["findings"].push_back("its outcome is " + outcome);
      return found;
    };
    RepeatFacts facts{plan_, case_, contestant_, {}};
    facts.judge_bounds.timeout_s = outcome == "endless" ? 0.1 : 60.0;
    facts.judge_bounds.stop_flag = stop_flag_;
    judge_answer({figures, [](json&) {}, "displacement"}, facts, answer, earlier_, record);
    earlier_.push_back(record);
    return record;
  }

  test::ScratchFolder folder_;
  Plan plan_;
  Case case_;
  PlanContestant contestant_;
  std::vector<json> earlier_;
  const volatile std::sig_atomic_t* stop_flag_ = nullptr;

  std::size_t judged() const { return test::bytes_of(folder_ / "judged").size(); }
};

TEST_F(JudgedRepeats, TheSameOutputIsJudgedOnce) {
  EXPECT_EQ(judge("converged", "1,2,3").at("outcome"), "accepted");
  EXPECT_EQ(judge("converged", "1,2,3").at("outcome"), "accepted");
  EXPECT_EQ(judged(), 1U);
}

TEST_F(JudgedRepeats, AnotherOutputIsAViolation) {
  judge("converged", "1,2,3");
  EXPECT_EQ(judge("converged", "1,2,4").at("outcome"), "rejected");
  EXPECT_EQ(judged(), 2U);
}

TEST_F(JudgedRepeats, TheSameBytesWithAnotherOutcomeAreJudgedAnew) {
  judge("converged", "1,2,3");
  const json record = judge("diverged", "1,2,3");
  EXPECT_EQ(record.at("outcome"), "rejected");
  EXPECT_EQ(record.at("message"), "its outcome is diverged");
}

TEST_F(JudgedRepeats, AJudgeThatRunsOutOfTimeAcceptsNothing) {
  const json record = judge("endless", "1,2,3");
  EXPECT_EQ(record.at("outcome"), "not_judged");
  EXPECT_EQ(record.at("message"), "the judge took longer than 0.1 s");
  EXPECT_TRUE(record.value("judge", json()).is_null());
  EXPECT_EQ(judge("converged", "1,2,3").at("outcome"), "accepted") << "what was not judged is judged anew";
}

TEST_F(JudgedRepeats, AnInterruptedJudgeLeavesNoOutcome) {
  const volatile std::sig_atomic_t raised = 1;
  stop_flag_ = &raised;
  EXPECT_EQ(judge("converged", "1,2,3").at("outcome"), "interrupted");
}

}  // namespace
}  // namespace palpate::experiments
