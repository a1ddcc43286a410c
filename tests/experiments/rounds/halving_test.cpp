// What gets no more repeats, from times and errors that are given.
#include "experiments/rounds/halving.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/random.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::Eq;

using Halved = std::vector<std::optional<std::size_t>>;

HalvingFigures figures_of(double error, std::vector<double> times, double own = 0.0,
                          const std::string& group = "a") {
  return {group, {{"displacement_deformation", {error - own, error + own}}}, {{"first", std::move(times)}}};
}

Halved halved(const std::vector<HalvingFigures>& cases) {
  return find_halved(cases, std::vector<bool>(cases.size(), true));
}

TEST(Halving, WhatIsSurelySlowerAndNoBetterIsLeft) {
  EXPECT_THAT(halved({figures_of(0.1, {1, 2, 3}), figures_of(0.1, {4, 5, 6})}),
              ElementsAre(std::nullopt, Eq(0U)));
  // Their times meet, so nobody can tell.
  EXPECT_THAT(halved({figures_of(0.1, {1, 2, 4}), figures_of(0.1, {4, 5, 6})}),
              ElementsAre(std::nullopt, std::nullopt));
  // It is better: however dear, it stays.
  EXPECT_THAT(halved({figures_of(0.1, {1, 2, 3}), figures_of(0.09, {40, 50, 60})}),
              ElementsAre(std::nullopt, std::nullopt));
  // It is worse by less than the references leave open.
  EXPECT_THAT(halved({figures_of(0.1, {1, 2, 3}, 0.01), figures_of(0.11, {4, 5, 6}, 0.01)}),
              ElementsAre(std::nullopt, std::nullopt));
  EXPECT_THAT(halved({figures_of(0.1, {1, 2, 3}, 0.01), figures_of(0.13, {4, 5, 6}, 0.01)}),
              ElementsAre(std::nullopt, Eq(0U)));
}

TEST(Halving, OnlyTheDearerHalfIsLookedAt) {
  // All but the first are beaten; the two dearest go.
  EXPECT_THAT(
      halved({figures_of(0.1, {1}), figures_of(0.2, {2}), figures_of(0.2, {3}), figures_of(0.2, {4})}),
      ElementsAre(std::nullopt, std::nullopt, Eq(0U), Eq(0U)));
}

TEST(Halving, FamiliesAndScenesStandForThemselves) {
  EXPECT_THAT(halved({figures_of(0.1, {1}, 0, "a"), figures_of(0.5, {9}, 0, "b")}),
              ElementsAre(std::nullopt, std::nullopt));
}

TEST(Halving, ACaseThatMayBeOnOneFrontierStays) {
  HalvingFigures quick = figures_of(0.1, {1, 1, 1});
  HalvingFigures slow = figures_of(0.2, {5, 5, 5});
  quick.times_s["second"] = {7, 7, 7};
  slow.times_s["second"] = {6, 6, 6};
  EXPECT_THAT(halved({quick, slow}), ElementsAre(std::nullopt, std::nullopt)) << "it moves faster";
  slow.times_s["second"] = {8, 8, 8};
  EXPECT_THAT(halved({quick, slow}), ElementsAre(std::nullopt, Eq(0U)));
  quick.errors["pad_force"] = {0.3, 0.3};
  slow.errors["pad_force"] = {0.1, 0.1};
  EXPECT_THAT(halved({quick, slow}), ElementsAre(std::nullopt, std::nullopt)) << "its pad's force is better";
  slow.errors.erase("pad_force");
  slow.times_s["further"] = {1e-9};
  EXPECT_THAT(halved({quick, slow}), ElementsAre(std::nullopt, std::nullopt)) << "nobody else answers again";
}

TEST(Halving, WithoutFiguresNothingIsDecided) {
  EXPECT_THAT(halved({figures_of(0.1, {}), figures_of(0.2, {5})}), ElementsAre(std::nullopt, std::nullopt));
  HalvingFigures failed{"a", {}, {}};
  EXPECT_THAT(halved({figures_of(0.1, {1}), failed, figures_of(0.2, {5})}),
              ElementsAre(std::nullopt, std::nullopt, Eq(0U)));
  HalvingFigures unknown{
      "a", {{"displacement_deformation", {}}}, {{"first", {1.0}}}};  // its reference has no error
  EXPECT_THAT(halved({unknown, figures_of(0.2, {5})}), ElementsAre(std::nullopt, std::nullopt));
}

/// Whatever is left, the frontier of what stays is the frontier of all: each case that is left has one that
/// stays, or stayed longer, which is faster in all repeats and no worse.
TEST(Halving, TheFrontierStaysWhatItIs) {
  SplitMix64 random(11);
  for (int round = 0; round < 200; ++round) {
    std::vector<HalvingFigures> cases;
    for (int k = 0; k < 12; ++k) {
      const double mean = 1.0 + 9.0 * random.uniform();
      std::vector<double> times;
      times.reserve(3);
      for (int repeat = 0; repeat < 3; ++repeat) times.push_back(mean * (0.9 + 0.2 * random.uniform()));
      cases.push_back(figures_of(random.uniform(), times));
    }
    const Halved found = halved(cases);
    for (std::size_t i = 0; i < cases.size(); ++i) {
      if (!found[i]) continue;
      std::size_t by = *found[i];
      while (found[by]) by = *found[by];  // it ends: each is faster than the one before
      EXPECT_LE(cases[by].errors.at("displacement_deformation").low,
                cases[i].errors.at("displacement_deformation").low);
      EXPECT_LT(cases[by].times_s.at("first")[0], cases[i].times_s.at("first")[0]);
    }
  }
}

TEST(Halving, RungsDouble) {
  std::vector<int> rungs;
  for (int n = 0; n <= 30; ++n) {
    if (is_rung(n, 3)) rungs.push_back(n);
  }
  EXPECT_THAT(rungs, ElementsAre(3, 6, 12, 24));
}

TEST(HalvingRecordsTest, FiguresAreThoseOfTheFirstRepeats) {
  Plan plan;
  plan.contestants.resize(2);
  plan.contestants[0].label = "a";
  plan.contestants[1].label = "b";
  plan.families = {{"a", "ours"}, {"b", "ours"}};
  std::vector<Case> cases(2);
  cases[1].contestant = 1;
  HalvingRecords records(plan, cases);
  records.add_reference(json::parse(R"({"label": "reference", "scene": {"name": "s"}, "sweep": {},
                                        "judge": {"reference_error_deformation": 0.01}})"));
  for (int repeat = 0; repeat < 5; ++repeat) {
    json record = json::parse(R"({"outcome": "accepted", "scene": {"name": "s"}, "sweep": {"simplify": "x"},
      "judge": {"displacement_deformation": 0.2, "displacement_l2": 0.3}, "solved_on": {"simplify_s": 1.0},
      "report": {"answer_s": 0.5}})");
    record["repeat"] = repeat;
    record["warmup"] = repeat == 0;
    record["kernel_s"] = 0.1 * repeat;
    records.add(0, record);
  }
  const std::vector<HalvingFigures> found = records.figures(1, 3);
  EXPECT_EQ(found[0].group, found[1].group);
  EXPECT_EQ(found[0].times_s.at("first"), (std::vector<double>{1.1, 1.2, 1.0 + 0.1 * 3}));
  EXPECT_EQ(found[0].times_s.at("further").size(), 3U);
  EXPECT_DOUBLE_EQ(found[0].errors.at("displacement_deformation").low, 0.19);
  EXPECT_DOUBLE_EQ(found[0].errors.at("displacement_deformation").high, 0.21);
  EXPECT_EQ(found[0].errors.at("displacement_l2").low, 0.0) << "the reference's own error is not known";
  EXPECT_TRUE(found[1].times_s.empty());
}

}  // namespace
}  // namespace palpate::experiments
