#include "experiments/runner/read_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/error.h"
#include "experiments/contests/simplify/plan_simplify.h"
#include "experiments/plan_reader/plan_report.h"
#include "experiments/records/provenance.h"
#include "experiments/runner/contest_table.h"
#include "tests/support/experiment_fixture.h"

namespace palpate::experiments {
namespace {

using testing::HasSubstr;

std::string error_of(const std::filesystem::path& plan, const Registry& registry) {
  try {
    read_plan(plan, registry);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

/// A plan whose error is known: the line it is on and a part of the message.
struct BadPlan {
  const char* name;
  const char* contestants;
  const char* rest;
  int line;
  const char* message;
};

void PrintTo(const BadPlan& plan, std::ostream* out) {
  *out << plan.name;
}

class PlanErrors : public testing::TestWithParam<BadPlan> {};

TEST_P(PlanErrors, NamesLineAndReason) {
  const test::ExperimentFixture fixture;
  const auto plan = fixture.add_plan(GetParam().contestants, GetParam().rest);
  const std::string message = error_of(plan, fixture.registry());
  EXPECT_THAT(message, HasSubstr("plan.yaml:" + std::to_string(GetParam().line) + ":"));
  EXPECT_THAT(message, HasSubstr(GetParam().message));
  EXPECT_EQ(message.find('\n'), std::string::npos);
}

// Lines 1 to 4 are schema, question, meshes, contest; contestants start on line 5, the rest on line 6.
const BadPlan kBadPlans[] = {
    {"unknown_key", "[test.copy]", "contestnts: []", 6,
     "unknown key \"contestnts\"; did you mean \"contestants\"?"},
    {"key_twice", "[test.copy]", "contest: simplify", 6, "key \"contest\" twice"},
    {"unknown_method", "[test.cpoy]", "", 5, "did you mean \"test.copy\"?"},
    {"method_without_family", "[copy]", "", 5, "did you mean \"test.copy\"?"},
    {"not_a_list", "test.copy", "", 5, "expected a list"},
    {"no_contestants", "[]", "", 5, "at least one"},
    {"label_twice", "\n  - test.copy\n  - test.copy", "", 7, "label \"test.copy\" twice"},
    {"label_input", "[{method: test.copy, label: input}]", "", 5, "the input mesh itself"},
    {"label_path", "[{method: test.copy, label: ../up}]", "", 5, "a name of letters"},
    {"unknown_option", "\n  - {method: test.copy, set: {behav: copy}}", "", 6, "did you mean \"behave\"?"},
    {"bad_choice", "[{method: test.copy, set: {behave: cpoy}}]", "", 5, "one of copy, crash"},
    {"option_too_large", "[{method: test.copy, set: {factor: 1.5}}]", "", 5, "a number from 0 to 1"},
    {"option_no_number", "[{method: test.copy, set: {factor: lots}}]", "", 5, "found \"lots\""},
    {"option_nan", "[{method: test.copy, set: {factor: nan}}]", "", 5, "found \"nan\""},
    {"option_no_integer", "[{method: test.copy, set: {seed: 1.5}}]", "", 5, "a whole number"},
    {"option_no_bool", "[{method: test.copy, set: {flag: yes}}]", "", 5, "true or false"},
    {"ratio_one", "[{method: test.copy, stop: {ratio: 1}}]", "", 5, "from 0 to less than 1"},
    {"ratio_negative", "[{method: test.copy, stop: {ratio: -0.1}}]", "", 5, "from 0 to less than 1"},
    {"fusions_negative", "[{method: test.copy, stop: {fusions: -1}}]", "", 5, "a whole number from 0"},
    {"tets_zero", "[{method: test.copy, stop: {tets: 0}}]", "", 5, "a whole number from 1"},
    {"tets_half", "[{method: test.copy, stop: {tets: 1.5}}]", "", 5, "a whole number"},
    {"limit_false", "[{method: test.copy, stop: {limit: false}}]", "", 5, "expected true"},
    {"two_stops", "[{method: test.copy, stop: {tets: 1, fusions: 1}}]", "", 5, "expected one of"},
    {"unknown_stop", "[{method: test.copy, stop: {fusion: 1}}]", "", 5, "did you mean \"fusions\"?"},
    {"stop_not_offered", "[{method: test.limit_only, stop: {tets: 5}}]", "", 5, "only at limit"},
    {"tets_of_unknown", "[{method: test.copy, label: a, stop: {tets_of: bb}}]", "", 5,
     "unknown label \"bb\""},
    {"tets_of_itself", "[{method: test.copy, label: a, stop: {tets_of: a}}]", "", 5, "circle"},
    {"tets_of_circle",
     "\n  - {method: test.copy, label: a, stop: {tets_of: b}}\n  - {method: test.copy, label: b, stop: "
     "{tets_of: a}}",
     "", 6, "circle"},
    {"tets_of_seeded",
     "\n  - {method: test.copy, label: a, seeds: 2}\n  - {method: test.copy, label: b, stop: {tets_of: a}}",
     "", 7, "without seeds"},
    {"distance_of_nobody", "[{method: test.copy, label: a, stop: {tets: 5, at_its_distance: true}}]", "", 5,
     "at_its_distance goes with tets_of"},
    {"distance_without_a_bound",
     "\n  - {method: test.copy, label: a}\n  - {method: test.copy, label: b, stop: {tets_of: a, "
     "at_its_distance: true}}",
     "", 7, "no option \"max_surface_error_m\""},
    {"seeds_zero", "[{method: test.copy, seeds: 0}]", "", 5, "seeds: expected a whole number from 1"},
    {"seeds_twice", "[{method: test.copy, seeds: [1, 1]}]", "", 5, "seeds that differ"},
    {"seeds_and_seed", "[{method: test.copy, seeds: 2, set: {seed: 1}}]", "", 5, "exclude each other"},
    {"seeds_without_option", "[{method: test.limit_only, seeds: 2}]", "", 5, "no option \"seed\""},
    {"keep_not_offered", "[{method: test.copy, keep: [sphere 0 0 0 1]}]", "", 5, "those that do are"},
    {"keep_unknown_kind", "\n  - method: test.keep\n    keep: [spere 0 0 0 1]", "", 7,
     "unknown region \"spere\"; did you mean \"sphere\"?"},
    {"keep_too_few", "[{method: test.keep, keep: [sphere 0 0 1]}]", "", 5,
     "expected \"sphere x y z r\", found 3"},
    {"keep_no_number", "[{method: test.keep, keep: [patch 0 0 0 1 deep]}]", "", 5, "found \"deep\""},
    {"keep_no_radius", "[{method: test.keep, keep: [sphere 0 0 0 -1]}]", "", 5, "a radius above 0"},
    {"keep_no_normal", "[{method: test.keep, keep: [half_space 0 0 0 1]}]", "", 5, "a normal of a length"},
    {"keep_empty", "[{method: test.keep, keep: []}]", "", 5, "at least one region"},
    {"keep_no_list", "[{method: test.keep, keep: sphere 0 0 0 1}]", "", 5, "expected a list"},
    {"keep_misspelt", "[{method: test.keep, kep: [sphere 0 0 0 1]}]", "", 5, "did you mean \"keep\"?"},
    {"near_size_zero", "[{method: test.keep, keep: [sphere 0 0 0 1], set: {near_size: 0}}]", "", 5,
     "from 0.001 to 1"},
    {"region_unknown_kind", "[test.copy]", "region: [halfspace 0 0 1 0]", 6, "did you mean \"half_space\"?"},
    {"unknown_measure", "[test.copy]", "measure: [kernel]", 6, "did you mean \"kernel_s\"?"},
    {"measure_twice", "[test.copy]", "measure: [kernel_s, kernel_s]", 6, "twice"},
    {"accept_unknown", "[test.copy]", "accept: {inverted_tet: {max: 0}}", 6,
     "did you mean \"inverted_tets\"?"},
    {"accept_list", "[test.copy]", "accept: {quality_histogram: {max: 0}}", 6, "a single number is needed"},
    {"accept_empty", "[test.copy]", "accept: {tets: {}}", 6, "expected min or max"},
    {"accept_no_number", "[test.copy]", "accept: {tets: {max: many}}", 6, "expected a number"},
    {"accept_crossed", "[test.copy]", "accept: {tets: {min: 2, max: 1}}", 6, "min is above max"},
    {"repeats_zero", "[test.copy]", "run: {repeats: 0}", 6, "from 1 to"},
    {"timeout_negative", "[test.copy]", "run: {timeout_s: -1}", 6, "timeout_s: expected a number from"},
    {"width_without_a_limit", "[test.copy]", "run: {until_width: 0.1}", 6, "needs \"most_repeats\""},
    {"limit_without_a_width", "[test.copy]", "run: {most_repeats: 9}", 6, "needs \"until_width\""},
    {"limit_below_repeats", "[test.copy]", "run: {repeats: 9, until_width: 0.1, most_repeats: 8}", 6,
     "most_repeats: expected a whole number from 9"},
    {"halving_without_a_frontier", "[test.copy]", "run: {repeats: 9, halving_from: 3}", 6,
     "has no \"frontier\""},
    {"halving_of_few", "[test.copy]", "run: {repeats: 3, halving_from: 3}", 6, "more than 3"},
    {"halving_too_early", "[test.copy]", "run: {repeats: 9, halving_from: 2}", 6, "halving_from: expected"},
    {"halving_and_width", "[test.copy]",
     "run: {repeats: 9, until_width: 0.1, most_repeats: 12, halving_from: 3}", 6, "not with \"until_width\""},
    {"width_zero", "[test.copy]", "run: {until_width: 0, most_repeats: 8}", 6, "until_width: expected a"},
    {"order_seed_negative", "[test.copy]", "run: {order_seed: -1}", 6, "order_seed: expected a whole"},
    {"tags_twice", "[{method: test.copy, tags: [fast, fast]}]", "", 5, "tag \"fast\" twice"},
    {"tags_empty", "[{method: test.copy, tags: []}]", "", 5, "at least one tag"},
    {"tags_pattern", "[{method: test.copy, tags: [\"a*\"]}]", "", 5, "a name of letters"},
    {"run_unknown", "[test.copy]", "run: {repeat: 2}", 6, "did you mean \"repeats\"?"},
    {"sweep_unknown", "[test.copy]", "sweep: {ratio: [0.1]}", 6, "unknown sweep \"ratio\""},
    {"sweep_impossible", "[test.copy]", "sweep: {tets_removed_ratio: [0.1, 1.0]}", 6, "less than 1"},
    {"sweep_twice", "[test.copy]", "sweep: {fusions: [1, 1]}", 6, "values that differ"},
    {"sweep_two_stops", "[test.copy]", "sweep: {fusions: [1], tets: [1]}", 6, "one kind of stop"},
    {"sweep_meets_none", "[{method: test.copy, stop: {tets: 3}}]", "sweep: {fusions: [1]}", 6,
     "meets no contestant"},
    {"sweep_option_bad", "[test.copy]", "sweep: {option.factor: [0.1, 2]}", 6, "from 0 to 1"},
    {"sweep_option_unknown", "[test.copy]", "sweep: {option.facto: [0.1]}", 6, "meets no contestant"},
    {"claim_label", "[test.copy]", "claim: {text: t, measure: tets, better: test.cop, than: test.copy}", 6,
     "did you mean \"test.copy\"?"},
    {"claim_missing", "[test.copy]", "claim: {text: t, measure: tets, better: test.copy}", 6,
     "the key \"than\" is missing"},
    {"equal_count_zero", "[test.copy]", "equal_count: 0", 6, "equal_count: expected a number from"},
    {"feature_deg_zero", "[test.copy]", "feature_deg: 0", 6,
     "feature_deg: expected degrees between 0 and 180"},
    {"feature_deg_wide", "[test.copy]", "feature_deg: 200", 6, "feature_deg: expected a number from"},
    {"feature_measure", "[test.copy]", "measure: [feature_distance_upper]", 6,
     "the measure \"feature_distance_upper\" needs the plan's \"feature_deg\""},
    {"feature_accept", "[test.copy]", "accept: {feature_distance_upper: {max: 1}}", 6,
     "the measure \"feature_distance_upper\" needs the plan's \"feature_deg\""},
    {"comparisons_empty", "[test.copy]", "comparisons: []", 6, "at least one comparison"},
    {"comparison_label", "[test.copy]",
     "comparisons: [{of: test.cop, against_best_of: [test.copy], measures: [kernel_s]}]", 6,
     "did you mean \"test.copy\"?"},
    {"comparison_itself", "[test.copy]",
     "comparisons: [{of: test.copy, against_best_of: [test.copy], measures: [kernel_s]}]", 6,
     "cannot be compared with itself"},
    {"comparison_peers_missing", "[test.copy]", "comparisons: [{of: test.copy, measures: [kernel_s]}]", 6,
     "the key \"against_best_of\" is missing"},
    {"comparison_no_peer", "[test.copy]",
     "comparisons: [{of: test.copy, against_best_of: [], measures: [kernel_s]}]", 6, "at least one label"},
    {"comparison_peer_twice", "\n  - {method: test.copy, label: a}\n  - {method: test.copy, label: b}",
     "comparisons:\n  - {of: a, against_best_of: [b, b], measures: [kernel_s]}", 9, "label \"b\" twice"},
    {"comparison_no_direction", "\n  - {method: test.copy, label: a}\n  - {method: test.copy, label: b}",
     "comparisons:\n  - of: a\n    against_best_of: [b]\n    measures: [mean_quality, tets]", 11,
     "neither more nor less is better"},
    {"comparison_measure", "\n  - {method: test.copy, label: a}\n  - {method: test.copy, label: b}",
     "comparisons: [{of: a, against_best_of: [b], measures: [mean_qualty]}]", 8,
     "did you mean \"mean_quality\"?"},
    {"comparison_factor_alone", "\n  - {method: test.copy, label: a}\n  - {method: test.copy, label: b}",
     "comparisons: [{of: a, against_best_of: [b], measures: [mean_quality], time_factor: 10}]", 8,
     "\"time_factor\" needs \"time_against\""},
    {"comparison_required_text", "\n  - {method: test.copy, label: a}\n  - {method: test.copy, label: b}",
     "comparisons: [{of: a, against_best_of: [b], measures: [mean_quality], required: maybe}]", 8,
     "required: expected true or false"},
    {"comparison_few_repeats", "\n  - {method: test.copy, label: a}\n  - {method: test.copy, label: b}",
     "run: {repeats: 8, warmup: 1}\ncomparisons:\n  - of: a\n    against_best_of: [b]\n    measures: "
     "[mean_quality]\n    time_against: b",
     13, "or more, found {repeats: 8, warmup: 1}"},
    {"comparison_no_warmup", "\n  - {method: test.copy, label: a}\n  - {method: test.copy, label: b}",
     "run: {repeats: 9}\ncomparisons:\n  - of: a\n    against_best_of: [b]\n    measures: [kernel_s]", 12,
     "at least 9 repeats and 1 warm-up"},
    {"claim_required_text", "[test.copy]",
     "claim: {text: t, measure: tets, better: test.copy, than: test.copy, required: 1}", 6,
     "required: expected true or false"},
    {"comparison_unknown_key", "\n  - {method: test.copy, label: a}\n  - {method: test.copy, label: b}",
     "comparisons: [{of: a, against_best: [b], measures: [kernel_s]}]", 8,
     "did you mean \"against_best_of\"?"},
    {"chart_unknown", "[test.copy]", "charts: [cutaway]", 6, "did you mean \"cut_away\"?"},
    {"chart_twice", "[test.copy]", "charts: [timing, timing]", 6, "chart \"timing\" twice"},
    {"anchor", "[&a test.copy]", "", 5, "anchors and aliases"},
    {"broken_yaml", "[test.copy", "", 6, "not YAML"},
};

INSTANTIATE_TEST_SUITE_P(All, PlanErrors, testing::ValuesIn(kBadPlans),
                         [](const auto& tested) { return std::string(tested.param.name); });

std::string mesh_error(const std::string& meshes) {
  const test::ExperimentFixture fixture;
  return error_of(fixture.folder().add("m.yaml", "schema: palpate/plan/1\nquestion: q\nmeshes:\n" + meshes +
                                                     "\ncontest: simplify\ncontestants: [test.copy]\n"),
                  fixture.registry());
}

TEST(Plan, MeshErrors) {
  EXPECT_THAT(mesh_error("  - {name: a, file: none.mesh}"),
              HasSubstr("m.yaml:4: expected a mesh file, found none"));
  EXPECT_THAT(mesh_error("  - {name: a}"), HasSubstr("m.yaml:4: a mesh needs one of"));
  EXPECT_THAT(mesh_error("  - {name: a, file: cube.mesh, make: cube}"), HasSubstr("a mesh needs one of"));
  EXPECT_THAT(mesh_error("  - {name: a, make: cubb}"), HasSubstr("did you mean \"cube\"?"));
  EXPECT_THAT(mesh_error("  - {name: a, make: cube, vertices: 8, edge_length: 1}"), HasSubstr("not both"));
  EXPECT_THAT(mesh_error("  - {name: a, file: cube.mesh, vertices: 8}"), HasSubstr("belongs to \"make\""));
  EXPECT_THAT(mesh_error("  - {name: a, make: cube, vertices: many}"), HasSubstr("expected a whole number"));
  EXPECT_THAT(mesh_error("  - {name: a, make: cube}\n  - {name: a, make: cube}"),
              HasSubstr("m.yaml:5: mesh \"a\" twice"));
}

std::string text_error(const std::string& bytes) {
  const test::ExperimentFixture fixture;
  return error_of(fixture.folder().add("t.yaml", bytes), fixture.registry());
}

TEST(Plan, AMeshFileHasTheEndingOfOne) {
  const test::ExperimentFixture fixture;
  const auto error_of = [&](const std::string& file) {
    fixture.folder().add(file, "x");
    return fixture.error_of_plan(fixture.folder().add(
        "ending.yaml", "schema: palpate/plan/1\nquestion: q\nmeshes: [{name: a, file: " + file +
                           "}]\ncontest: simplify\ncontestants: [test.copy]\n"));
  };
  EXPECT_THAT(error_of("a.stl"),
              HasSubstr("ending.yaml:3: expected a mesh in .mesh, .msh, .vtk or .vtu, found a surface"));
  EXPECT_THAT(
      error_of("a.txt"),
      HasSubstr("ending.yaml:3: file: expected a mesh in .mesh, .msh, .vtk or .vtu, found \"a.txt\""));
  for (const char* good : {"a.mesh", "a.msh", "a.VTK", "a.vtu"})
    EXPECT_EQ(error_of(good), "no error") << good;
}

TEST(Plan, FilesThatAreNoPlans) {
  EXPECT_THAT(text_error(""), HasSubstr("t.yaml: the file is empty"));
  EXPECT_THAT(text_error("\n\n"), HasSubstr("t.yaml: the file is empty"));
  EXPECT_THAT(text_error("words"), HasSubstr("t.yaml:1: expected a mapping"));
  EXPECT_THAT(text_error("schema: palpate/plan/2"), HasSubstr("expected palpate/plan/1"));
  EXPECT_THAT(text_error(std::string("schema: \0\x01\n", 11)), HasSubstr("control character"));
  EXPECT_THAT(text_error("a: 1\n---\nb: 2\n"), HasSubstr("found more"));
  EXPECT_THAT(text_error(std::string(2U << 20U, '#')), HasSubstr("larger than 1 MiB"));
  EXPECT_THAT(text_error(std::string(60, '[') + std::string(60, ']')), HasSubstr("levels deep"));
  EXPECT_THAT(text_error(std::string(100'000, '[')), HasSubstr("t.yaml:1:"));
  std::string many = "a: [";
  for (int i = 0; i < 120'000; ++i) many += "1,";
  EXPECT_THAT(text_error(many + "1]"), HasSubstr("more than 100000 values"));
}

TEST(Plan, BombIsRefusedAtItsFirstAnchor) {
  EXPECT_THAT(text_error("a: &a [x,x,x,x,x,x,x,x,x]\nb: &b [*a,*a,*a,*a,*a,*a,*a,*a,*a]\n"
                         "c: &c [*b,*b,*b,*b,*b,*b,*b,*b,*b]\nd: [*c,*c,*c,*c,*c,*c,*c,*c,*c]\n"),
              HasSubstr("t.yaml:1: anchors and aliases"));
}

TEST(Plan, AMappingHasABoundOfKeys) {
  std::string text;
  for (int k = 0; k < 1001; ++k) text += "k" + std::to_string(k) + ": 1\n";
  EXPECT_THAT(text_error(text), HasSubstr("expected at most 1000 keys"));
}

TEST(Plan, ShortListsCannotBeCrossedToAnyNumberOfCases) {
  const test::ExperimentFixture fixture;
  std::string numbers;
  for (int k = 1; k <= 2000; ++k) numbers += (k > 1 ? ", " : "") + std::to_string(k);
  const Plan plan = read_plan(fixture.add_plan("[test.copy]", "sweep: {fusions: [" + numbers +
                                                                  "], option.seed: [" + numbers + "]}\n"),
                              fixture.registry());
  try {
    build_cases(plan, fixture.registry());
    FAIL() << "four million cases";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("expected at most 1000000 cases"));
  }
}

TEST(Plan, MissingFileAndFolder) {
  const test::ExperimentFixture fixture;
  EXPECT_THAT(error_of(fixture.folder() / "none.yaml", fixture.registry()), HasSubstr("no such file"));
  EXPECT_THAT(error_of(fixture.folder().path(), fixture.registry()), HasSubstr("a folder"));
}

TEST(Plan, HoldsWhatWasWritten) {
  const test::ExperimentFixture fixture;
  const Plan plan =
      read_plan(fixture.add_plan(
                    "\n  - test.copy\n  - {method: test.copy, label: b, stop: {tets_of: "
                    "test.copy}, set: {factor: 0.25}, "
                    "seeds: [4, 9], required: false}\n"
                    "  - {method: test.keep, label: c, keep: [sphere 0 0 0.5 1, half_space 0 0 1 "
                    "-0.25], set: {reach: 2}}",
                    "run: {repeats: 3, warmup: 1, threads: 2, timeout_s: 1.5, memory_mib: 64}\n"
                    "region: [patch 0 0 1 0.5 0.1]\nmeasure: [kernel_s]\naccept: {inverted_tets: {max: 0}}\n"
                    "claim: {text: t, source: s, measure: tets, better: b, than: test.copy, "
                    "published: {better: 2, than: 1}}\n"),
                fixture.registry());
  EXPECT_EQ(plan.name, "plan");
  ASSERT_EQ(plan.contestants.size(), 3U);
  EXPECT_EQ(plan.contestants[0].label, "test.copy");
  EXPECT_TRUE(plan.contestants[0].required);
  const PlanContestant& b = plan.contestants[1];
  EXPECT_EQ(b.seeds, (std::vector<std::int64_t>{4, 9}));
  EXPECT_FALSE(b.required);
  EXPECT_EQ(b.set.at("factor").text, "0.25");
  EXPECT_EQ(b.stop->kind, StopKind::kTetsOf);
  EXPECT_TRUE(b.keep.empty());
  EXPECT_EQ(plan.contestants[2].keep,
            (std::vector<std::string>{"sphere 0 0 0.5 1", "half_space 0 0 1 -0.25"}));
  EXPECT_EQ(plan.contestants[2].set.at("reach").text, "2");
  EXPECT_EQ(part_of<SimplifyPart>(plan).region, (std::vector<std::string>{"patch 0 0 1 0.5 0.1"}));
  EXPECT_EQ(plan.run.repeats, 3);
  EXPECT_DOUBLE_EQ(plan.run.timeout_s, 1.5);
  EXPECT_EQ(plan.accept.at(0).measure, "inverted_tets");
  EXPECT_DOUBLE_EQ(*part_of<SimplifyPart>(plan).claim->published_better, 2.0);
  EXPECT_FALSE(part_of<SimplifyPart>(plan).equal_count.has_value());
  EXPECT_TRUE(part_of<SimplifyPart>(plan).comparisons.empty());
  EXPECT_THAT(plan.notes, testing::ElementsAre(testing::HasSubstr("times (kernel_s) come from 3 repeats: ")));
}

TEST(Plan, HoldsWhatItAsksOfTheReport) {
  const test::ExperimentFixture fixture;
  const Plan plan = read_plan(
      fixture.add_plan("\n  - {method: test.copy, label: a}\n  - {method: test.copy, label: b}",
                       "equal_count: 0.005\ncharts: [scaling, cut_away]\n"
                       "run: {repeats: 9, warmup: 1}\nmeasure: [kernel_s]\ncomparisons:\n"
                       "  - {of: a, against_best_of: [b], measures: [p1_dihedral_deg, kernel_s], "
                       "time_against: b, time_factor: 10, input_up_to_ratio: 0.22, required: true}\n"),
      fixture.registry());
  EXPECT_DOUBLE_EQ(part_of<SimplifyPart>(plan).equal_count.value(), 0.005);
  EXPECT_TRUE(plan.notes.empty());
  EXPECT_TRUE(requires_report(plan.file));
  EXPECT_EQ(plan.charts, (std::vector<std::string>{"scaling", "cut_away"}));
  ASSERT_EQ(part_of<SimplifyPart>(plan).comparisons.size(), 1U);
  const Comparison& comparison = part_of<SimplifyPart>(plan).comparisons[0];
  EXPECT_EQ(plan.compared, comparison.measures);
  EXPECT_EQ(comparison.of, "a");
  EXPECT_EQ(comparison.against_best_of, std::vector<std::string>{"b"});
  EXPECT_EQ(comparison.measures, (std::vector<std::string>{"p1_dihedral_deg", "kernel_s"}));
  EXPECT_EQ(comparison.time_against, "b");
  EXPECT_DOUBLE_EQ(comparison.time_factor.value(), 10.0);
  EXPECT_DOUBLE_EQ(comparison.input_up_to_ratio.value(), 0.22);
  const nlohmann::json measures = build_provenance(plan, fixture.registry(), 1).at("measures");
  EXPECT_EQ(measures.size(), 2U);
  EXPECT_EQ(measures.at("p1_dihedral_deg").at("better"), "higher");
  EXPECT_EQ(measures.at("kernel_s").at("better"), "lower");
}

}  // namespace
}  // namespace palpate::experiments
