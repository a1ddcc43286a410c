#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "experiments/runner/read_plan.h"
#include "tests/support/experiment_fixture.h"

namespace palpate::experiments {
namespace {

using testing::HasSubstr;

/// Lines 1 to 7, then `rest` from line 8 on.
std::filesystem::path add_deform_plan(const test::ExperimentFixture& fixture, const std::string& rest) {
  return fixture.folder().add("plan.yaml",
                              "schema: palpate/plan/1\n"
                              "question: How far off?\n"
                              "scenes: [bar_tension, bar_shear_force]\n"
                              "contest: deform\n"
                              "reference: {method: test.field}\n"
                              "contestants: [{method: test.field, label: near}, test.unrefined]\n"
                              "sweep: {poisson_ratio: [0.25, 0.45]}\n" +
                                  rest);
}

TEST(PlanTargets, SetsAndTargetsAreAccepted) {
  const test::ExperimentFixture fixture;
  const auto plan = add_deform_plan(
      fixture,
      "scene_sets: {bars: [bar_tension, bar_shear_force]}\n"
      "targets:\n"
      "  - {text: near, labels: near, scenes: bars, at: {poisson_ratio: 0.45}, at_most: 0.02}\n"
      "  - {text: any, labels: [near, test.unrefined], scenes: [bars, bar_tension], at_most: 0.1,\n"
      "     at: {poisson_ratio: [0.25, 0.45]}, measure: displacement_energy}\n"
      "charts: [error_bars, convergence]\n");
  EXPECT_THAT(read_plan(plan, fixture.registry()).charts, testing::ElementsAre("error_bars", "convergence"));
}

struct BadTargets {
  const char* name;
  const char* rest;
  int line;
  const char* message;
};

void PrintTo(const BadTargets& plan, std::ostream* out) {
  *out << plan.name;
}

class PlanTargetErrors : public testing::TestWithParam<BadTargets> {};

TEST_P(PlanTargetErrors, NameLineAndReason) {
  const test::ExperimentFixture fixture;
  std::string message = "no error";
  try {
    read_plan(add_deform_plan(fixture, GetParam().rest), fixture.registry());
  } catch (const InputError& error) {
    message = error.what();
  }
  EXPECT_THAT(message, HasSubstr("plan.yaml:" + std::to_string(GetParam().line) + ":"));
  EXPECT_THAT(message, HasSubstr(GetParam().message));
}

const BadTargets kBadTargets[] = {
    {"set_scene", "scene_sets: {bars: [bar_tensoin]}", 8, "did you mean \"bar_tension\"?"},
    {"set_twice", "scene_sets: {bars: [bar_tension, bar_tension]}", 8, "scene \"bar_tension\" twice"},
    {"set_empty", "scene_sets: {bars: []}", 8, "at least one scene"},
    {"set_named_as_scene", "scene_sets: {bar_tension: [bar_tension]}", 8, "a name of its own"},
    {"label", "targets:\n  - {text: a, labels: naer, at_most: 0.1}", 9, "did you mean \"near\"?"},
    {"no_label", "targets:\n  - {text: a, labels: [], at_most: 0.1}", 9, "at least one label"},
    {"scene", "targets:\n  - {text: a, labels: near, scenes: bars, at_most: 0.1}", 9,
     "unknown scene or set \"bars\""},
    {"key", "targets:\n  - {text: a, labels: near, at_mots: 0.1}", 9, "did you mean \"at_most\"?"},
    {"required", "targets:\n  - {text: a, labels: near, at_most: 1, required: yes}", 9,
     "required: expected true or false"},
    {"claim", "claim: {text: t, measure: tets, better: near, than: near}", 8,
     "\"claim\" belongs to the contest simplify, not to deform"},
    {"no_bound", "targets:\n  - {text: a, labels: near}", 9, "at_most"},
    {"bound", "targets:\n  - {text: a, labels: near, at_most: -1}", 9, "at_most"},
    {"text", "targets:\n  - {text: \"\", labels: near, at_most: 1}", 9, "what is to be reached"},
    {"axis", "targets:\n  - {text: a, labels: near, at: {vertices: 1503}, at_most: 1}", 9,
     "\"vertices\" is not swept in this plan"},
    {"value", "targets:\n  - {text: a, labels: near, at: {poisson_ratio: 0.3}, at_most: 1}", 9,
     "poisson_ratio 0.3 is not a value of the sweep"},
    {"measure", "targets:\n  - {text: a, labels: near, measure: kernel_s, at_most: 1}", 9,
     "unknown error \"kernel_s\""},
    {"chart", "charts: [histograms]", 8, "unknown chart \"histograms\""},
};

INSTANTIATE_TEST_SUITE_P(All, PlanTargetErrors, testing::ValuesIn(kBadTargets),
                         [](const auto& plan) { return std::string(plan.param.name); });

TEST(PlanTargets, BelongToTheContestOfDisplacements) {
  const test::ExperimentFixture fixture;
  for (const std::string key : {"scene_sets: {a: [b]}", "targets: []"}) {
    try {
      read_plan(fixture.add_plan("[test.copy]", key), fixture.registry());
      ADD_FAILURE() << key;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("belongs to the contest deform"));
    }
  }
}

}  // namespace
}  // namespace palpate::experiments
