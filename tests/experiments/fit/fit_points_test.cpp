// The choice of a fit, from records that are made up.
#include "experiments/fit/fit_points.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

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
