// The frontier of a plan, and contestants that run at some values of the sweep alone.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "experiments/plan_reader/case_list.h"
#include "experiments/runner/contest_table.h"
#include "experiments/runner/read_plan.h"
#include "tests/support/experiment_fixture.h"

namespace palpate::experiments {
namespace {

using testing::HasSubstr;

/// Lines 1 to 7, then `rest` from line 8 on.
std::filesystem::path add_frontier_plan(const test::ExperimentFixture& fixture, const std::string& rest,
                                        const std::string& contestants =
                                            "[{method: test.field, label: near}, "
                                            "test.unrefined]") {
  return fixture.folder().add("plan.yaml",
                              "schema: palpate/plan/1\n"
                              "question: What does it cost?\n"
                              "scenes: [bar_tension]\n"
                              "contest: deform\n"
                              "reference: {method: test.field}\n"
                              "contestants: " +
                                  contestants +
                                  "\nsweep: {poisson_ratio: [0.25, 0.45], vertices: [500, 1503]}\n" + rest);
}

TEST(PlanFrontier, FamiliesErrorsAndTargetsAreAccepted) {
  const test::ExperimentFixture fixture;
  EXPECT_NO_THROW(
      read_plan(add_frontier_plan(
                    fixture,
                    "frontier:\n  families: {ours: [near], theirs: [test.unrefined]}\n  against: [theirs]\n"
                    "  at: [0.1, 0.05]\n  targets: [{work: further, against: theirs, at: 0.05, factor: 20}]\n"
                    "charts: [frontier]\n"),
                fixture.registry()));
}

TEST(PlanFrontier, FamiliesMayBeOfSimplifiers) {
  const test::ExperimentFixture fixture;
  const std::string frontier =
      "frontier: {of: simplifiers, families: {all: [none, copy]}, against: [], at: [0.1]}\n";
  EXPECT_NO_THROW(
      read_plan(add_frontier_plan(fixture, "simplify: [none, {method: test.copy, label: copy}]\n" + frontier),
                fixture.registry()));
  EXPECT_THAT([&] { read_plan(add_frontier_plan(fixture, frontier), fixture.registry()); },
              testing::ThrowsMessage<InputError>(HasSubstr("without the key simplify")));
}

struct BadFrontier {
  const char* name;
  const char* rest;
  int line;
  const char* message;
};

void PrintTo(const BadFrontier& bad, std::ostream* out) {
  *out << bad.name;
}

class FrontierErrors : public testing::TestWithParam<BadFrontier> {};

TEST_P(FrontierErrors, NameLineAndReason) {
  const test::ExperimentFixture fixture;
  std::string message = "no error";
  try {
    read_plan(add_frontier_plan(fixture, GetParam().rest), fixture.registry());
  } catch (const InputError& error) {
    message = error.what();
  }
  EXPECT_THAT(message, HasSubstr("plan.yaml:" + std::to_string(GetParam().line) + ":"));
  EXPECT_THAT(message, HasSubstr(GetParam().message));
}

const BadFrontier kBadFrontiers[] = {
    {"label", "frontier: {families: {a: [naer]}, against: [], at: [0.1]}", 8, "did you mean \"near\"?"},
    {"left_out", "frontier: {families: {a: [near]}, against: [], at: [0.1]}", 8,
     "label \"test.unrefined\" is in no family"},
    {"twice", "frontier: {families: {a: [near], b: [near]}, against: [], at: [0.1]}", 8,
     "in the family \"a\" already"},
    {"empty", "frontier: {families: {a: []}, against: [], at: [0.1]}", 8, "at least one label"},
    {"against", "frontier: {families: {a: [near, test.unrefined]}, against: [b], at: [0.1]}", 8,
     "unknown family \"b\""},
    {"error", "frontier: {families: {a: [near], b: [test.unrefined]}, against: [b], at: [0]}", 8, "at"},
    {"no_error", "frontier: {families: {a: [near], b: [test.unrefined]}, against: [b], at: []}", 8,
     "at least one error"},
    {"work",
     "frontier: {families: {a: [near], b: [test.unrefined]}, against: [b], at: [0.1], targets: [{work: "
     "third, against: b, at: 0.1, factor: 2}]}",
     8, "first, further, second or second_setup"},
};

INSTANTIATE_TEST_SUITE_P(All, FrontierErrors, testing::ValuesIn(kBadFrontiers),
                         [](const auto& bad) { return std::string(bad.param.name); });

TEST(ContestantAt, RunsAtThoseValuesAlone) {
  const test::ExperimentFixture fixture;
  const Plan plan =
      read_plan(add_frontier_plan(fixture, "",
                                  "[{method: test.field, label: near, at: {vertices: 500}}, test.unrefined]"),
                fixture.registry());
  std::size_t near = 0;
  for (const Case& c : build_cases(plan, fixture.registry())) {
    if (plan.contestants[c.contestant].label != "near") continue;
    ++near;
    EXPECT_EQ(c.sweep.at("vertices"), 500);
  }
  EXPECT_EQ(near, 2U);  // Poisson's ratios
  EXPECT_EQ(build_cases(plan, fixture.registry()).size(), 6U);
}

TEST(ContestantAt, BadPlacesAreRefused) {
  const test::ExperimentFixture fixture;
  const auto message = [&](const std::string& at) {
    try {
      const Plan plan =
          read_plan(add_frontier_plan(fixture, "", "[{method: test.field, label: near, at: " + at + "}]"),
                    fixture.registry());
      build_cases(plan, fixture.registry());
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  EXPECT_THAT(message("{vertexes: 500}"), HasSubstr("did you mean \"vertices\"?"));
  EXPECT_THAT(message("{vertices: []}"), HasSubstr("at least one value"));
  EXPECT_THAT(message("{vertices: 501}"), HasSubstr("\"at\" of \"near\" leaves nothing of the sweep"));
}

}  // namespace
}  // namespace palpate::experiments
