// reduced.ticks as the runner starts it: forces of a rod in closed form, and what it refuses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "reference/door/json_file.h"
#include "reference/door/moving_body.h"
#include "tests/support/contestant_starter.h"
#include "tests/support/rod.h"

namespace palpate::reference {
namespace {

using experiments::ContestantAnswer;
using nlohmann::json;
using testing::HasSubstr;

class ReducedTicks : public testing::Test {
 protected:
  ReducedTicks() {
    // Without Poisson's ratio the rod needs no sides that hold it.
    rod_.problem.body.material.poisson_ratio = 0.0;
    rod_.problem.body.held = {{rod_.left(), {true, true, true}, {}}};
    pad_ = rod_.pad(3.0 * per_area(), -1e-3);
    pad_.profile = {{0.0, 0.05}, {0.0, 1.0}, false};
    rod_.problem.loads = {pad_};
    rod_.problem.duration_s = 1.0;
  }

  /// The rod's stiffness a unit of its end, in Pa/m.
  double per_area() const { return rod_.modulus_pa() / test::Rod::kLengthM; }

  ContestantAnswer ask(const json& options) {
    MovingBody body;
    body.motion = rod_.problem;
    body.model.method = "springs.van_gelder";
    return starter_.run("reduced.ticks", rod_.mesh, moving_body_to_json(body), options);
  }

  test::ContestantStarter starter_;
  test::Rod rod_{6};
  MotionLoad pad_;
};

TEST_F(ReducedTicks, TheForceFollowsThePadAndEndsAtTheStaticReaction) {
  const ContestantAnswer answer = ask({{"ticks", 100}, {"precision", "double"}, {"elements", "p1"}});
  ASSERT_EQ(answer.outcome, "ok") << answer.message;
  const json file = read_json_file(answer.output);
  // Two springs in series, the rod and three times as stiff a pad. Linear tractions are exact for linear
  // elements.
  const double expected = 0.75 * per_area() * -1e-3 * test::Rod::kAreaM2;
  ASSERT_EQ(file.at("rows").size(), 110U);
  for (std::size_t k = 0; k < 110; ++k) {
    const double share = std::min(static_cast<double>(k + 1) / 50.0, 1.0);
    EXPECT_NEAR(file.at("rows")[k][1].get<double>(), share * expected, 1e-6 * std::fabs(expected)) << k;
    EXPECT_NEAR(file.at("rows")[k][2].get<double>(), 0.0, 1e-6 * std::fabs(expected));
  }
  ASSERT_EQ(file.at("held_forces_n").size(), 11U);
  EXPECT_NEAR(file.at("held_forces_n")[0][0].get<double>(), expected, 1e-6 * std::fabs(expected));
  EXPECT_EQ(answer.report.at("ticks"), 100);
  EXPECT_EQ(answer.report.at("outcome"), "completed");
  EXPECT_GT(answer.report.at("tick_p50_s").get<double>(), 0.0);
  EXPECT_GT(answer.report.at("skin_table_bytes").get<double>(), 0.0);
}

TEST_F(ReducedTicks, SinglePrecisionAndAMovingSkinGiveTheSameForces) {
  const json exact = read_json_file(ask({{"ticks", 100}, {"precision", "double"}}).output);
  const json quick = read_json_file(ask({{"ticks", 100}, {"skin", true}}).output);
  const double size = std::fabs(exact.at("held_forces_n")[0][0].get<double>());
  EXPECT_NEAR(quick.at("held_forces_n")[0][0].get<double>(), exact.at("held_forces_n")[0][0].get<double>(),
              1e-4 * size);
}

TEST_F(ReducedTicks, WhatCannotBeIsRefused) {
  const auto refused = [&](const json& options, const std::string& reason) {
    const ContestantAnswer answer = ask(options);
    EXPECT_EQ(answer.outcome, "bad_input") << reason;
    EXPECT_THAT(answer.message, HasSubstr(reason));
  };
  refused({{"ticks", 1}}, "ticks");
  refused({{"steps_per_tick", 2}}, "steps_per_tick");
  rod_.problem.loads = {pad_, pad_};
  refused({{"ticks", 100}}, "one tool");
  rod_.problem.loads = {pad_};
  rod_.problem.loads[0].until_s = 0.5;
  refused({{"ticks", 100}}, "comes or goes");
  rod_.problem.loads = {rod_.sine_force(10.0)};
  refused({{"ticks", 100}}, "one tool");
  rod_.problem.loads = {pad_};
  rod_.problem.body.held.push_back({rod_.right(), {false, true, true}, {}});
  refused({{"ticks", 100}}, "touches nothing else");
  rod_.problem.body.held.pop_back();
  rod_.problem.body.strain = StrainSize::kLarge;
  rod_.problem.loads[0].part.strain = StrainSize::kLarge;
  const ContestantAnswer answer = ask({{"ticks", 100}});
  EXPECT_EQ(answer.outcome, "ok") << answer.message;
  EXPECT_THAT(answer.notes, testing::Contains(HasSubstr("taken for small ones")));
}

}  // namespace
}  // namespace palpate::reference
