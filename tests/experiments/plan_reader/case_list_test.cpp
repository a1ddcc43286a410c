#include "experiments/plan_reader/case_list.h"
#include "experiments/runner/contest_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "core/base/error.h"
#include "experiments/runner/read_plan.h"
#include "experiments/text/nearest_name.h"
#include "tests/support/experiment_fixture.h"

namespace palpate::experiments {
namespace {

using testing::ElementsAre;

std::vector<std::string> ids_of(const std::vector<Case>& cases) {
  std::vector<std::string> ids;
  ids.reserve(cases.size());
  for (const Case& c : cases) ids.push_back(c.id);
  return ids;
}

std::vector<Case> cases_of(const std::string& contestants, const std::string& rest) {
  const test::ExperimentFixture fixture;
  return build_cases(read_plan(fixture.add_plan(contestants, rest), fixture.registry()), fixture.registry());
}

TEST(CaseList, SweepCrossesThoseWithoutAStop) {
  const auto cases = cases_of("\n  - test.copy\n  - {method: test.copy, label: own, stop: {fusions: 3}}",
                              "sweep: {tets_removed_ratio: [0.1, 0.22]}\n");
  EXPECT_THAT(ids_of(cases), ElementsAre("cube/test.copy/tets_removed_ratio=0.1",
                                         "cube/test.copy/tets_removed_ratio=0.22", "cube/own"));
  EXPECT_EQ(stop_request(cases[1].stop), nlohmann::json({{"ratio", 0.22}}));
  EXPECT_EQ(stop_request(cases[2].stop), nlohmann::json({{"fusions", 3}}));
}

TEST(CaseList, ValuesThatArePathsStayInTheRunsFolder) {
  const test::ExperimentFixture fixture;
  fixture.folder().add("table.csv", "1");
  const std::string table = (fixture.folder() / "table.csv").string();
  const auto plan = fixture.add_plan("[test.copy]", "sweep: {option.table: [" + table + "]}\n");
  const auto cases = build_cases(read_plan(plan, fixture.registry()), fixture.registry());
  ASSERT_EQ(cases.size(), 1U);
  EXPECT_EQ(std::count(cases[0].id.begin(), cases[0].id.end(), '/'), 2) << cases[0].id;
  EXPECT_EQ(cases[0].options.at("table"), table);
  fixture.run(plan);
  EXPECT_EQ(fixture.records().at(cases[0].id).at("outcome"), "accepted");
  EXPECT_TRUE(std::filesystem::exists(fixture.folder() / "run/meshes" / (cases[0].id + ".mesh")));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(fixture.folder().path()), {}), 4)
      << "cube.mesh, plan.yaml, table.csv, run";
}

TEST(CaseList, ValuesThatAreTheSameNumberAreRefused) {
  const test::ExperimentFixture fixture;
  EXPECT_THAT(fixture.error_of_plan(fixture.add_plan("[test.copy]", "sweep: {option.factor: [0.5, 0.50]}\n")),
              testing::HasSubstr("values that differ"));
}

TEST(CaseList, OptionSweepMeetsThoseThatLeaveItFree) {
  const auto cases = cases_of(
      "\n  - test.copy\n  - {method: test.copy, label: own, set: {factor: 0.5}}\n  - test.limit_only",
      "sweep: {option.factor: [0.1, 1]}\n");
  EXPECT_THAT(ids_of(cases), ElementsAre("cube/test.copy/option.factor=0.1", "cube/test.copy/option.factor=1",
                                         "cube/own", "cube/test.limit_only"));
  EXPECT_EQ(cases[1].options.at("factor"), 1.0);
  EXPECT_EQ(cases[2].options.at("factor"), 0.5);
}

TEST(CaseList, TetsOfFollowsTheSweepOfItsLabelAndComesAfterIt) {
  const auto cases = cases_of(
      "\n  - {method: test.copy, label: b, stop: {tets_of: a}, seeds: [5]}\n  - {method: test.copy, label: "
      "a}",
      "sweep: {fusions: [1, 2]}\n");
  EXPECT_THAT(ids_of(cases), ElementsAre("cube/a/fusions=1", "cube/a/fusions=2", "cube/b/fusions=1/seed=5",
                                         "cube/b/fusions=2/seed=5"));
  EXPECT_EQ(cases[2].tets_of, 0U);
  EXPECT_EQ(cases[3].tets_of, 1U);
  EXPECT_EQ(cases[3].options.at("seed"), 5);
}

TEST(CaseList, SelectionBringsWhatItNeeds) {
  const auto cases = cases_of(
      "\n  - {method: test.copy, label: b, stop: {tets_of: a}, seeds: 3}\n  - {method: test.copy, label: "
      "a}\n  - test.copy",
      "");
  EXPECT_THAT(select_cases(cases, "cube/b/seed=2"), ElementsAre(0U, 2U));
  EXPECT_THAT(select_cases(cases, "cube/b"), ElementsAre(0U, 1U, 2U, 3U));
  EXPECT_EQ(select_cases(cases, "cube").size(), cases.size());
  EXPECT_THROW(select_cases(cases, "cube/bb"), InputError);
}

TEST(NearestName, DistancesAndHints) {
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
  EXPECT_EQ(edit_distance("", "abc"), 3U);
  EXPECT_EQ(edit_distance("contestnats", "contestants"), 1U);
  const std::vector<std::string> known{"alpha", "beta"};
  EXPECT_EQ(nearest_hint("alhpa", known), "; did you mean \"alpha\"?");
  EXPECT_EQ(nearest_hint("omega_squared", known), "; known are alpha, beta");
}

}  // namespace
}  // namespace palpate::experiments
