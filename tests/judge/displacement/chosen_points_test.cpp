// Errors at some of a mesh's vertices alone: closed forms, the whole body as a special case, broken answers.
#include "core/judge/displacement/chosen_points.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/judge/displacement/displacement.h"
#include "core/judge/displacement/reference_estimate.h"
#include "core/mesh/shapes/shapes.h"

namespace palpate::judge {
namespace {

using Field = std::vector<Vec3>;

class ChosenPointsTest : public ::testing::Test {
 protected:
  Field random_field(double scale) {
    Field field(mesh_.points.size());
    for (Vec3& u : field)
      u = scale * Vec3{random_.uniform() - 0.5, random_.uniform() - 0.4, random_.uniform() - 0.6};
    return field;
  }

  ChosenPoints all() const {
    ChosenPoints chosen{std::vector<std::size_t>(mesh_.points.size()),
                        volume_shares(mesh_, mesh_.points.size())};
    std::iota(chosen.vertex.begin(), chosen.vertex.end(), std::size_t{0});
    return chosen;
  }

  TetMesh mesh_ = build_kuhn_cube(3, 0.2, 1);
  SplitMix64 random_{5};
};

TEST_F(ChosenPointsTest, OfAllVerticesByTheirVolumeItIsTheErrorOfTheWholeBody) {
  const Field truth = random_field(2.0);
  const Field answer = random_field(1.0);
  const ChosenError there = compare_chosen(mesh_, answer, truth, all());
  const DisplacementError whole = compare_displacement(mesh_, answer, truth, 1.5, 1.0);
  EXPECT_NEAR(there.relative_l2, whole.relative_l2, 1e-13);
  EXPECT_NEAR(there.relative_deformation, whole.relative_deformation, 1e-13);
  EXPECT_EQ(there.relative_max, whole.relative_max);
}

TEST_F(ChosenPointsTest, WhatHappensElsewhereDoesNotCount) {
  const Field truth = random_field(2.0);
  Field answer = truth;
  const ChosenPoints chosen{{4, 7}, {1.0, 3.0}};
  for (std::size_t v = 0; v < answer.size(); ++v) {
    if (v != 4 && v != 7) answer[v] = answer[v] + Vec3{1.0, -2.0, 0.5};
  }
  EXPECT_EQ(compare_chosen(mesh_, answer, truth, chosen).relative_l2, 0.0);
  EXPECT_EQ(compare_chosen(mesh_, answer, truth, chosen).relative_max, 0.0);
  answer[7] = 1.1 * truth[7];
  const double size = length_sq(truth[4]) + 3.0 * length_sq(truth[7]);
  EXPECT_NEAR(compare_chosen(mesh_, answer, truth, chosen).relative_l2,
              0.1 * std::sqrt(3.0 * length_sq(truth[7]) / size), 1e-14);
}

/// Rows are turned with the body and moved: of a strain plus a rigid motion the strain alone is left.
TEST_F(ChosenPointsTest, ARigidMotionOfTheWholeBodyIsTakenOff) {
  Field strain(mesh_.points.size());
  Field moved(mesh_.points.size());
  for (std::size_t v = 0; v < strain.size(); ++v) {
    const Vec3& p = mesh_.points[v];
    strain[v] = {0.1 * p.x, -0.03 * p.y, 0.02 * p.z};
    moved[v] = strain[v] + Vec3{3.0, -1.0, 2.0} + cross({0.5, 0.2, -0.7}, p);
  }
  const ChosenPoints chosen{{0, 9, 20}, {1.0, 1.0, 1.0}};
  EXPECT_NEAR(measure_chosen(mesh_, moved, chosen).deformation,
              measure_chosen(mesh_, strain, chosen).deformation, 1e-14);
  EXPECT_NEAR(compare_chosen(mesh_, moved, strain, chosen).relative_deformation, 0.0, 1e-12);
  EXPECT_GT(compare_chosen(mesh_, moved, strain, chosen).relative_l2, 1.0);
}

TEST_F(ChosenPointsTest, APlaceThatIsStillHasNoRelativeError) {
  Field truth = random_field(1.0);
  truth[5] = {};
  EXPECT_THROW(compare_chosen(mesh_, truth, truth, {{5}, {1.0}}), InputError);
  Field broken = random_field(1.0);
  broken[2].y = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(compare_chosen(mesh_, broken, truth, all()), InputError);
  EXPECT_THROW(measure_chosen(mesh_, truth, {}), ContractError);
  EXPECT_THROW(measure_chosen(mesh_, truth, {{mesh_.points.size()}, {1.0}}), ContractError);
  EXPECT_THROW(measure_chosen(mesh_, truth, {{1}, {0.0}}), ContractError);
}

/// Levels truth + h^p shape: what the reference is said to be off by at the chosen points is no less than
/// what it is off by, whatever is chosen and whatever the order.
TEST_F(ChosenPointsTest, TheReferencesOwnErrorThereIsABound) {
  const Field truth = random_field(2.0);
  for (const double order : {0.6, 1.0, 1.7, 2.5}) {
    for (std::size_t count = 1; count <= 3; ++count) {
      const Field shape = random_field(0.05);
      std::vector<Field> levels;
      for (std::size_t k = 0; k < count; ++k) {
        levels.push_back(truth);
        for (std::size_t v = 0; v < truth.size(); ++v)
          levels.back()[v] = truth[v] + std::exp2(-static_cast<double>(k) * order) * shape[v];
      }
      const ChosenPoints chosen{{3, 11, 30}, {1.0, 2.0, 0.5}};
      const ReferenceEstimate found = estimate_reference(mesh_, levels, 1.5, 1.0, {std::nullopt, chosen});
      ASSERT_EQ(found.error.chosen_l2.has_value(), count > 1) << count;
      if (count == 1) continue;
      const ChosenError off = compare_chosen(mesh_, truth, found.field, chosen);
      EXPECT_GE(*found.error.chosen_l2 * (1.0 + 1e-9), off.relative_l2) << order;
      EXPECT_GE(*found.error.chosen_deformation * (1.0 + 1e-9), off.relative_deformation) << order;
      EXPECT_GE(*found.error.chosen_max * (1.0 + 1e-9), off.relative_max) << order;
    }
  }
  EXPECT_FALSE(
      estimate_reference(mesh_, std::vector<Field>{truth, random_field(2.0)}, 1.5, 1.0).error.chosen_l2);
}

}  // namespace
}  // namespace palpate::judge
