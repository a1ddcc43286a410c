// Which part of a body may be held at rest, decided from figures that are given; when it wakes.
#include "experiments/trials/frozen_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "core/base/error.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/scratch_folder.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::HasSubstr;

TEST(FindStill, WhatMovesByNoMoreIsStill) {
  const std::vector<Vec3> u{{0, 0, 0}, {0.3, 0.4, 0}, {0, 0.5000001, 0}, {0, 0, -0.1}};
  EXPECT_THAT(find_still(u, 0.5), ElementsAre(0, 1, 3));
  EXPECT_DOUBLE_EQ(rms_displacement(std::vector<Vec3>{{3, 0, 0}, {0, 4, 0}}), std::sqrt(12.5));
  const TetMesh cube = build_kuhn_cube(1, 0.0, 0);  // six tets around a diagonal
  std::vector<Index> all{0, 1, 2, 3, 4, 5, 6, 7};
  EXPECT_EQ(count_still_tets(cube, all), 6U);
  all.erase(all.begin() + static_cast<std::ptrdiff_t>(cube.tets[0][0]));
  EXPECT_LT(count_still_tets(cube, all), 6U);
  EXPECT_EQ(count_still_tets(cube, {}), 0U);
}

TEST(WhyNotFrozen, TooLittleTooFarOffOrTooDear) {
  const FrozenTry good{0.5, 100, 50, 0.02, 0.01, 2.0, 1.0, 0.1, ""};
  EXPECT_EQ(why_not_frozen(good, 1000, 0.03), "");
  EXPECT_THAT(why_not_frozen(good, 1001, 0.03), HasSubstr("only 50 of 1001 tetrahedra"));
  EXPECT_THAT(why_not_frozen(good, 1000, 0.0299), HasSubstr("error up to 3% of"));
  FrozenTry dear = good;
  dear.cost_s = 2.0;
  EXPECT_THAT(why_not_frozen(dear, 1000, 0.03), HasSubstr("takes 2 s, the whole model 2 s"));
  FrozenTry lost = good;
  lost.motion_error.reset();
  EXPECT_NE(why_not_frozen(lost, 1000, 0.03), "");
  lost.motion_error = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(why_not_frozen(lost, 1000, 0.03), "") << "no number is no proof";
}

TEST(WhyItWakes, WhereMoreActsThanWasVerified) {
  const test::ScratchFolder folder;
  const auto file = folder.add("frozen.json", describe_frozen({1, 2}, 9, 0.5).dump());
  EXPECT_EQ(why_it_wakes(file, {{"frozen_force_most_n", 0.5}}), "");
  EXPECT_THAT(why_it_wakes(file, {{"frozen_force_most_n", 0.6}}), HasSubstr("0.6 N, verified up to 0.5 N"));
  EXPECT_THAT(why_it_wakes(file, {{"frozen_force_most_n", nullptr}}), HasSubstr("no finite force"));
  const auto unknown = folder.add("unknown.json", describe_frozen({1, 2}, 9, std::nullopt).dump());
  EXPECT_THROW(why_it_wakes(unknown, {{"frozen_force_most_n", 0.0}}), InputError);
}

}  // namespace
}  // namespace palpate::experiments
