// The axes of an envelope: what a factor changes, and that the way between two scenes is read back.
#include "experiments/envelope/envelope_axes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace palpate::experiments {
namespace {

using nlohmann::json;

json moving_scene() {
  return json::parse(R"({
    "schema": "palpate/scene/1",
    "mesh": {"file": "organ.mesh", "unit_m": 1},
    "material": {"young_modulus_pa": 10000, "poisson_ratio": 0.45, "density_kg_m3": 1050},
    "load": [{"gravity_m_s2": [0, 0, -9.81]},
             {"displace": {"sphere": {"center_m": [0, 0, 0], "radius_m": 0.01}, "by_m": [0, 0.003, 0.004]},
              "profile": {"times_s": [0, 0.05, 0.2], "shares": [0, 0, 1]}, "until_s": 0.3},
             {"force": {"sphere": {"center_m": [0, 0, 0], "radius_m": 0.01}, "total_n": [0, 2, 0]}}],
    "analysis": {"dynamic": {"integrator": "symplectic_euler", "time_step_s": 0.001, "duration_s": 0.5}}})");
}

double factor_along(const EnvelopeFactors& factors, EnvelopeAxis axis) {
  return factors.factor.at(static_cast<std::size_t>(axis)).value_or(NAN);
}

TEST(EnvelopeAxes, TheWayAlongAnAxisIsReadBack) {
  const json scene = moving_scene();
  for (const EnvelopeAxis axis : kEnvelopeAxes) {
    for (const double factor : {1.0, 1.7, 20.0}) {
      const EnvelopeFactors found =
          factors_between(place_of(scene), place_of(scaled_scene(scene, axis, factor)));
      ASSERT_EQ(found.why_none, "");
      EXPECT_NEAR(factor_along(found, axis), factor, 1e-12 * factor) << axis_name(axis);
    }
  }
}

TEST(EnvelopeAxes, WhatAFactorDoesToTheOthers) {
  const json scene = moving_scene();
  // A stiffer body is strained less by a force, as much by a displacement, and its waves make the step
  // longer.
  const EnvelopeFactors stiffer =
      factors_between(place_of(scene), place_of(scaled_scene(scene, EnvelopeAxis::kStiffer, 4.0)));
  EXPECT_DOUBLE_EQ(factor_along(stiffer, EnvelopeAxis::kLarger), 1.0);
  EXPECT_DOUBLE_EQ(factor_along(stiffer, EnvelopeAxis::kStep), 2.0);
  EXPECT_DOUBLE_EQ(factor_along(stiffer, EnvelopeAxis::kFaster), 1.0);
  // A softer one is strained more by what pulls at it.
  const EnvelopeFactors softer =
      factors_between(place_of(scene), place_of(scaled_scene(scene, EnvelopeAxis::kStiffer, 0.25)));
  EXPECT_DOUBLE_EQ(factor_along(softer, EnvelopeAxis::kLarger), 4.0);
  // The rise of 0.15 s is the shortest time in which a share changes; a time before it in which none does is
  // none.
  EXPECT_DOUBLE_EQ(place_of(scene).rise_s.value_or(0.0), 0.15000000000000002);
}

TEST(EnvelopeAxes, OneChangesWhatItSaysAndNothingElse) {
  const json scene = moving_scene();
  json expected = scene;
  expected["material"]["density_kg_m3"] = 525.0;
  EXPECT_EQ(scaled_scene(scene, EnvelopeAxis::kLighter, 2.0), expected);
  expected = scene;
  expected["strain"] = "large";
  expected["load"][0]["gravity_m_s2"] = {0.0, 0.0, -19.62};
  expected["load"][1]["displace"]["by_m"] = {0.0, 0.006, 0.008};
  expected["load"][2]["force"]["total_n"] = {0.0, 4.0, 0.0};
  EXPECT_EQ(scaled_scene(scene, EnvelopeAxis::kLarger, 2.0), expected);
  expected = scene;
  expected["load"][1]["profile"]["times_s"] = {0.0, 0.025, 0.1};
  expected["load"][1]["until_s"] = 0.15;
  EXPECT_EQ(scaled_scene(scene, EnvelopeAxis::kFaster, 2.0), expected);
  expected = scene;
  expected["analysis"]["dynamic"]["time_step_s"] = 0.002;
  EXPECT_EQ(scaled_scene(scene, EnvelopeAxis::kStep, 2.0), expected);
}

TEST(EnvelopeAxes, AtRestThereAreTwoAndWithoutTimesNoneIsFaster) {
  json scene = moving_scene();
  EXPECT_EQ(axes_of(scene).size(), 5U);
  scene["load"].erase(1);
  EXPECT_THAT(axes_of(scene), testing::Not(testing::Contains(EnvelopeAxis::kFaster)));
  scene["analysis"] = "static";
  EXPECT_THAT(axes_of(scene), testing::ElementsAre(EnvelopeAxis::kStiffer, EnvelopeAxis::kLarger));
  EXPECT_TRUE(changes_rest(EnvelopeAxis::kLighter, scene));  // it has a weight
  scene["load"].erase(0);
  EXPECT_FALSE(changes_rest(EnvelopeAxis::kLighter, scene));
}

TEST(EnvelopeAxes, OtherLoadsAndOtherMaterialsAreNotCompared) {
  const json scene = moving_scene();
  json other = scene;
  other["load"].erase(2);
  EXPECT_NE(factors_between(place_of(scene), place_of(other)).why_none, "");
  other = scene;
  other["material"]["poisson_ratio"] = 0.3;
  EXPECT_NE(factors_between(place_of(scene), place_of(other)).why_none, "");
}

}  // namespace
}  // namespace palpate::experiments
