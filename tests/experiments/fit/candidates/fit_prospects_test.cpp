// What a fit checks next, from points that are made up.
#include "experiments/fit/candidates/fit_prospects.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace palpate::experiments {
namespace {

/// What a fit knows of one model: shares of a simplifier with their errors on the scene and their costs.
class FitProspects : public testing::Test {
 protected:
  FitProspects() {
    require_.measure = "displacement_deformation";
    require_.at_most = 0.05;
    candidates_.simplifiers = {{"refined", "palpate.refined", {0.3, 0.5, 0.9}, std::nullopt}};
  }

  static FitPoint point(double ratio, const std::vector<double>& errors, double cost) {
    FitPoint made;
    made.candidate.model = {"a", "smoothed.edge_node", nlohmann::json::object(), {}};
    made.candidate.simplifier = "none";
    if (ratio > 0.0) {
      made.candidate.simplifier = "refined";
      made.candidate.ratio = ratio;
    }
    made.error = errors;
    made.own_error.assign(errors.size(), 0.0);
    made.cost_s = {cost};
    return made;
  }

  /// Shares and costs of what is worth a check, in that order; unlikely ones have a minus.
  std::vector<std::pair<double, double>> prospects(double most_cost) const {
    std::vector<std::pair<double, double>> shares;
    for (const FitProspect& each : list_prospects(searched_, checked_, candidates_, require_, most_cost)) {
      const double share = each.candidate.removed();
      shares.emplace_back(each.is_likely ? share : -share, std::round(1e9 * each.cost_s) / 1e9);
    }
    return shares;
  }

  using Shares = std::vector<std::pair<double, double>>;
  SceneRequirement require_;
  FitCandidates candidates_;
  std::vector<FitPoint> searched_;
  std::vector<FitPoint> checked_;
};

constexpr double kAnyCost = std::numeric_limits<double>::infinity();

TEST_F(FitProspects, BetweenAShareThatMeetsItAndTheNextTheMiddleIsWorthACheck) {
  searched_ = {point(0.0, {0.01}, 10.0), point(0.3, {0.04}, 6.0), point(0.5, {0.06}, 4.0),
               point(0.9, {0.2}, 1.0)};
  EXPECT_EQ(prospects(kAnyCost), (Shares{{0.3, 6.0}, {0.4, 5.0}, {0.0, 10.0}}));
  EXPECT_EQ(prospects(6.0), (Shares{{0.4, 5.0}}));
  checked_ = {point(0.3, {0.04, 0.045}, 6.0), point(0.4, {0.048, 0.06}, 5.0)};
  EXPECT_EQ(prospects(0.97 * 6.0), (Shares{{0.35, 5.5}}));
  checked_.push_back(point(0.35, {0.041, 0.049}, 5.4));
  EXPECT_EQ(prospects(0.97 * 5.4), (Shares{{0.375, 5.2}}));
  checked_.push_back(point(0.375, {0.044, 0.049}, 5.3));
  EXPECT_TRUE(prospects(kAnyCost).size() == 1U) << "the mesh as it is; 0.387 is too near to both";
}

/// A time of a busy machine leaves nothing out: fewer tetrahedra are expected to cost no more.
TEST_F(FitProspects, NoShareIsExpectedToCostMoreThanOneWithMoreTetrahedra) {
  searched_ = {point(0.0, {0.01}, 10.0), point(0.3, {0.02}, 6.0), point(0.5, {0.03}, 60.0),
               point(0.9, {0.2}, 2.0)};
  EXPECT_EQ(prospects(kAnyCost), (Shares{{0.7, 4.0}, {0.3, 6.0}, {0.5, 6.0}, {0.0, 10.0}}));
}

/// What is verified is lowered as they are: else all shares of a table that costs the same on whatever mesh
/// seem worth a check, since the least of their noisy times is below nine tenths of its own.
TEST_F(FitProspects, WhatIsVerifiedIsComparedByTheSameLowering) {
  searched_ = {point(0.0, {0.01}, 40.0), point(0.3, {0.02}, 47.0), point(0.5, {0.03}, 50.0),
               point(0.9, {0.049}, 44.0)};
  checked_ = {point(0.5, {0.03, 0.03}, 50.0)};
  EXPECT_FALSE(prospects(0.9 * 50.0).empty());
  EXPECT_EQ(lowered_cost(checked_[0], searched_, checked_), 40.0);
  EXPECT_TRUE(prospects(0.9 * 40.0).empty());
  checked_.push_back(point(0.0, {0.01, 0.01}, 48.0));
  EXPECT_EQ(lowered_cost(checked_[0], searched_, checked_), 47.0) << "a check says more than the search";
  EXPECT_EQ(lowered_cost(checked_[1], searched_, checked_), 48.0) << "fewer tetrahedra lower nothing";
}

/// What costs the same on whatever mesh stands by its error too: else coarse ones are refused one by one,
/// until the time is up. By its error alone one that is cheaper than its one noisy time says would be left
/// out.
TEST_F(FitProspects, OfWhatCostsTheSameTheMostAccurateAndTheCheapestComeByTurns) {
  searched_ = {point(0.0, {0.01}, 7.4), point(0.3, {0.03}, 7.0), point(0.5, {0.04}, 6.6)};
  EXPECT_EQ(prospects(kAnyCost), (Shares{{0.0, 7.4}, {0.75, 6.1}, {0.3, 7.0}, {0.5, 6.6}}));
}

/// Errors need not grow with the share: between two that miss the tolerance by little one may meet it.
TEST_F(FitProspects, BetweenTwoNearMissesTheMiddleIsLookedAtLast) {
  searched_ = {point(0.0, {0.053}, 10.0), point(0.3, {0.049}, 6.0), point(0.5, {0.08}, 4.0),
               point(0.9, {0.2}, 1.0)};
  checked_ = {point(0.3, {0.049, 0.051}, 6.0)};
  EXPECT_EQ(prospects(kAnyCost), (Shares{{-0.4, 5.0}, {-0.15, 8.0}}));
  checked_ = {point(0.3, {0.049, 0.06}, 6.0)};
  EXPECT_EQ(prospects(kAnyCost), (Shares{})) << "the mesh as it is is expected at 0.065";
}

/// The next share up of the mesh as it is belongs to every simplifier; above the greatest half of the rest
/// is.
TEST_F(FitProspects, TheMeshAsItIsAndTheGreatestShareHaveNeighboursToo) {
  candidates_.simplifiers.push_back({"surface", "palpate.surface", {0.9}, std::nullopt});
  searched_ = {point(0.0, {0.01}, 10.0), point(0.3, {0.06}, 6.0)};
  const auto found = list_prospects(searched_, checked_, candidates_, require_, 10.0);
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].candidate.name(), "a, surface -50%");
  EXPECT_EQ(found[1].candidate.name(), "a, refined -15%");
  searched_ = {point(0.9, {0.01}, 2.0)};
  EXPECT_EQ(prospects(2.0), (Shares{{0.95, 1.0}}));
  candidates_.simplifiers[0].grade = GradeWish{};
  EXPECT_TRUE(prospects(2.0).empty()) << "a graded mesh has sizes for its share alone";
}

/// A choice that does not hold on further loads is over the tolerance: what is dearer is worth a check then.
TEST_F(FitProspects, WhatARefusedChoiceLeavesIsLookedAtAgain) {
  searched_ = {point(0.0, {0.01}, 10.0), point(0.3, {0.04}, 6.0), point(0.32, {0.06}, 5.9)};
  checked_ = {point(0.3, {0.04, 0.045}, 6.0)};
  EXPECT_TRUE(prospects(0.97 * 6.0).empty());
  checked_[0] = point(0.3, {0.04, 0.045, 0.052}, 6.0);
  EXPECT_TRUE(choose_cheapest(checked_, require_).empty());
  EXPECT_EQ(prospects(kAnyCost), (Shares{{0.0, 10.0}, {0.15, 8.0}}));
}

/// What a model was worse by on other loads makes its other shares unlikely: they are looked at last, and not
/// left out.
TEST_F(FitProspects, WhatIsExpectedToMissOnOtherLoadsComesLast) {
  searched_ = {point(0.0, {0.01}, 10.0), point(0.3, {0.04}, 6.0), point(0.5, {0.045}, 4.0)};
  checked_ = {point(0.5, {0.045, 0.06}, 4.0)};
  EXPECT_NEAR(growth_on_loads(searched_, checked_, "a"), 4.0 / 3.0, 1e-12);
  EXPECT_EQ(growth_on_loads(searched_, checked_, "b"), 1.0);
  EXPECT_EQ(prospects(kAnyCost), (Shares{{0.0, 10.0}, {-0.3, 6.0}, {-0.4, 5.0}}));
}

TEST_F(FitProspects, UntilOneIsVerifiedHalfOfARoundAreOfTheSearch) {
  std::vector<FitProspect> found;
  for (const double ratio : {0.4, 0.6, 0.7, 0.3, 0.5, 0.1}) {
    const bool is_between = ratio == 0.4 || ratio == 0.6 || ratio == 0.7;
    found.push_back({point(ratio, {0.01}, 1.0).candidate, 1.0, 0.01, true, is_between});
  }
  const auto shares = [&](bool has_choice) {
    std::vector<double> ratios;
    for (const FitCandidate& each : take_prospects(found, 4, has_choice)) ratios.push_back(each.removed());
    return ratios;
  };
  EXPECT_EQ(shares(false), (std::vector<double>{0.3, 0.5, 0.4, 0.6}));
  EXPECT_EQ(shares(true), (std::vector<double>{0.4, 0.6, 0.7, 0.3}));
}

}  // namespace
}  // namespace palpate::experiments
