// A stop that takes over how far another contestant's skin has strayed, with the real simplifiers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "experiments/records/record_file.h"
#include "tests/support/experiment_fixture.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
using test::run_program;
using testing::HasSubstr;

class AtItsDistance : public testing::Test {
 protected:
  /// Runs a plan with `wide`, which strays, and another contestant.
  test::ProgramResult run(const std::string& other, const std::string& more = "") const {
    const std::string text =
        "schema: palpate/plan/1\nquestion: Who is better at equal distance?\ncontest: simplify\n"
        "meshes: [{name: ball, make: ball, vertices: 700, skin: fine}]\ncontestants:\n"
        "  - {method: palpate.surface, label: wide, set: {max_surface_error_m: 0.0001, unit_m: 0.001, "
        "sparing: "
        "false}}\n  - " +
        other + "\nsweep: {tets_removed_ratio: [0.5, 0.7]}\nrun: {repeats: 1, warmup: 0}\n" + more +
        "measure: [tets, surface_distance_upper]\n";
    const std::string plan = fixture_.folder().add("plan.yaml", text).string();
    return run_program({"run", plan, "--out", (fixture_.folder() / "run").string(), "--no-report"});
  }

  std::map<std::string, json> records() const {
    std::map<std::string, json> found;
    for (json& record : read_records((fixture_.folder() / "run" / "records.jsonl").string())) {
      const std::string id = record.at("case").get<std::string>();
      found[id] = std::move(record);
    }
    return found;
  }

  test::ExperimentFixture fixture_;
};

TEST_F(AtItsDistance, TheBoundIsWhatTheOtherAnswerStraysInEachCase) {
  const auto result = run(
      "{method: palpate.surface, label: as_wide, stop: {tets_of: wide, at_its_distance: true}, set: {unit_m: "
      "0.001, sparing: false, effort: 2}}");
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const auto found = records();
  for (const std::string ratio : {"0.5", "0.7"}) {
    const json& wide = found.at("ball/wide/tets_removed_ratio=" + ratio);
    const json& as_wide = found.at("ball/as_wide/tets_removed_ratio=" + ratio);
    const double strayed = wide.at("judge").at("surface_distance_upper").get<double>();
    EXPECT_GT(strayed, 0.0);
    EXPECT_DOUBLE_EQ(as_wide.at("options").at("max_surface_error_m").get<double>(), 0.001 * strayed);
    EXPECT_LE(as_wide.at("judge").at("surface_distance_upper").get<double>(), strayed);
    EXPECT_EQ(as_wide.at("stop"),
              json({{"kind", "tets"}, {"value", wide.at("judge").at("tets")}, {"of", "wide"}}));
  }
  EXPECT_NE(found.at("ball/as_wide/tets_removed_ratio=0.5").at("options"),
            found.at("ball/as_wide/tets_removed_ratio=0.7").at("options"));
}

TEST_F(AtItsDistance, OnlyTetsOfHasADistance) {
  const auto result = run(
      "{method: palpate.surface, label: b, stop: {ratio: 0.5, at_its_distance: true}, set: {unit_m: 0.001}}");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.error, HasSubstr("plan.yaml:7: at_its_distance goes with tets_of"));
}

TEST_F(AtItsDistance, AMethodWithoutABoundIsRefused) {
  const auto result =
      run("{method: palpate.refined, label: b, stop: {tets_of: wide, at_its_distance: true}}");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.error,
              HasSubstr("plan.yaml:7: method palpate.refined has no option \"max_surface_error_m\""));
}

TEST_F(AtItsDistance, ABoundOfOnesOwnIsRefusedBesideIt) {
  const auto result =
      run("{method: palpate.surface, label: b, stop: {tets_of: wide, at_its_distance: true}, set: "
          "{max_surface_error_m: 0.1}}");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.error, HasSubstr("exclude each other"));
}

}  // namespace
}  // namespace palpate::experiments
