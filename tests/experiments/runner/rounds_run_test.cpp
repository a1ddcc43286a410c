// Runs in random rounds, of chosen cases, and with repeats until an interval is narrow.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "experiments/gates/gate_run.h"
#include "experiments/records/record_file.h"
#include "experiments/records/run_rows.h"
#include "experiments/runner/read_plan.h"
#include "experiments/runner/runner.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/quiet_run.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using test::records_by_case;
using test::run_quietly;
using testing::HasSubstr;

json provenance_of(const std::filesystem::path& folder) {
  return json::parse(test::bytes_of(folder / "provenance.json"));
}

RunResult run_only(const test::ExperimentFixture& fixture, const std::filesystem::path& plan,
                   const std::filesystem::path& folder, const std::vector<std::string>& only) {
  RunOptions options;
  options.folder = folder;
  options.only = only;
  Progress progress(true);
  return run_plan(read_plan(plan, fixture.registry()), fixture.registry(), options, progress);
}

std::vector<std::string> order_of(const std::filesystem::path& folder) {
  std::vector<std::string> order;
  for (const json& record : read_records(folder / "records.jsonl")) {
    if (!record.at("contestant").is_null())
      order.push_back(record.at("case").get<std::string>() + "#" + record.at("repeat").dump());
  }
  return order;
}

const char* const kFive =
    "\n  - {method: test.copy, label: a}\n  - {method: test.copy, label: b}\n"
    "  - {method: test.copy, label: c}\n  - {method: test.copy, label: d}\n"
    "  - {method: test.copy, label: e, stop: {tets_of: d}}";

TEST(Rounds, TheOrderIsOfTheSeedAndOutputsAreNot) {
  const test::ExperimentFixture fixture;
  std::map<std::string, std::vector<std::string>> orders;
  std::map<std::string, std::map<std::string, std::string>> outputs;
  for (const std::string run : {"one", "same", "other"}) {
    const std::string seed = run == "other" ? "8" : "7";
    const auto plan = fixture.add_plan(kFive, "run: {repeats: 3, order_seed: " + seed + "}\n", "plan" + run);
    run_quietly(fixture, plan, fixture.folder() / run);
    orders[run] = order_of(fixture.folder() / run);
    for (const auto& [id, records] : records_by_case(fixture.folder() / run)) {
      for (const json& record : records) EXPECT_EQ(record.at("outcome"), "accepted") << record.dump();
      outputs[run][id] = records.front().at("output_hash").dump() + records.front().at("stop").dump();
    }
    EXPECT_EQ(provenance_of(fixture.folder() / run).at("order_seed"), std::stoi(seed));
  }
  EXPECT_EQ(orders["one"], orders["same"]);
  EXPECT_NE(orders["one"], orders["other"]);
  EXPECT_EQ(outputs["one"], outputs["other"]);
  EXPECT_EQ(provenance_of(fixture.folder() / "one").at("cases"),
            json({"cube/a", "cube/b", "cube/c", "cube/d", "cube/e"}))
      << "the plan's order";
}

TEST(Rounds, RecordsSayTheirPositionAndTheLoad) {
  const test::ExperimentFixture fixture;
  const auto plan = fixture.add_plan(kFive, "run: {repeats: 2}\n");
  run_quietly(fixture, plan, fixture.folder() / "run");
  std::map<int, std::vector<int>> positions;
  for (const auto& [id, records] : records_by_case(fixture.folder() / "run")) {
    for (const json& record : records) {
      if (record.at("contestant").is_null()) continue;
      positions[record.at("repeat").get<int>()].push_back(record.at("position").get<int>());
      EXPECT_TRUE(record.at("load_1min").is_number());
      EXPECT_GE(record.at("processor_s").get<double>(), 0.0);
      EXPECT_LE(record.at("others_s").get<double>(), record.at("processor_s").get<double>());
    }
  }
  for (const auto& [repeat, own] : positions)
    EXPECT_THAT(own, testing::UnorderedElementsAre(0, 1, 2, 3, 4)) << repeat;
}

TEST(Rounds, AChildThatWasKilledLeavesNoShare) {
  const test::ExperimentFixture fixture;
  const auto plan =
      fixture.add_plan("[{method: test.copy, label: a, set: {behave: hang}}]", "run: {timeout_s: 0.3}\n");
  run_quietly(fixture, plan, fixture.folder() / "run");
  const auto records = records_by_case(fixture.folder() / "run");
  const json& record = records.at("cube/a").front();
  EXPECT_EQ(record.at("outcome"), "timed_out");
  EXPECT_TRUE(record.at("load_1min").is_number());
  EXPECT_TRUE(record.at("others_s").is_null());
}

TEST(Rounds, AChoiceOfCasesIsStatedAndCompleted) {
  const test::ExperimentFixture fixture;
  const auto plan = fixture.add_plan(kFive, "run: {repeats: 2, warmup: 1}\n");
  const auto folder = fixture.folder() / "run";
  run_only(fixture, plan, folder, {"b", "cube/e"});
  EXPECT_EQ(records_by_case(folder).size(), 4U) << "b, e, what e needs, the input";
  json sittings = provenance_of(folder).at("sittings");
  ASSERT_EQ(sittings.size(), 1U);
  EXPECT_EQ(sittings[0].at("chosen"), json({{"only", {"b", "cube/e"}}}));
  const auto missing = find_run_problems(folder, read_run_rows(folder, {}));
  EXPECT_THAT(missing, testing::UnorderedElementsAre(HasSubstr("cube/a: 3 of its 3 repeats are missing"),
                                                     HasSubstr("cube/c: 3 of its 3 repeats are missing")));
  // The rounds' order does not change by the choice, so that positions are those of the whole plan.
  std::map<std::string, json> positions;
  for (const auto& [id, records] : records_by_case(folder))
    positions[id] = records.back().value("position", json());
  run_quietly(fixture, plan, folder, true);
  sittings = provenance_of(folder).at("sittings");
  ASSERT_EQ(sittings.size(), 2U);
  EXPECT_FALSE(sittings[1].contains("chosen"));
  EXPECT_THAT(find_run_problems(folder, read_run_rows(folder, {})), testing::IsEmpty());
  run_quietly(fixture, plan, fixture.folder() / "whole");
  for (const auto& [id, records] : records_by_case(fixture.folder() / "whole")) {
    const auto before = positions.find(id);
    if (before == positions.end()) continue;
    EXPECT_EQ(records.back().value("position", json()), before->second) << id;
  }
}

TEST(Rounds, RepeatsUntilTheIntervalIsNarrowOrTheLimit) {
  const test::ExperimentFixture fixture;
  // Any six times are within a factor of 1000; no two of varying_time are within 1e-6 of each other.
  for (const auto& [width, expected, reason] :
       {std::tuple{"1000", 7U, "narrow"}, std::tuple{"0.000001", 9U, "limit"}}) {
    const auto folder = fixture.folder() / reason;
    const auto plan = fixture.add_plan(
        "\n  - {method: test.copy, label: a, set: {behave: varying_time}}\n  - {method: test.copy, label: "
        "crash, set: {behave: crash}}\n"
        "  - {method: test.copy, label: seeded, seeds: [4]}",
        std::string("run: {repeats: 6, warmup: 1, seed_repeats: 1, until_width: ") + width +
            ", most_repeats: 8}\n",
        std::string("plan_") + reason);
    run_quietly(fixture, plan, folder);
    const auto records = records_by_case(folder);
    EXPECT_EQ(records.at("cube/a").size(), expected);
    EXPECT_EQ(records.at("cube/crash").size(), 7U) << "more repeats give it no time";
    EXPECT_EQ(records.at("cube/seeded/seed=4").size(), 2U);
    const json provenance = provenance_of(folder);
    EXPECT_EQ(provenance.at("repeats_ended").at("cube/a").at("reason"), reason);
    EXPECT_EQ(provenance.at("repeats_ended").at("cube/a").at("repeats"), expected - 1);
    EXPECT_EQ(provenance.at("repeats_ended").at("cube/crash").at("reason"), "no_time");
    EXPECT_FALSE(provenance.at("repeats_ended").contains("cube/seeded/seed=4"));
    for (const std::string& problem : find_run_problems(folder, read_run_rows(folder, {})))
      EXPECT_EQ(problem.find("missing"), std::string::npos) << problem;
    EXPECT_EQ(run_quietly(fixture, plan, folder, true).records_added, 0U) << "it has ended";
  }
}

TEST(Rounds, ARunThatIsBrokenOffIsNotWholeAndGoesOn) {
  const test::ExperimentFixture fixture;
  const auto folder = fixture.folder() / "run";
  const auto plan = fixture.add_plan("[{method: test.copy, label: a, set: {behave: varying_time}}]",
                                     "run: {repeats: 3, until_width: 0.000001, most_repeats: 8}\n");
  run_quietly(fixture, plan, folder);
  std::string kept;  // as if it had been killed after its fourth repeat
  for (const json& record : read_records(folder / "records.jsonl"))
    if (record.at("repeat").get<int>() < 4) kept += record.dump() + "\n";
  json provenance = provenance_of(folder);
  provenance["repeats_of"] = json({{"cube/a", 8}});
  fixture.folder().add("run/records.jsonl", kept);
  fixture.folder().add("run/provenance.json", provenance.dump());
  EXPECT_THAT(find_run_problems(folder, read_run_rows(folder, {})),
              testing::ElementsAre(HasSubstr("cube/a: 4 of its 8 repeats are missing")));
  EXPECT_EQ(run_quietly(fixture, plan, folder, true).records_added, 4U);
  EXPECT_THAT(find_run_problems(folder, read_run_rows(folder, {})), testing::IsEmpty());
}

}  // namespace
}  // namespace palpate::experiments
