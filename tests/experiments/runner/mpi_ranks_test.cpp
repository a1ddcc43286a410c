// run: {mpi_ranks: N}: who gets it, and that finite elements on two ranks are those on one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "experiments/campaign/campaign.h"
#include "experiments/registry/option_spec.h"
#include "experiments/runner/contest_table.h"
#include "experiments/runner/read_plan.h"
#include "tests/support/experiment_fixture.h"
#include "tests/support/scene_text.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using testing::HasSubstr;

/// Plans over the scene "block" with real finite elements; answers are kept in a cache of the test's own.
class MpiRanks : public testing::Test {
 protected:
  MpiRanks() {
    ::setenv("PALPATE_CACHE", (fixture_.folder() / "cache").c_str(), 1);
    fixture_.folder().add("block.yaml", test::SceneText().yaml());
  }
  ~MpiRanks() override { ::unsetenv("PALPATE_CACHE"); }

  void SetUp() override { ASSERT_EQ(fixture_.registry().find("fem.p2")->contestant->unavailable(), ""); }

  std::filesystem::path add_plan(const std::string& run, const std::string& contestants) const {
    return fixture_.folder().add(
        "plan.yaml",
        "schema: palpate/plan/1\nquestion: How many ranks?\ncontest: deform\n"
        "scenes: [{name: block, file: block.yaml}]\nreference: {method: fem.p2, levels: "
        "1}\ncontestants: " +
            contestants + "\nrun: " + run + "\n");
  }

  test::ExperimentFixture fixture_;
};

TEST_F(MpiRanks, TheSameAnswerOnOneRankAndOnTwo) {
  const std::string contestants =
      "\n  - {method: fem.p1, label: as_the_plan}\n  - {method: fem.p1, label: one, set: {processes: 1}}";
  const RunResult result = fixture_.run(add_plan("{mpi_ranks: 2, repeats: 2}", contestants));
  EXPECT_FALSE(result.required_failed);
  const auto all = fixture_.records();
  const json& two = all.at("block/as_the_plan");
  const json& one = all.at("block/one");
  EXPECT_EQ(two.at("outcome"), "accepted") << two.dump();
  EXPECT_EQ(two.at("report").at("processes"), 2);
  EXPECT_EQ(one.at("report").at("processes"), 1);
  EXPECT_EQ(all.at("block/reference").at("judge").at("level_reports").at(0).at("report").at("processes"), 2);
  // fem.p1 solves to 1e-10 of its load; what that leaves of the displacement is below 1e-8.
  const double error = one.at("judge").at("displacement_l2").get<double>();
  EXPECT_GT(error, 1e-3) << "a figure that could not differ would prove nothing";
  EXPECT_NEAR(two.at("judge").at("displacement_l2").get<double>(), error, 1e-7);
}

TEST_F(MpiRanks, GoToWhatRunsUnderMpirunAloneAndToJobs) {
  const auto path =
      add_plan("{mpi_ranks: 3, threads: 2}",
               "[fem.p1, {method: fem.p2, set: {processes: 5}}, {method: springs.uniform, label: springs}]");
  const Plan plan = read_plan(path, fixture_.registry());
  const std::vector<Case> cases = build_cases(plan, fixture_.registry());
  std::vector<int> ranks;
  ranks.reserve(cases.size());
  for (const Case& c : cases)
    ranks.push_back(count_ranks(
        fixture_.registry().find(plan.contestants[c.contestant].method)->method->options, c.options));
  EXPECT_THAT(ranks, testing::ElementsAre(3, 5, 1));
  EXPECT_EQ(most_ranks_of(plan, cases, fixture_.registry()), 5);
  const auto folder = fixture_.folder() / "jobs";
  write_campaign({plan.file, {}, {}, plan.run.threads, 5}, folder);
  EXPECT_EQ(json::parse(test::bytes_of(folder / "campaign.json")).at("processors"), 10);
}

TEST_F(MpiRanks, NonsenseIsRefused) {
  const auto refusal = [&](const std::string& run, const std::string& contestants) {
    return fixture_.error_of_plan(add_plan(run, contestants));
  };
  EXPECT_THAT(refusal("{mpi_ranks: 0}", "[fem.p1]"), HasSubstr("plan.yaml:7: mpi_ranks"));
  EXPECT_THAT(refusal("{mpi_ranks: 65}", "[fem.p1]"), HasSubstr("mpi_ranks"));
  EXPECT_THAT(refusal("{mpi_ranks: two}", "[fem.p1]"), HasSubstr("plan.yaml:7: mpi_ranks"));
  const auto nobody = fixture_.add_plan("[{method: palpate.hierarchical, stop: {fusions: 1}}]",
                                        "run: {mpi_ranks: 2}\n", "nobody");
  EXPECT_THAT(fixture_.error_of_plan(nobody), HasSubstr("no method of the plan can run under mpirun"));
}

}  // namespace
}  // namespace palpate::experiments
