// What the tests of moving contestants share: one is started on a body in motion, and its history is read.
#pragma once

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "reference/door/motion_problem.h"
#include "tests/support/contestant_starter.h"
#include "tests/support/rod.h"

namespace palpate::test {

class MovingContestant : public testing::Test {
 protected:
  experiments::ContestantAnswer run(const std::string& method, const TetMesh& mesh,
                                    const reference::MotionProblem& problem,
                                    const nlohmann::json& options = nlohmann::json::object()) {
    return starter_.run(method, mesh, reference::motion_to_json(problem), options);
  }

  /// The history of a run that is expected to end; report_ is its report.
  reference::MotionHistory move(const std::string& method, const TetMesh& mesh,
                                const reference::MotionProblem& problem,
                                const nlohmann::json& options = nlohmann::json::object()) {
    const experiments::ContestantAnswer answer = run(method, mesh, problem, options);
    EXPECT_EQ(answer.outcome, "ok") << answer.message;
    if (answer.outcome != "ok") return {};
    report_ = answer.report;
    EXPECT_EQ(report_.at("outcome"), "completed");
    return reference::read_history(answer.output, problem);
  }

  reference::MotionHistory move(const std::string& method, const Rod& rod,
                                const nlohmann::json& options = nlohmann::json::object()) {
    return move(method, rod.mesh, rod.problem, options);
  }

  ContestantStarter starter_;
  nlohmann::json report_;
};

}  // namespace palpate::test
