#include "experiments/campaign/campaign.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "core/base/error.h"
#include "experiments/files/plain_file.h"
#include "tests/support/experiment_fixture.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using test::run_program;
using testing::HasSubstr;

/// A plan of two contestants over ten meshes, one repeat and a warm-up each, in a run's bounds of 10 and 20
/// s.
Plan make_campaign_plan(bool is_timed) {
  Plan plan;
  plan.contestants.resize(2);
  plan.run.warmup = 1;
  plan.run.timed = is_timed;
  plan.run.timeout_s = 10.0;
  plan.run.judge_timeout_s = 20.0;
  plan.run.memory_mib = 2000;
  return plan;
}

std::vector<Case> make_campaign_cases() {
  std::vector<Case> cases;
  for (std::size_t i = 0; i < 20; ++i) {
    Case c;
    c.id = "mesh" + std::to_string(i / 2) + "/" + std::to_string(i % 2);
    c.subject = i / 2;
    c.contestant = i % 2;
    cases.push_back(c);
  }
  return cases;
}

TEST(SplitCampaign, ShortCasesShareAJobOfAboutTheTimeAskedFor) {
  const std::vector<Case> cases = make_campaign_cases();
  const auto parts = split_campaign(make_campaign_plan(false), cases, {}, {100.0, 5.0});
  ASSERT_EQ(parts.size(), 2U);  // 20 cases, two repeats of 5 s each: 200 s
  std::set<std::string> all;
  for (const CampaignPart& part : parts) {
    EXPECT_EQ(part.cases.size(), 10U);
    EXPECT_DOUBLE_EQ(part.seconds, 100.0);
    EXPECT_EQ(part.minutes, 17U) << "600 s and four times 100, in minutes";
    EXPECT_EQ(part.memory_mib, 3024U);
    EXPECT_FALSE(part.is_timed);
    all.insert(part.cases.begin(), part.cases.end());
  }
  EXPECT_EQ(all.size(), 20U);
  EXPECT_EQ(parts[1].name, "0001");
}

TEST(SplitCampaign, TimedCasesOfOneMeshStayTogetherAndCostsComeFromRecords) {
  const std::map<std::string, CaseCost> costs{{"mesh3/1", {400.0, 4000.0}}};
  const auto parts = split_campaign(make_campaign_plan(true), make_campaign_cases(), costs, {1.0, 1.0});
  ASSERT_EQ(parts.size(), 10U);
  for (const CampaignPart& part : parts) {
    ASSERT_EQ(part.cases.size(), 2U);
    EXPECT_EQ(part.cases[0].substr(0, 5), part.cases[1].substr(0, 5));
    EXPECT_TRUE(part.is_timed);
  }
  EXPECT_DOUBLE_EQ(parts[3].seconds, 802.0);
  EXPECT_EQ(parts[3].minutes, 12U) << "no more than its time-outs add up to: 2 x 2 x 30 s, and 600 s";
  EXPECT_EQ(parts[3].memory_mib, 6024U);
}

TEST(RequestEnds, AskForWhatThePlanNeedsAndRecordsTell) {
  Plan plan = make_campaign_plan(false);
  plan.meshes.resize(10);
  const std::vector<Case> cases = make_campaign_cases();
  const auto parts = split_campaign(plan, cases, {}, {100.0, 5.0});
  const CampaignEnds plain = request_ends(plan, cases, {}, parts);
  EXPECT_EQ(plain.prepare.minutes, 20U) << "ten minutes, and one a mesh";
  EXPECT_EQ(plain.prepare.memory_mib, 3024U);
  EXPECT_EQ(plain.gather.minutes, 20U + 17U + 11U) << "inputs, a part, and what it does itself";
  EXPECT_EQ(plain.gather.memory_mib, 3024U);
  plan.reference.emplace();
  const CampaignEnds solved = request_ends(plan, cases, {}, parts);
  EXPECT_EQ(solved.prepare.minutes, 1440U) << "a day: nobody knows";
  EXPECT_EQ(solved.prepare.memory_mib, 8192U);
  const std::map<std::string, CaseCost> costs{{"mesh3/1", {4e5, 4000.0}}, {"mesh3/reference", {900.0, 0.0}}};
  EXPECT_EQ(request_ends(plan, cases, costs, parts).prepare.minutes, 80U) << "four times 15 minutes more";
  plan.run.repeats = 1'000'000;
  const CampaignEnds many = request_ends(plan, cases, {}, parts);
  EXPECT_GT(many.gather.memory_mib, 20'000U);
  EXPECT_GT(many.gather.minutes, solved.prepare.minutes + 200U);
}

TEST(WorkflowCommand, WritesWhatSnakemakeReadsAndNothingIntoAFolderInUse) {
  const test::ExperimentFixture fixture;
  const std::string out = (fixture.folder() / "jobs").string();
  const auto result = run_program({"workflow", "ci", "-o", out, "--job-seconds", "30"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const json campaign = json::parse(*read_bytes(out + "/campaign.json"));
  EXPECT_EQ(campaign.at("schema"), "palpate/campaign/1");
  for (const char* end : {"prepare", "gather"}) {
    EXPECT_GE(campaign.at(end).at("minutes"), 10) << end;
    EXPECT_GE(campaign.at(end).at("memory_mib"), 1024) << end;
  }
  const std::string rules = *read_bytes(out + "/Snakefile");
  const auto count = [&rules](const std::string& words) {
    std::size_t found = 0;
    for (std::size_t at = 0; (at = rules.find(words, at)) != std::string::npos; ++at) ++found;
    return found;
  };
  EXPECT_EQ(count("    retries: 2\n"), 3U) << "a node may be lost at any time";
  EXPECT_EQ(count("mem_mb="), 3U);
  EXPECT_EQ(count("mem_mb=memory_of("), 3U);
  std::size_t cases = 0;
  for (const json& part : campaign.at("parts")) cases += part.at("cases").get<std::size_t>();
  EXPECT_THAT(result.out, HasSubstr(std::to_string(cases) + " cases in " +
                                    std::to_string(campaign.at("parts").size()) + " parts"));
  for (const char* file : {"Snakefile", "slurm/config.yaml", "slurm/status.py", "cases/0000.txt"}) {
    EXPECT_TRUE(std::filesystem::is_regular_file(out + "/" + file)) << file;
  }
  const auto again = run_program({"workflow", "ci", "-o", out});
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_THAT(again.error, HasSubstr("expected an empty folder for the workflow, found other files"));
  EXPECT_THAT(run_program({"workflow", "ci", "-o", out + "2", "--costs", out}).error, HasSubstr("jobs"));
}

}  // namespace
}  // namespace palpate::experiments
