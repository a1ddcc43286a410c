// What a scene requires, read and refused.
#include "experiments/scene_reader/scene_require.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "core/mesh/shapes/shapes.h"

namespace palpate::experiments {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

SceneRequirement read_text(const std::string& text) {
  return read_requirement(parse_yaml(text, "scene.yaml"));
}

TEST(SceneRequirement, ToleranceBudgetAndNeeds) {
  const SceneRequirement require = read_text(
      "error: {measure: deformation_l2, at_most: 0.05}\ntime_per_second_s: 0.5\nmemory_bytes: 5.0e+8\n"
      "large_strain: true\nmay_change: [supports, cuts]\n");
  EXPECT_EQ(require.measure, "displacement_deformation");
  EXPECT_EQ(require.at_most, 0.05);
  EXPECT_EQ(require.time_per_second_s, 0.5);
  EXPECT_EQ(require.memory_bytes, 500'000'000U);
  EXPECT_FALSE(require.rate_hz.has_value());
  EXPECT_THAT(require.needs, ElementsAre("supports", "cuts", "large_strain"));
}

TEST(SceneRequirement, WhatIsFalseIsNotNeeded) {
  EXPECT_TRUE(read_text("error: {measure: energy, at_most: 0.1}\nlarge_strain: false\n").needs.empty());
}

const std::vector<SceneProbe> kProbes{{"tip", {0.0, 0.0, 1.0}}, {"side", {1.0, 0.5, 0.5}}};

TEST(SceneRequirement, AnErrorMayBeAskedForAtProbesOrInRegions) {
  const auto read = [](const std::string& at) {
    return read_requirement(
        parse_yaml("error: {measure: relative_l2, at_most: 0.1, at: " + at + "}\n", "scene.yaml"), kProbes);
  };
  const TetMesh cube = build_kuhn_cube(2, 0.0, 0);  // 27 vertices, a side of 1
  SceneRequirement at_tip = read("tip");
  EXPECT_EQ(at_tip.measure, "displacement_l2_at");
  ASSERT_EQ(find_error_points(at_tip, cube).size(), 1U);
  EXPECT_EQ(cube.points[find_error_points(at_tip, cube)[0]], (Vec3{0.0, 0.0, 1.0}));
  EXPECT_EQ(find_error_points(read("[tip, side]"), cube).size(), 2U);
  EXPECT_EQ(find_error_points(read("[{half_space: {normal: [0, 0, 1], offset_m: 0.5}}]"), cube).size(), 18U);
  EXPECT_EQ(find_error_points(read("[{half_space: {normal: [0, 0, 1], offset_m: 0}}, "
                                   "{sphere: {center_m: [0, 0, 0], radius_m: 0.6}}]"),
                              cube)
                .size(),
            10U)
      << "the nine of a side, and one above its corner: vertices of both count once";
  EXPECT_TRUE(find_error_points(read_text("error: {measure: max, at_most: 0.1}\n"), cube).empty());
}

TEST(SceneRequirement, APlaceThatSelectsNothingIsRefused) {
  const TetMesh cube = build_kuhn_cube(2, 0.0, 0);
  const auto message = [&](const std::string& at, const std::vector<SceneProbe>& probes) {
    try {
      find_error_points(
          read_requirement(parse_yaml("error: {measure: max, at_most: 0.1, at: " + at + "}\n", "scene.yaml"),
                           probes),
          cube);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  EXPECT_THAT(message("{sphere: {center_m: [0.25, 0.2, 0.3], radius_m: 0.1}}", {}),
              AllOf(HasSubstr("scene.yaml:1"), HasSubstr("the region (sphere) has no vertex")));
  EXPECT_THAT(message("{box: {low_m: [100, 0, 0], high_m: [101, 1, 1]}}", {}), HasSubstr("is it in metres"));
  EXPECT_THAT(message("far", {{"far", {100.0, 0.0, 0.0}}}), HasSubstr("the probe far is 99.5025 m from"));
}

struct BadRequirement {
  const char* name;
  const char* text;
  int line;
  const char* message;
};

void PrintTo(const BadRequirement& bad, std::ostream* out) {
  *out << bad.name;
}

class RequirementErrors : public testing::TestWithParam<BadRequirement> {};

TEST_P(RequirementErrors, NameLineAndReason) {
  std::string message = "no error";
  try {
    read_requirement(parse_yaml(GetParam().text, "scene.yaml"), kProbes);
  } catch (const InputError& error) {
    message = error.what();
  }
  EXPECT_THAT(message, HasSubstr("scene.yaml:" + std::to_string(GetParam().line) + ":"));
  EXPECT_THAT(message, HasSubstr(GetParam().message));
}

const BadRequirement kBadRequirements[] = {
    {"nothing", "rate_hz: 10\n", 1, "error"},
    {"key", "error: {measure: energy, at_most: 0.1}\nrate: 10\n", 2, "did you mean \"rate_hz\"?"},
    {"measure", "error: {measure: energie, at_most: 0.1}\n", 1, "did you mean \"energy\"?"},
    {"zero", "error: {measure: energy, at_most: 0}\n", 1, "at_most"},
    {"not_a_number", "error: {measure: energy, at_most: .nan}\n", 1, "at_most"},
    {"budget", "error: {measure: energy, at_most: 0.1}\ntime_per_second_s: -1\n", 2, "time_per_second_s"},
    {"two_budgets", "error: {measure: energy, at_most: 0.1}\nrate_hz: 10\ntime_per_second_s: 1\n", 2,
     "takes one of them"},
    {"answer_and_rate", "error: {measure: energy, at_most: 0.1}\nrate_hz: 10\nanswer_s: 1\n", 3,
     "goes with neither"},
    {"no_place", "error: {measure: energy, at_most: 0.1,\n at: [tip]}\n", 2, "is of the whole body"},
    {"force_has_no_place", "error: {measure: pad_force, at_most: 0.1,\n at: {box: {}}}\n", 2,
     "\"pad_force\""},
    {"no_probe", "error: {measure: max, at_most: 0.1,\n at: [tipp]}\n", 2, "did you mean \"tip\"?"},
    {"no_region", "error: {measure: max, at_most: 0.1,\n at: [{ball: {}}]}\n", 2, "ball"},
    {"nowhere", "error: {measure: max, at_most: 0.1,\n at: []}\n", 2, "at least one"},
    {"mixed",
     "error: {measure: max, at_most: 0.1,\n at: [tip, {box: {low_m: [0, 0, 0], high_m: [1, 1, 1]}}]}\n", 2,
     "one or the other"},
    {"probe_twice", "error: {measure: max, at_most: 0.1,\n at: [tip, tip]}\n", 2, "twice"},
    {"change", "error: {measure: energy, at_most: 0.1}\nmay_change: [suports]\n", 2,
     "did you mean \"supports\"?"},
    {"change_twice", "error: {measure: energy, at_most: 0.1}\nmay_change: [cuts, cuts]\n", 2, "twice"},
};

INSTANTIATE_TEST_SUITE_P(All, RequirementErrors, testing::ValuesIn(kBadRequirements),
                         [](const auto& bad) { return std::string(bad.param.name); });

}  // namespace
}  // namespace palpate::experiments
