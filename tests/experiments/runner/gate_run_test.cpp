#include "experiments/runner/gate_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "core/base/error.h"
#include "experiments/records/record_file.h"
#include "experiments/records/run_folder.h"
#include "experiments/runner/gate.h"
#include "tests/support/experiment_fixture.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

/// A run of two repeats of two cases, the second of which does as it is told and decides nothing.
class GateRun : public testing::Test {
 protected:
  void run(const std::string& behave = "copy") {
    const auto plan = fixture_.add_plan(
        "\n  - {method: test.copy, label: a}\n  - {method: test.copy, label: b, required: false, set: "
        "{behave: " +
            behave + "}}",
        "run: {repeats: 2}\nmeasure: [tets_out, kernel_s]\naccept: {inverted_tets: {max: 0}}\n");
    fixture_.run(plan);
  }
  std::filesystem::path folder() const { return fixture_.folder() / "run"; }
  std::vector<json> records() const { return read_run_records(folder()); }
  std::vector<std::string> problems() const { return find_run_problems(folder(), records()); }
  void keep_lines(std::size_t count) const {
    std::string text;
    const auto all = records();
    for (std::size_t i = 0; i < std::min(count, all.size()); ++i) text += all[i].dump() + "\n";
    fixture_.folder().add("run/records.jsonl", text);
  }

  test::ExperimentFixture fixture_;
};

TEST_F(GateRun, AWholeRunHasNoProblem) {
  run();
  EXPECT_THAT(problems(), ElementsAre());
}

TEST_F(GateRun, APartOfARunIsNoRun) {
  run();
  keep_lines(4);  // the input, both cases, and the first one again
  EXPECT_THAT(problems(), ElementsAre("cube/b: 1 of its 2 repeats are missing"));
  keep_lines(2);
  EXPECT_THAT(problems(), ElementsAre("cube/a: 1 of its 2 repeats are missing",
                                      "cube/b: 2 of its 2 repeats are missing"));
}

TEST_F(GateRun, ACaseOfSeveralSeedsIsWholeWithItsOwnRepeats) {
  fixture_.run(fixture_.add_plan("\n  - {method: test.copy, label: a, seeds: 2}",
                                 "run: {repeats: 3, seed_repeats: 2}\nmeasure: [tets_out]\n"));
  EXPECT_THAT(problems(), ElementsAre());
  keep_lines(4);  // the input, both seeds, and the first one again
  EXPECT_THAT(problems(), ElementsAre("cube/a/seed=2: 1 of its 2 repeats are missing"));
}

TEST_F(GateRun, ACrashFailsWhoeverItIs) {
  run("crash");
  EXPECT_THAT(problems(), ElementsAre(HasSubstr("cube/b: crashed: killed by signal 11")));
}

TEST_F(GateRun, OneThatIsNotRequiredMayBeRejected) {
  run("invert");
  EXPECT_EQ(records().back().at("outcome"), "rejected");
  EXPECT_THAT(problems(), ElementsAre());
}

TEST_F(GateRun, WithoutPlanOrProvenanceNothingHolds) {
  run();
  const std::string plan = test::bytes_of(folder() / "plan.yaml");
  fixture_.folder().add("run/plan.yaml", plan + "# changed\n");
  EXPECT_THAT(problems(), ElementsAre("plan.yaml is not the plan that provenance.json names"));
  std::filesystem::remove(folder() / "plan.yaml");
  EXPECT_THAT(problems(), ElementsAre("plan.yaml is missing"));
  fixture_.folder().add("run/plan.yaml", plan);
  json provenance = json::parse(test::bytes_of(folder() / "provenance.json"));
  provenance.erase("cases");
  fixture_.folder().add("run/provenance.json", provenance.dump());
  EXPECT_THAT(problems(), ElementsAre(HasSubstr("cannot be told whole")));
  std::filesystem::remove(folder() / "provenance.json");
  EXPECT_THAT(problems(), ElementsAre(HasSubstr("provenance.json is missing")));
}

TEST_F(GateRun, RecordsOfStrangersAreNamed) {
  run();
  json stranger = records().back();
  stranger["case"] = "cube/c";
  RecordFile(folder() / "records.jsonl").append(stranger);
  EXPECT_THAT(problems(), ElementsAre("cube/c: is no case of the run's plan"));
}

TEST_F(GateRun, TheFirstAcceptedFiguresAreThePlansWithoutTimes) {
  run();
  const auto file = fixture_.folder().add("plan.json", propose_accepted(folder(), records(), "plan").dump());
  const auto changes = update_accepted(hold_against(records(), "plan", file), file);
  EXPECT_THAT(changes,
              ElementsAre("cube/input tets_out: none -> 384 1", "cube/input inverted_tets: none -> 0 1",
                          "cube/a tets_out: none -> 384 1", "cube/a inverted_tets: none -> 0 1",
                          "cube/b tets_out: none -> 384 1", "cube/b inverted_tets: none -> 0 1"));
  EXPECT_TRUE(hold_against(records(), "plan", file).holds());
}

TEST_F(GateRun, TheCommandFailsOnAnUnsoundRunAndMakesTheFirstFile) {
  run();
  const std::string accepted = (fixture_.folder() / "accepted.json").string();
  const std::vector<std::string> gate{"gate", folder().string(), "--accepted", accepted};
  EXPECT_EQ(test::run_program(gate).exit_code, 2) << "nothing is accepted yet";
  std::vector<std::string> update = gate;
  update.emplace_back("--update");
  const test::ProgramResult first = test::run_program(update);
  EXPECT_EQ(first.exit_code, 0) << first.error;
  EXPECT_THAT(first.error, HasSubstr("its tolerances are 0"));
  EXPECT_EQ(test::run_program(gate).exit_code, 0);
  const std::string before = test::bytes_of(accepted);
  keep_lines(3);
  const test::ProgramResult torn = test::run_program(update);
  EXPECT_EQ(torn.exit_code, 1) << torn.error;
  EXPECT_THAT(torn.out, HasSubstr("cube/a: 1 of its 2 repeats are missing"));
  EXPECT_EQ(test::bytes_of(accepted), before) << "what is not whole accepts nothing";
}

}  // namespace
}  // namespace palpate::experiments
