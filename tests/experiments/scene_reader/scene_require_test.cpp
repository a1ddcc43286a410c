// What a scene requires, read and refused.
#include "experiments/scene_reader/scene_require.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"

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
    read_text(GetParam().text);
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
    {"change", "error: {measure: energy, at_most: 0.1}\nmay_change: [suports]\n", 2,
     "did you mean \"supports\"?"},
    {"change_twice", "error: {measure: energy, at_most: 0.1}\nmay_change: [cuts, cuts]\n", 2, "twice"},
};

INSTANTIATE_TEST_SUITE_P(All, RequirementErrors, testing::ValuesIn(kBadRequirements),
                         [](const auto& bad) { return std::string(bad.param.name); });

}  // namespace
}  // namespace palpate::experiments
