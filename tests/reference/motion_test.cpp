// motion.* of the contest stability: bodies driven to extremes, and what is reported of them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/mesh/io/medit.h"
#include "core/mesh/shapes/shapes.h"
#include "experiments/contests/stability/stability_input.h"
#include "reference/door/json_file.h"
#include "reference/extremes/extreme_body.h"
#include "reference/extremes/extreme_run.h"
#include "tests/support/scratch_folder.h"

namespace palpate::reference {
namespace {

using nlohmann::json;
using testing::HasSubstr;

/// The body that the contest makes of these settings.
StabilityTask make_task(const json& settings) {
  experiments::StabilityInput input = experiments::build_stability_input(build_bar(2), settings);
  return {std::move(input.mesh), std::move(input.problem)};
}

TEST(ExtremeBody, FactorsAndDampingAreThoseThatWereAskedFor) {
  const BuiltBody nominal = build_extreme_body(make_task({{"damping", "none"}}), {});
  const double rate = nominal.report.at("rate_per_s").get<double>();
  const BuiltBody built = build_extreme_body(make_task({{"stiffness_factor", 1e3},
                                                        {"mass_factor", 1e-3},
                                                        {"damping", "stiffness"},
                                                        {"damping_ratio", 0.5}}),
                                             {});
  const auto& springs = built.model.elastic.springs;
  for (std::size_t s = 0; s < springs.springs.size(); ++s) {
    const double k = nominal.model.elastic.springs.stiffness_n_per_m[s];
    EXPECT_DOUBLE_EQ(springs.stiffness_n_per_m[s], 1e3 * k);
    EXPECT_DOUBLE_EQ(built.model.spring_damping_n_s_per_m[s], k / rate);  // damping knows no factors
  }
  EXPECT_DOUBLE_EQ(built.model.mass_kg[3], 1e-3 * nominal.model.mass_kg[3]);
  const double spread =
      build_extreme_body(make_task({{"mass_ratio", 1e6}}), {}).report.at("mass_ratio").get<double>();
  EXPECT_GT(spread, 1e5);
  EXPECT_LT(spread, 1e8);  // vertices differ by themselves too
}

/// A request's report, with what a request needs filled in.
class ExtremeRunTest : public testing::Test {
 protected:
  /// `options` with the settings of the body among them.
  json report(const std::string& method, const json& options) const {
    const experiments::StabilityInput input =
        experiments::build_stability_input(build_kuhn_cube(2, 0.2, 3), options);
    write_medit(folder_ / "in.mesh", input.mesh);
    write_file_atomically(folder_ / "problem.json", stability_to_json(input.problem).dump());
    Request request;
    request.contest = "stability";
    request.method = method;
    request.input = folder_ / "in.mesh";
    request.problem = folder_ / "problem.json";
    request.output = folder_ / "history.json";
    request.options = experiments::own_options(options);
    return run_extreme(request).report;
  }

  /// What the last request wrote.
  json history() const { return read_json_file(folder_ / "history.json"); }

  std::string error(const std::string& method, const json& options) const {
    try {
      report(method, options);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  }

  json ending(const std::string& method, json options) const {
    options["task"] = "run";
    const json out = report(method, options);
    EXPECT_EQ(out.at("runs").size(), 1U);
    EXPECT_EQ(out.at("outcome"), out.at("runs")[0].at("outcome"));
    return out.at("outcome");
  }

  test::ScratchFolder folder_;
};

TEST_F(ExtremeRunTest, MeasuresWhatIsPredictedAndFailsBeyond) {
  for (const char* method : {"motion.explicit_euler", "motion.symplectic_euler", "motion.velocity_verlet",
                             "motion.runge_kutta_4", "motion.plain_double", "motion.plain_float"}) {
    const json out = report(method, {{"steps", 500}, {"damping_ratio", 0.2}});
    EXPECT_NEAR(out.at("measured_over_predicted").get<double>(), 1.0, 0.02) << method;
    ASSERT_EQ(out.at("runs").size(), 4U);
    const auto& first = out.at("runs")[0].at("outcome");
    EXPECT_TRUE(first == "steady" || first == "oscillating") << method << ": " << first;
    EXPECT_EQ(out.at("runs")[3].at("outcome"), "diverged") << method;
    EXPECT_TRUE(out.at("runs")[3].at("vertex").is_number());
    EXPECT_GT(out.at("runs")[3].at("time_s").get<double>(), 0.0);
    // No number that is none becomes null without a reason: what is there is finite or null.
    EXPECT_THAT(out.dump(), testing::Not(HasSubstr("nan")));
  }
}

TEST_F(ExtremeRunTest, ImplicitOnesHaveNoBound) {
  for (const char* method : {"motion.implicit_euler", "motion.prefactored", "motion.backward_euler",
                             "motion.bdf2", "motion.trapezoidal", "motion.xpbd", "motion.vbd"}) {
    SCOPED_TRACE(method);
    const json out = report(method, {{"steps", 100}});
    EXPECT_TRUE(out.at("predicted_step_s").is_null());
    EXPECT_TRUE(out.at("measured_step_s").is_null());
    EXPECT_TRUE(out.at("measured_unstable_s").is_null());
    EXPECT_GT(out.at("measured_stable_s").get<double>(),
              10.0 * out.at("symplectic_row_sum_step_s").get<double>());
    for (const json& run : out.at("runs")) EXPECT_NE(run.at("outcome"), "diverged");
  }
}

TEST_F(ExtremeRunTest, EveryEndingCanBeReached) {
  const std::string euler = "motion.symplectic_euler";
  EXPECT_EQ(ending(euler, {{"strain", 0.0}}), "steady");
  EXPECT_EQ(ending(euler, {{"damping", "none"}}), "oscillating");
  EXPECT_EQ(ending("motion.explicit_euler", {{"damping", "none"}, {"step_factor", 0.1}}), "energy_growing");
  EXPECT_EQ(ending(euler, {{"step_factor", 3.0}}), "diverged");
  EXPECT_EQ(ending(euler, {{"start", "invert"}, {"strain", 1.0}, {"step_factor", 0.2}}), "inverted");
  EXPECT_EQ(ending(euler, {{"step_factor", 1e250}}), "non_finite");
  EXPECT_EQ(ending(euler, {{"time_limit_s", 0.0}}), "too_slow");
}

TEST_F(ExtremeRunTest, ExplicitEulerBeyondItsBoundIsNeverCalledFine) {
  // With these ratios it takes some thousand, some million and some 1e12 steps to grow visibly.
  for (const double ratio : {5e-3, 5e-5, 5e-8}) {
    const json out = report("motion.explicit_euler", {{"damping_ratio", ratio}});
    for (std::size_t k = 1; k < 4; ++k) {
      const json& run = out.at("runs")[k];
      EXPECT_TRUE(run.at("outcome") == "energy_growing" || run.at("outcome") == "growing_slowly" ||
                  run.at("outcome") == "diverged")
          << ratio << ": " << run.dump();
      // Where growth is named alone, it is what the step's own matrix says, or the bound where rounding hides
      // it.
      if (run.at("outcome") == "growing_slowly" && ratio > 1e-6) {
        EXPECT_GT(run.at("growth_per_step").get<double>(), 0.0);
      }
    }
  }
  const json within = report("motion.explicit_euler", {{"task", "run"}, {"step_factor", 0.98}});
  EXPECT_TRUE(within.at("runs")[0].at("growth_per_step").is_null());
  EXPECT_EQ(within.at("runs")[0].at("steps"), 1000);
}

TEST_F(ExtremeRunTest, TetrahedraInThePlaceOfSprings) {
  const json body{
      {"tets", "stable_neo_hookean"}, {"poisson_ratio", 0.45}, {"damping", "stiffness"}, {"steps", 100}};
  for (const char* method : {"motion.backward_euler", "motion.xpbd", "motion.vbd"}) {
    const json out = report(method, body);
    EXPECT_EQ(out.at("springs"), 0);
    for (const json& run : out.at("runs")) {
      EXPECT_NE(run.at("outcome"), "diverged") << method;
      EXPECT_NE(run.at("outcome"), "inverted") << method;
    }
  }
  EXPECT_THROW(report("motion.xpbd", {{"tets", "stable_neo_hookean"}, {"damping", "axial"}}), InputError);
  EXPECT_THROW(
      report("motion.xpbd", {{"tets", "stable_neo_hookean"}, {"volume", "tet"}, {"poisson_ratio", 0.4}}),
      InputError);
}

TEST_F(ExtremeRunTest, ContinuaOnTheTetEngineKeepTheirPredictedStep) {
  for (const char* law : {"linear", "corotated", "neo_hookean", "stable_neo_hookean"}) {
    for (const char* smoothing : {"none", "edge_node"}) {
      SCOPED_TRACE(std::string(law) + " " + smoothing);
      for (const char* method : {"motion.tets_double", "motion.tets_float", "motion.symplectic_euler"}) {
        const json out = report(method, {{"tets", law},
                                         {"smoothing", smoothing},
                                         {"poisson_ratio", 0.4},
                                         {"damping", "stiffness"},
                                         {"steps", 300}});
        EXPECT_NEAR(out.at("measured_over_predicted").get<double>(), 1.0, 0.02) << method;
        const auto& first = out.at("runs")[0].at("outcome");
        EXPECT_TRUE(first == "steady" || first == "oscillating") << method << ": " << first;
        EXPECT_TRUE(out.at("runs")[3].at("outcome") == "diverged" ||
                    out.at("runs")[3].at("outcome") == "non_finite" ||
                    out.at("runs")[3].at("outcome") == "energy_growing")
            << method << out.at("runs")[3].at("outcome");
      }
    }
  }
  EXPECT_THAT(error("motion.tets_float", json::object()), HasSubstr("strain energies"));
  EXPECT_THAT(error("motion.tets_float", {{"smoothing", "edge_node"}}), HasSubstr("none without tets"));
}

TEST_F(ExtremeRunTest, DampingOfTetrahedraKnowsNoFactorOfTheStiffness) {
  const BodyModel tets{"uniform", "none", "linear"};
  const auto damping_of = [&](double factor) {
    const BuiltBody body =
        build_extreme_body(make_task({{"damping", "stiffness"}, {"stiffness_factor", factor}}), tets);
    return body.model.strain_damping_s * body.model.elastic.strain_terms[0].moduli.mu_pa;
  };
  EXPECT_NEAR(damping_of(1e3), damping_of(1.0), 1e-12 * damping_of(1.0));
}

TEST_F(ExtremeRunTest, ModesHaveNoLongestStep) {
  for (const char* damping : {"none", "stiffness", "mass"}) {
    SCOPED_TRACE(damping);
    const json out = report("motion.modal", {{"tets", "linear"}, {"damping", damping}, {"steps", 200}});
    EXPECT_TRUE(out.at("predicted_step_s").is_null());
    EXPECT_TRUE(out.at("measured_step_s").is_null());
    EXPECT_GT(out.at("measured_stable_s").get<double>(),
              10.0 * out.at("symplectic_row_sum_step_s").get<double>());
    for (const json& run : out.at("runs")) {
      const auto& ending = run.at("outcome");
      EXPECT_TRUE(ending == "steady" || ending == "oscillating") << run.dump();
    }
  }
  // Short steps see the energy swing too, and none comes in.
  for (const double factor : {1e-3, 1e-2, 0.1, 10.0}) {
    const json out = report(
        "motion.modal",
        {{"tets", "linear"}, {"damping", "none"}, {"task", "run"}, {"steps", 300}, {"step_factor", factor}});
    const json& run = out.at("runs")[0];
    EXPECT_EQ(run.at("outcome"), "oscillating") << factor;
    EXPECT_NEAR(run.at("energy_most_j").get<double>(), run.at("energy_start_j").get<double>(),
                1e-9 * run.at("energy_start_j").get<double>())
        << factor;
  }
  const json heavy = report(
      "motion.modal", {{"tets", "linear"}, {"damping", "stiffness"}, {"mass_ratio", 1e6}, {"steps", 200}});
  for (const json& run : heavy.at("runs")) EXPECT_NE(run.at("outcome"), "energy_growing");
  EXPECT_THAT(error("motion.modal", json::object()), HasSubstr("tets: expected linear"));
  EXPECT_THAT(error("motion.modal", {{"tets", "corotated"}, {"damping", "none"}}),
              HasSubstr("tets: expected linear"));
  EXPECT_THAT(error("motion.modal", {{"tets", "linear"}, {"smoothing", "edge_node"}, {"damping", "none"}}),
              HasSubstr("tets: expected linear"));
  EXPECT_THAT(error("motion.modal", {{"tets", "linear"}, {"damping", "drag"}}), HasSubstr("damping"));
  EXPECT_THAT(error("motion.modal", {{"tets", "linear"}, {"damping", "mass"}, {"mass_ratio", 2.0}}),
              HasSubstr("mass_ratio"));
  EXPECT_THAT(error("motion.modal", {{"tets", "linear"}, {"damping", "none"}, {"held", "none"}}),
              HasSubstr("held"));
  EXPECT_THAT(error("motion.modal", {{"tets", "linear"}, {"damping", "none"}, {"regime", "large"}}),
              HasSubstr("modes are linear"));
}

TEST_F(ExtremeRunTest, StepsWithoutASolutionAreCounted) {
  const json out = report("motion.prefactored", {{"task", "run"}, {"steps", 10}, {"step_factor", 100.0}});
  EXPECT_EQ(out.at("runs")[0].at("steps_unsolved"), 10);
  EXPECT_EQ(
      report("motion.symplectic_euler", {{"task", "run"}, {"steps", 10}}).at("runs")[0].at("steps_unsolved"),
      0);
}

TEST_F(ExtremeRunTest, AStronglyDampedBodyBeyondItsBoundGrowsAndThenComesToRestAgain) {
  const json out =
      report("motion.symplectic_euler",
             {{"task", "run"}, {"stiffness_factor", 1e-9}, {"step_factor", 1.05}, {"steps", 2000}});
  const json& run = out.at("runs")[0];
  EXPECT_EQ(run.at("outcome"), "energy_growing");
  EXPECT_GT(run.at("energy_most_j").get<double>(), 1e9 * run.at("energy_start_j").get<double>());
  EXPECT_LT(run.at("kinetic_end_j").get<double>(), 1e-9 * run.at("energy_most_j").get<double>());
  EXPECT_GT(run.at("drift_over_size").get<double>(), 0.01);  // in another shape
}

TEST_F(ExtremeRunTest, ExtremesLeaveNumbersOrNull) {
  const std::vector<json> settings{{{"stiffness_factor", 0.0}},   {{"mass_factor", 1e-100}},
                                   {{"mass_factor", 1e100}},      {{"damping_ratio", 1e100}},
                                   {{"strain", 1e100}},           {{"start", "stretch"}, {"strain", -1.0}},
                                   {{"coordinate_scale", 1e-30}}, {{"coordinate_scale", 1e30}},
                                   {{"size_ratio", 1e4}},         {{"held", "none"}}};
  for (json options : settings) {
    options["task"] = "run";
    options["steps"] = 50;
    for (const char* method :
         {"motion.symplectic_euler", "motion.runge_kutta_4", "motion.implicit_euler", "motion.plain_float"}) {
      const json out = report(method, options);
      EXPECT_TRUE(out.at("outcome").is_string()) << method << " " << options.dump();
      EXPECT_TRUE(json::parse(out.dump()) == out) << method << " " << options.dump();  // nothing became null
    }
  }
}

TEST_F(ExtremeRunTest, LargeDeformationsAreMeasuredFromTheirStart) {
  const json out = report(
      "motion.symplectic_euler",
      {{"regime", "large"}, {"start", "stretch"}, {"strain", 1.0}, {"steps", 400}, {"damping", "none"}});
  EXPECT_EQ(out.at("measured_by"), "runs");
  EXPECT_LT(out.at("measured_over_predicted").get<double>(), 1.0);
  EXPECT_LT(out.at("predicted_at_start_s").get<double>(), out.at("predicted_step_s").get<double>());
}

TEST_F(ExtremeRunTest, BadRequestsNameWhatIsWrong) {
  EXPECT_THAT(error("motion.leapfrog", json::object()), HasSubstr("symplectic_euler"));
  EXPECT_THAT(error("springs.uniform", json::object()), HasSubstr("motion.INTEGRATOR"));
  EXPECT_THAT(error("motion.plain_float", {{"volume", "tet"}, {"poisson_ratio", 0.4}}), HasSubstr("strain"));
  EXPECT_THAT(error("motion.runge_kutta_4", {{"mass_factor", 0.0}}), HasSubstr("mass_factor: expected"));
  EXPECT_THAT(error("motion.runge_kutta_4", {{"mass_factor", -1.0}}), HasSubstr("mass_factor"));
  EXPECT_THAT(error("motion.runge_kutta_4", {{"step_factor", 0.0}}), HasSubstr("step_factor: expected"));
  EXPECT_THAT(error("motion.runge_kutta_4", {{"step_factor", nullptr}}), HasSubstr("step_factor"));
  EXPECT_THAT(error("motion.runge_kutta_4", {{"mass_factor", 1e-303}}), HasSubstr("over mass"));
  EXPECT_THAT(error("motion.runge_kutta_4", {{"steps", 0}}), HasSubstr("steps"));
  EXPECT_THAT(error("motion.runge_kutta_4", {{"springs", "rubber"}}), HasSubstr("isotropy_patch"));
  EXPECT_THAT(error("motion.runge_kutta_4", {{"colour", 1}}), HasSubstr("colour"));
}

}  // namespace
}  // namespace palpate::reference
