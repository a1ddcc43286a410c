#include "experiments/gates/gate_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "experiments/gates/accept.h"
#include "experiments/gates/gate.h"
#include "experiments/records/record_file.h"
#include "experiments/records/run_rows.h"
#include "tests/support/experiment_fixture.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

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
  /// With the figures of the plan.
  RunRows rows() const { return read_run_rows(folder(), measures_to_propose(known_provenance(folder()))); }
  /// Round by round, in the order of the plan's cases.
  std::vector<json> records() const {
    std::map<std::pair<std::string, std::int64_t>, json> read;
    for (const json& record : read_records(folder() / "records.jsonl"))
      read[{record.at("case").get<std::string>(), record.at("repeat").get<std::int64_t>()}] = record;
    std::vector<json> all;
    const RunRows ordered = rows();
    for (const RunRow& row : ordered.all()) all.push_back(read.at({*row.run_case, row.repeat}));
    return all;
  }
  nlohmann::ordered_json propose(const std::string& plan, const std::vector<FigureKind>& kinds) const {
    return propose_accepted(folder(), rows(), plan, kinds);
  }
  std::vector<std::string> problems() const { return find_run_problems(folder(), rows()); }
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
  const auto file = fixture_.folder().add("plan.json", propose("plan", default_kinds()).dump());
  std::vector<std::string> texts;
  for (const AcceptedChange& change : update_accepted(hold_against(rows(), "plan", file), file))
    texts.push_back(change.text());
  const std::string hash = records().back().at("output_hash").get<std::string>();
  EXPECT_THAT(texts, ElementsAre("cube/input tets_out: none -> 384", "cube/input inverted_tets: none -> 0",
                                 "cube/a outcome: none -> accepted", "cube/a tets_out: none -> 384",
                                 "cube/a inverted_tets: none -> 0", "cube/a hash: none -> " + hash,
                                 "cube/b outcome: none -> accepted", "cube/b tets_out: none -> 384",
                                 "cube/b inverted_tets: none -> 0", "cube/b hash: none -> " + hash));
  EXPECT_TRUE(hold_against(rows(), "plan", file).holds());
  const json kinds = propose("plan", {FigureKind::kValidity});
  EXPECT_EQ(kinds.at("figures").size(), 5U);
  EXPECT_THROW(propose("plan", {FigureKind::kComparison}), InputError);
  EXPECT_THROW(propose("plan", {FigureKind::kStability}), InputError) << "the plan names none";
}

TEST_F(GateRun, AHashIsProposedOnlyWhereRepeatsShowThatItHolds) {
  fixture_.run(fixture_.add_plan("[test.copy]", "run: {repeats: 1}\nmeasure: [tets_out]\n"));
  const std::string text = propose("plan", default_kinds()).dump();
  EXPECT_THAT(text, testing::Not(HasSubstr("\"hash\"")));
}

TEST_F(GateRun, TheCommandFailsOnAnUnsoundRunAndMakesTheFirstFile) {
  run();
  const std::string accepted = (fixture_.folder() / "accepted.json").string();
  const std::vector<std::string> gate{"gate", folder().string(), "--accepted", accepted};
  const test::ProgramResult nothing = test::run_program(gate);
  EXPECT_EQ(nothing.exit_code, 1);
  EXPECT_THAT(nothing.out, HasSubstr("FAILS: nothing to compare: there are no accepted figures at " +
                                     accepted + "; palpate gate RUN --update writes them"));
  std::vector<std::string> update = gate;
  update.emplace_back("--update");
  const test::ProgramResult first = test::run_program(update);
  EXPECT_EQ(first.exit_code, 0) << first.error;
  EXPECT_THAT(first.error, HasSubstr("its tolerances are 0"));
  const test::ProgramResult again = test::run_program(gate);
  EXPECT_EQ(again.exit_code, 0);
  EXPECT_EQ(again.out, "holds: 10 of 10 figures hold: 3 of accuracy, 5 of validity, 2 of hash\n");
  const std::string before = test::bytes_of(accepted);
  keep_lines(3);
  const test::ProgramResult torn = test::run_program(update);
  EXPECT_EQ(torn.exit_code, 1) << torn.error;
  EXPECT_THAT(torn.out, HasSubstr("cube/a: 1 of its 2 repeats are missing"));
  EXPECT_EQ(test::bytes_of(accepted), before) << "what is not whole accepts nothing";
  for (const std::string name : {"--markdown", "--junit"}) {
    std::vector<std::string> onto = gate;
    onto.insert(onto.end(), {name, accepted});
    const test::ProgramResult refused = test::run_program(onto);
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_THAT(refused.error, HasSubstr("expected a new file or an earlier summary, found a file of data"));
    EXPECT_EQ(test::bytes_of(accepted), before);
  }
  std::vector<std::string> both = gate;
  both.insert(both.end(), {"--junit", "gate.txt", "--markdown", "./gate.txt"});
  EXPECT_THAT(test::run_program(both).error,
              HasSubstr("--markdown: expected another file than that of --junit"));
  update[3] += ".none";
  EXPECT_THAT(test::run_program(update).out, Not(HasSubstr("--update writes them"))) << "it has just refused";
}

TEST_F(GateRun, TheCommandSaysWhatFellShortFirstAndWritesBothSummaries) {
  run();
  const auto figure = [](const char* measure, double value, double tolerance) {
    return json{{"kind", "accuracy"}, {"case", "cube/a"},   {"measure", measure}, {"value", value},
                {"lower", tolerance}, {"upper", tolerance}, {"unit", "1"}};
  };
  const auto accepted = fixture_.folder().add(
      "accepted.json",
      json{{"schema", "palpate/accepted/2"},
           {"plan", "plan"},
           {"figures", {figure("tets_out", 383, 0.5), figure("tets", 384, 0), figure("vertices", 100, 5)}}}
          .dump());
  const auto junit = fixture_.folder() / "junit.xml";
  const auto markdown = fixture_.folder() / "summary.md";
  const test::ProgramResult said =
      test::run_program({"gate", folder().string(), "--accepted", accepted.string(), "--junit",
                         junit.string(), "--markdown", markdown.string()});
  EXPECT_EQ(said.exit_code, 1);
  const std::size_t first = said.out.find("vertices");
  EXPECT_LT(first, said.out.find("tets_out")) << "farther outside";
  EXPECT_THAT(said.out, HasSubstr("above the upper bound by 20 (20%), 4 times the tolerance"));
  EXPECT_THAT(said.out, HasSubstr("FAILS: 1 of 3 figures hold: 1 of 3 of accuracy\n"));
  EXPECT_THAT(said.out, testing::Not(HasSubstr("cube/a tets ")));
  EXPECT_THAT(test::bytes_of(junit), HasSubstr("tests=\"3\" failures=\"2\""));
  EXPECT_THAT(test::bytes_of(markdown), HasSubstr("## palpate gate fails: plan"));
  EXPECT_THAT(
      test::run_program({"gate", folder().string(), "--accepted", accepted.string(), "--kinds", "hash"})
          .error,
      HasSubstr("--kinds belongs to --update"));
}

TEST_F(GateRun, AProvenanceOfAnotherPlanHoldsNothingWhateverTheFiguresSay) {
  run();
  const std::string accepted = (fixture_.folder() / "accepted.json").string();
  const std::vector<std::string> gate{"gate", folder().string(), "--accepted", accepted};
  std::vector<std::string> update = gate;
  update.emplace_back("--update");
  ASSERT_EQ(test::run_program(update).exit_code, 0);
  const std::string before = test::bytes_of(accepted);
  json provenance = json::parse(test::bytes_of(folder() / "provenance.json"));
  provenance["plan"] = "another";
  fixture_.folder().add("run/provenance.json", provenance.dump());
  const std::string problem = "provenance.json names the plan \"another\", and records are of \"plan\"";
  EXPECT_THAT(problems(), ElementsAre(problem));
  // What the figures need is read all the same, so that they are compared and said.
  const test::ProgramResult foreign = test::run_program(gate);
  EXPECT_EQ(foreign.exit_code, 1);
  EXPECT_THAT(foreign.out, testing::AllOf(HasSubstr(problem), HasSubstr("FAILS: 10 of 10 figures hold")));
  const test::ProgramResult kept = test::run_program(update);
  EXPECT_EQ(kept.exit_code, 1);
  EXPECT_THAT(kept.error, HasSubstr("the accepted figures are unchanged: the run is not sound"));
  EXPECT_EQ(test::bytes_of(accepted), before);
  std::filesystem::remove(folder() / "provenance.json");
  EXPECT_THAT(test::run_program(gate).out, HasSubstr("10 of 10 figures hold"));
}

TEST_F(GateRun, ARunWithoutRecordsHasNothingToCompare) {
  run();
  keep_lines(0);
  const test::ProgramResult empty = test::run_program({"gate", folder().string()});
  EXPECT_EQ(empty.exit_code, 1) << empty.error;
  EXPECT_THAT(empty.out, HasSubstr("nothing to compare: the run has no records"));
}

}  // namespace
}  // namespace palpate::experiments
