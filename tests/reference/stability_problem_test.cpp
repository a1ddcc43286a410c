// The problem of the contest stability as a file: what is written reads back to the bit, and what is wrong is
// named.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "core/base/error.h"
#include "core/mesh/shapes/shapes.h"
#include "experiments/contests/stability/stability_input.h"
#include "reference/door/json_file.h"
#include "reference/door/stability_problem.h"

namespace palpate::reference {
namespace {

using nlohmann::json;
using testing::HasSubstr;

experiments::StabilityInput make_input() {
  return experiments::build_stability_input(
      build_kuhn_cube(2, 0.2, 3),
      {{"mass_ratio", 1e6}, {"start", "stretch"}, {"strain", -0.3}, {"damping", "drag"}, {"seed", 7}});
}

TEST(StabilityProblem, ReadsBackToTheSameBits) {
  const auto input = make_input();
  const std::string text = stability_to_json(input.problem).dump();
  const StabilityProblem read = stability_from_json(parse_json(text, "problem"), input.mesh, "problem");
  EXPECT_EQ(read.mass_factors, input.problem.mass_factors);
  EXPECT_EQ(read.start_m, input.problem.start_m);
  EXPECT_EQ(read.held, input.problem.held);
  EXPECT_EQ(read.damping, DampingLaw::kDrag);
  EXPECT_EQ(read.seed, 7U);
  EXPECT_EQ(stability_to_json(read).dump(), text);
}

TEST(StabilityProblem, HoldsOneEndAndStartsTheRest) {
  const auto input = make_input();
  ASSERT_FALSE(input.problem.held.empty());
  for (const Index v : input.problem.held) EXPECT_EQ(input.problem.start_m[v], Vec3{});
  double farthest = 0.0;
  for (const Vec3& u : input.problem.start_m) farthest = std::max(farthest, -u.x);
  EXPECT_NEAR(farthest, 0.3 * 0.1, 1e-12);
  EXPECT_THROW(
      experiments::build_stability_input(build_kuhn_cube(2, 0.2, 3), {{"strain", 1e308}, {"size_m", 100.0}}),
      InputError);
}

TEST(StabilityProblem, WhatIsWrongIsNamed) {
  const auto input = make_input();
  const auto error_with = [&](const std::function<void(json&)>& change) -> std::string {
    json problem = stability_to_json(input.problem);
    change(problem);
    try {
      stability_from_json(problem, input.mesh, "problem.json");
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_EQ(error_with([](json&) {}), "no error");
  EXPECT_THAT(error_with([](json& p) { p["schema"] = "palpate/problem/1"; }),
              HasSubstr("problem.json: schema"));
  EXPECT_THAT(error_with([](json& p) { p.erase("held"); }), HasSubstr("the key \"held\""));
  EXPECT_THAT(error_with([](json& p) { p["colour"] = 1; }), HasSubstr("no key \"colour\""));
  EXPECT_THAT(error_with([](json& p) { p["mass_factors"].erase(0); }),
              HasSubstr("mass_factors: expected a list of 27"));
  EXPECT_THAT(error_with([](json& p) { p["mass_factors"][3] = 0.0; }), HasSubstr("a number above zero"));
  EXPECT_THAT(error_with([](json& p) { p["mass_factors"][3] = nullptr; }), HasSubstr("a finite number"));
  EXPECT_THAT(error_with([](json& p) { p["stiffness_factor"] = std::numeric_limits<double>::quiet_NaN(); }),
              HasSubstr("stiffness_factor: expected a finite number"));
  EXPECT_THAT(error_with([](json& p) { p["material"]["poisson_ratio"] = 0.5; }),
              HasSubstr("between -1 and 0.5"));
  EXPECT_THAT(error_with([](json& p) { p["damping"]["law"] = "viscous"; }), HasSubstr("found \"viscous\""));
  EXPECT_THAT(error_with([](json& p) { p["held"] = {3, 3}; }), HasSubstr("that rise"));
  EXPECT_THAT(error_with([](json& p) { p["held"] = {99}; }), HasSubstr("below 27"));
  EXPECT_THAT(error_with([](json& p) {
                p["start_m"][p["held"][0].get<std::size_t>()] = {1, 0, 0};
              }),
              HasSubstr("zeros where the body is held"));
  EXPECT_THAT(error_with([](json& p) { p["start_m"][0] = {1, 0}; }), HasSubstr("three numbers"));
  EXPECT_THAT(error_with([](json& p) { p["seed"] = -1; }), HasSubstr("seed"));
}

TEST(StabilityProblem, BelongsToItsContest) {
  Request request;
  request.contest = "motion";
  EXPECT_THROW(read_stability_task(request), InputError);
}

}  // namespace
}  // namespace palpate::reference
