// The choice of a fit, from records that are made up.
#include "experiments/fit/candidates/fit_points.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>

#include "core/base/random.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using testing::HasSubstr;

FitCandidate candidate_of(const std::string& label) {
  return {{label, "smoothed.edge_node", json::object(), {}}, "none", std::nullopt};
}

json answer(const std::string& label, const std::string& scene, double error, double kernel_s) {
  return {{"label", label + "-none"},
          {"case", scene + "/" + label},
          {"outcome", "accepted"},
          {"repeat", 0},
          {"warmup", false},
          {"kernel_s", kernel_s},
          {"peak_rss_bytes", 1000},
          {"mesh", {{"name", scene}, {"vertices", 10}, {"tets", 20}}},
          {"scene", {{"name", scene}}},
          {"report", json::object()},
          {"judge", {{"displacement_deformation", error}}}};
}

json reference_of(const std::string& scene, const json& own) {
  return {{"label", "reference"},
          {"scene", {{"name", scene}}},
          {"outcome", "accepted"},
          {"judge", {{"reference_error_deformation", own}}}};
}

/// A point of model `label` with the worst errors on the scene and on other loads; of more than four loads
/// the last two confirm it.
FitPoint point_of(const std::string& label, const std::vector<double>& errors) {
  FitPoint made;
  made.candidate = candidate_of(label);
  made.cost_s = {1.0};
  made.error = errors;
  made.own_error.assign(errors.size(), 0.0);
  if (errors.size() > 4) made.confirmed_on = {4, 5};
  return made;
}

class FitChoice : public testing::Test {
 protected:
  FitChoice() {
    require_.measure = "displacement_deformation";
    require_.at_most = 0.05;
    plan_.scenes.resize(1);
    for (const char* label : {"a", "b", "c"}) plan_.candidates.push_back(candidate_of(label));
  }

  std::vector<FitPoint> read(const std::vector<json>& records) const {
    return read_fit_points(records, plan_, require_);
  }

  FitPlan plan_;
  SceneRequirement require_;
};

/// Of loads that it was run on the largest error is known; what others like them reach is estimated, and
/// holds once a point is confirmed.
TEST_F(FitChoice, AConfirmedPointIsHeldByWhatOtherLoadsAreEstimatedToReach) {
  FitPoint point;
  point.cost_s = {1.0};
  point.error = {0.036, 0.034, 0.02};
  point.own_error = {0.002, 0.001, 0.002};
  EXPECT_DOUBLE_EQ(point.worst_error(), 0.038);
  const double range = 0.038 - 0.022;
  EXPECT_NEAR(point.estimated_error(), 0.038 + (std::sqrt(10.0) - 1.0) * range, 1e-15);
  require_.at_most = 0.072;
  EXPECT_EQ(why_not(point, require_), "");
  point.confirmed_on = {4, 5};
  EXPECT_THAT(why_not(point, require_),
              HasSubstr("estimated to reach 7.26% on loads like these (up to 3.8% seen)"));
  require_.at_most = 0.073;
  EXPECT_EQ(why_not(point, require_), "");
  point.confirmed_on = {4, 7};
  point.looked_at = 12;  // ten of them are better than these two
  EXPECT_NEAR(point.estimated_error(), 0.038 + (std::pow(10.0, 1.0 / 12.0) - 1.0) * range, 1e-15);
  point.error = {0.04};
  point.own_error = {0.002};
  EXPECT_DOUBLE_EQ(point.estimated_error(), point.worst_error()) << "one load says nothing of others";
  point.own_error = {std::numeric_limits<double>::infinity()};
  EXPECT_FALSE(why_not(point, require_).empty());
}

/// What further loads refused of one model they are spared to say again of those that are no better on the
/// first.
TEST_F(FitChoice, NoBetterThanARefusedOneOfItsModelIsNotChosen) {
  const std::vector<FitPoint> checked = {
      point_of("a", {0.03, 0.04, 0.03, 0.03, 0.03, 0.06}), point_of("a", {0.04, 0.03, 0.02, 0.04}),
      point_of("a", {0.03, 0.039, 0.03, 0.03}), point_of("b", {0.04, 0.04, 0.04, 0.04}),
      point_of("a", {0.04, 0.041, 0.041, 0.04, 0.04, 0.04})};
  const auto why = [&](std::size_t k) { return why_not_chosen(checked[k], checked, require_); };
  EXPECT_THAT(why(0), HasSubstr("error up to 6%"));
  EXPECT_EQ(why(1), "no better than a, the mesh as it is, which further loads refused");
  EXPECT_EQ(why(2), "") << "it is better";
  EXPECT_EQ(why(3), "") << "it is another model";
  EXPECT_EQ(why(4), "") << "it was confirmed";
  const std::vector<FitPoint> first(checked.begin(), checked.begin() + 2);
  EXPECT_EQ(find_nearest(first, require_), &first[0])
      << "the other one is no better, though it was run on fewer";
}

/// Further loads add more to the errors on one simplifier's meshes than on another's, but not much more.
TEST_F(FitChoice, ARefusedOneSpeaksForOtherSimplifiersWhereTheyAreClearlyOver) {
  const auto share = [](const std::string& simplifier, double ratio, const std::vector<double>& errors) {
    FitPoint made = point_of("a", errors);
    made.candidate.simplifier = simplifier;
    made.candidate.ratio = ratio;
    if (made.is_confirmed()) made.looked_at = 100'000;  // the estimate is the largest seen
    return made;
  };
  const std::vector<FitPoint> checked = {share("refined", 0.5, {0.046, 0.04, 0.04, 0.04, 0.04, 0.0505}),
                                         share("refined", 0.4, {0.0462, 0.04, 0.04, 0.04}),
                                         share("surface", 0.5, {0.0462, 0.04, 0.04, 0.04}),
                                         share("surface", 0.6, {0.049, 0.04, 0.04, 0.04})};
  const auto why = [&](std::size_t k) { return why_not_chosen(checked[k], checked, require_); };
  EXPECT_THAT(why(1), HasSubstr("no better than")) << "another share of the same simplifier";
  EXPECT_EQ(why(2), "") << "5.07% expected of 5%";
  EXPECT_THAT(why(3), HasSubstr("no better than a, refined -50%")) << "5.38% expected of 5%";
}

/// Where no time is left to confirm, times that differ by noise do not decide.
TEST_F(FitChoice, OfWhatCostsTheSameTheLeastOffIsTheSafest) {
  std::vector<FitPoint> checked = {point_of("a", {0.048, 0.04}), point_of("b", {0.02, 0.03}),
                                   point_of("b", {0.01, 0.01}), point_of("c", {0.02, 0.06})};
  checked[1].cost_s = {1.2};
  checked[2].cost_s = {1.3};
  EXPECT_EQ(find_safest(checked[0], checked, require_), &checked[1]) << "at 1.3 times the cost it is dearer";
  EXPECT_EQ(find_safest(checked[2], checked, require_), &checked[2]);
  checked[1].failure = "crashed";
  EXPECT_EQ(find_safest(checked[0], checked, require_), &checked[0]);
}

/// Records stand in the order in which they were run, errors in that of the scenes.
TEST_F(FitChoice, ErrorsStandInTheOrderOfTheScenes) {
  plan_.scenes.resize(3);
  std::vector<json> records;
  for (const char* scene : {"scene_2", "scene_0", "scene_1"}) {
    const double number = scene[6] - '0';
    records.push_back(reference_of(scene, 0.001 * (number + 1.0)));
    records.push_back(answer("a", scene, 0.01 * (number + 1.0), 1.0));
  }
  const FitPoint point = read(records).front();
  EXPECT_THAT(point.error, testing::ElementsAre(0.01, 0.02, 0.03));
  EXPECT_THAT(point.own_error, testing::ElementsAre(0.001, 0.002, 0.003));
}

/// The bound of estimated_error: of errors spread evenly it lies above the greatest possible one nine times
/// in ten, whatever their number.
TEST_F(FitChoice, TheEstimateHoldsNineTimesInTen) {
  SplitMix64 random(16);
  for (const std::size_t loads : {2U, 6U, 16U}) {
    constexpr int kTries = 4000;
    int held = 0;
    for (int k = 0; k < kTries; ++k) {
      FitPoint point;
      for (std::size_t i = 0; i < loads; ++i) point.error.push_back(0.01 + 0.03 * random.uniform());
      point.own_error.assign(loads, 0.0);
      held += point.estimated_error() >= 0.04 ? 1 : 0;
    }
    EXPECT_NEAR(static_cast<double>(held) / kTries, 0.9, 0.02) << loads;
  }
}

TEST_F(FitChoice, ErrorsAreReadByTheScene) {
  plan_.scenes.resize(3);
  json refused = answer("a", "scene_1", 0.5, 1.0);
  refused["outcome"] = "rejected";
  const std::vector<json> records{answer("a", "scene_2", 0.02, 1.0), refused,
                                  answer("b", "scene_0", 0.7, 1.0)};
  const auto errors = read_errors(records, plan_, require_, candidate_of("a"));
  EXPECT_EQ(errors, (std::vector<std::optional<double>>{std::nullopt, std::nullopt, 0.02}));
}

/// Points with these costs, and with these times of a back-substitution (0: none).
std::vector<FitPoint> points_with(const std::vector<double>& costs, const std::vector<double>& answers) {
  std::vector<FitPoint> points(costs.size());
  for (std::size_t k = 0; k < costs.size(); ++k) {
    points[k].cost_s = {costs[k]};
    if (answers[k] > 0.0) points[k].answer_s = answers[k];
  }
  return points;
}

/// Costs of what take_finalists takes, round by round until nothing is left.
std::vector<std::vector<double>> rounds_of(const std::vector<FitPoint>& points, std::size_t count) {
  std::vector<const FitPoint*> good;
  good.reserve(points.size());
  for (const FitPoint& point : points) good.push_back(&point);
  std::vector<std::vector<double>> rounds;
  while (!good.empty()) {
    rounds.emplace_back();
    for (const FitPoint* taken : take_finalists(good, count)) rounds.back().push_back(taken->cost());
  }
  return rounds;
}

TEST(FitFinalists, OneWithADearExplicitStepAndACheapSolveIsAmongThem) {
  using Rounds = std::vector<std::vector<double>>;
  EXPECT_EQ(rounds_of(points_with({1, 2, 3, 4, 5, 6}, {9, 8, 7, 6, 5, 4}), 3),
            (Rounds{{1, 2, 6}, {3, 4, 5}}));
  EXPECT_EQ(rounds_of(points_with({1, 2, 3, 4, 5}, {1, 8, 7, 6, 5}), 2), (Rounds{{1, 2}, {3, 5}, {4}}));
  EXPECT_EQ(rounds_of(points_with({1, 2, 3, 4}, {0, 0, 0, 0}), 2), (Rounds{{1, 2}, {3, 4}}));
  EXPECT_EQ(rounds_of(points_with({1, 2}, {2, 1}), 4), (Rounds{{1, 2}}));
  std::vector<const FitPoint*> none;
  EXPECT_TRUE(take_finalists(none, 4).empty());
}

/// Of modes one a round is looked at, and its motion needs room: the cheapest with half of the tolerance
/// left, else the most accurate.
TEST(FitFinalists, OneOfModesLeavesHalfOfTheToleranceToItsMotion) {
  std::vector<FitPoint> points = points_with({1, 2, 3, 4, 5}, {0, 0, 0, 0, 0});
  const std::vector<double> errors{0.045, 0.001, 0.02, 0.03, 0.001};
  std::vector<const FitPoint*> good;
  for (std::size_t k = 0; k < points.size(); ++k) {
    points[k].error = {errors[k]};
    points[k].own_error = {0.004};
    if (k != 1) points[k].candidate.model.method = "reduced.modal";
    good.push_back(&points[k]);
  }
  std::vector<double> taken;
  for (const FitPoint* found = nullptr; (found = take_modal_finalist(good, 0.05)) != nullptr;)
    taken.push_back(found->cost());
  EXPECT_EQ(taken, (std::vector<double>{3, 5, 4, 1}));
  EXPECT_EQ(good, (std::vector<const FitPoint*>{&points[1]}));
}

TEST_F(FitChoice, TheCheapestWithinTheToleranceIsTaken) {
  const auto points = read({reference_of("scene_0", 0.001), answer("a", "scene_0", 0.2, 0.1),
                            answer("b", "scene_0", 0.04, 0.3), answer("c", "scene_0", 0.01, 0.9)});
  const auto good = choose_cheapest(points, require_);
  ASSERT_EQ(good.size(), 2U);
  EXPECT_EQ(good[0]->candidate.model.label, "b");
  EXPECT_THAT(why_not(points[0], require_), HasSubstr("error up to 20.1%"));
}

TEST_F(FitChoice, TheReferencesOwnErrorCountsAgainstTheModel) {
  const auto points = read(
      {reference_of("scene_0", 0.02), answer("a", "scene_0", 0.04, 0.1), answer("b", "scene_0", 0.029, 0.3)});
  const auto good = choose_cheapest(points, require_);
  ASSERT_EQ(good.size(), 1U);
  EXPECT_EQ(good[0]->candidate.model.label, "b");
  EXPECT_EQ(points[2].failure, "not run");
}

TEST_F(FitChoice, AReferenceWithoutAnErrorProvesNothing) {
  const auto points = read({reference_of("scene_0", nullptr), answer("a", "scene_0", 0.001, 0.1)});
  EXPECT_TRUE(choose_cheapest(points, require_).empty());
  EXPECT_EQ(points[0].worst_error(), std::numeric_limits<double>::infinity());
}

TEST_F(FitChoice, TheWorstOfAllScenesDecides) {
  plan_.scenes.resize(2);
  const auto points =
      read({reference_of("scene_0", 0.0), reference_of("scene_1", 0.0), answer("a", "scene_0", 0.01, 0.1),
            answer("a", "scene_1", 0.06, 0.1), answer("b", "scene_0", 0.03, 0.2),
            answer("b", "scene_1", 0.04, 0.2), answer("c", "scene_0", 0.001, 0.01)});
  const auto good = choose_cheapest(points, require_);
  ASSERT_EQ(good.size(), 1U);
  EXPECT_EQ(good[0]->candidate.model.label, "b");
  EXPECT_EQ(points[2].failure, "not run on all scenes");
}

TEST_F(FitChoice, BudgetAndMemoryAreHeld) {
  require_.answer_s = 0.5;
  require_.memory_bytes = 999;
  const auto points = read({reference_of("scene_0", 0.0), answer("a", "scene_0", 0.01, 0.6)});
  EXPECT_THAT(why_not(points[0], require_),
              AllOf(HasSubstr("takes 600 ms of 500 ms"), HasSubstr("1000 bytes, over 999")));
}

TEST_F(FitChoice, WhereNothingDoesTheNearestIsNamed) {
  require_.answer_s = 0.1;
  const auto points = read({reference_of("scene_0", 0.0), answer("a", "scene_0", 0.2, 0.05),  // 4 times over
                            answer("b", "scene_0", 0.06, 0.2),                                // 1.2 x 2
                            answer("c", "scene_0", 0.01, 0.9)});                              // 9 times over
  EXPECT_TRUE(choose_cheapest(points, require_).empty());
  EXPECT_EQ(find_nearest(points, require_)->candidate.model.label, "b");
  EXPECT_EQ(find_nearest(read({}), require_), nullptr);
}

// The time was up after the search: of those that meet all of it on the scene the cheapest is the nearest.
TEST_F(FitChoice, OfPointsThatAreEquallyNearTheCheapestIsTaken) {
  const auto points = read({reference_of("scene_0", 0.0), answer("a", "scene_0", 0.01, 0.3),
                            answer("b", "scene_0", 0.02, 0.1), answer("c", "scene_0", 0.03, 0.2)});
  EXPECT_EQ(find_nearest(points, require_)->candidate.model.label, "b");
}

TEST_F(FitChoice, AFailureIsNoPoint) {
  json failed = answer("a", "scene_0", 0.01, 0.1);
  failed["outcome"] = "crashed";
  failed["message"] = "killed by signal 11";
  const auto points = read({reference_of("scene_0", 0.0), failed});
  EXPECT_EQ(points[0].failure, "crashed: killed by signal 11");
  EXPECT_TRUE(choose_cheapest(points, require_).empty());
}

}  // namespace
}  // namespace palpate::experiments
