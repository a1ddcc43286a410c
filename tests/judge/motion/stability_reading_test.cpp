// The judge's reading of runs and trials at one time step, on histories made by hand whose ending is known.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "core/base/error.h"
#include "core/judge/motion/stability_reading.h"

namespace palpate::judge {
namespace {

using testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// One tet with sides of 1 along the axes, far from the origin.
TetMesh make_tet() {
  const Vec3 at{1e3, 0.0, 0.0};
  return {{at, at + Vec3{1, 0, 0}, at + Vec3{0, 1, 0}, at + Vec3{0, 0, 1}}, {{0, 1, 2, 3}}};
}

/// 400 steps in rows of 10, with the kinetic and the elastic energy as functions of the share of the steps
/// that is over.
RunHistory make_run(const std::function<double(double)>& kinetic,
                    const std::function<double(double)>& elastic) {
  RunHistory run;
  run.step_s = 1e-3;
  run.steps = 400;
  for (std::uint64_t step = 0; step <= run.steps; step += 10) {
    HistoryRow row;
    row.step = step;
    row.time_s = static_cast<double>(step) * run.step_s;
    const double share = static_cast<double>(step) / static_cast<double>(run.steps);
    row.kinetic_j = row.most_kinetic_j = kinetic(share);
    row.elastic_j = elastic(share);
    row.load_j = 0.0;
    row.most_total_j = row.least_total_j = row.kinetic_j + row.elastic_j;
    row.farthest_m = 0.0;
    run.rows.push_back(row);
  }
  run.displacement_m.resize(4);
  return run;
}

RunHistory make_oscillation(double decay) {
  const auto wave = [=](double share) { return std::exp(-decay * share); };
  return make_run([=](double s) { return wave(s) * std::pow(std::sin(100.0 * s), 2); },
                  [=](double s) { return wave(s) * std::pow(std::cos(100.0 * s), 2); });
}

RunHistory make_growth(double rate) {
  return make_run([=](double s) { return std::exp(rate * s); }, [=](double s) { return std::exp(rate * s); });
}

void displace(RunHistory& run, std::size_t vertex, const Vec3& u) {
  run.displacement_m[vertex] = u;
  double farthest = 0.0;
  for (const Vec3& each : run.displacement_m) farthest = std::max(farthest, length(each));
  run.rows.back().farthest_m = farthest;
}

std::string ending_of(const RunHistory& run, const RunBounds& bounds = {}) {
  check_history(run, make_tet(), "run");
  return ending_name(read_run(run, make_tet(), bounds).ending);
}

TEST(StabilityReading, MotionThatDiesOutIsSteadyAndMotionThatGoesOnOscillates) {
  EXPECT_EQ(ending_of(make_oscillation(40.0)), "steady");
  EXPECT_EQ(ending_of(make_oscillation(2.0)), "oscillating");
  EXPECT_EQ(ending_of(make_oscillation(0.0)), "oscillating");
  const RunBounds noisy{100.0, 10.0};
  EXPECT_EQ(ending_of(make_oscillation(0.0), noisy), "steady");  // rounding moves as much
}

TEST(StabilityReading, GrowthIsSeenInTheLastQuarterOrByItsSize) {
  EXPECT_EQ(ending_of(make_growth(1.0)), "energy_growing");
  EXPECT_EQ(ending_of(make_growth(0.2)), "oscillating");  // 5% over a quarter: less than 1.1 times
  // What grew and came to rest again is known by how much it had.
  const auto hill = [](double s) { return 1.0 + 500.0 * std::exp(-std::pow(20.0 * (s - 0.3), 2)); };
  const auto fall = [](double s) { return s < 0.5 ? 1.0 : 1e-9; };
  EXPECT_EQ(ending_of(make_run(fall, hill)), "energy_growing");
  EXPECT_EQ(ending_of(make_run(fall, hill), {1000.0, 0.0}), "steady");
}

TEST(StabilityReading, AKnownGrowthThatDoesNotShowIsNamed) {
  RunHistory run = make_oscillation(0.0);
  run.says_growing = true;
  EXPECT_EQ(ending_of(run), "growing_slowly");
  run = make_growth(1.0);
  run.says_growing = true;
  EXPECT_EQ(ending_of(run), "energy_growing");  // it does show
}

TEST(StabilityReading, AVertexAThousandSizesAwayHasDivergedWhateverTheEnergies) {
  RunHistory run = make_oscillation(0.0);
  displace(run, 2, {999.0, 0, 0});
  EXPECT_EQ(ending_of(run), "oscillating");
  displace(run, 2, {0, 1001.0, 0});
  EXPECT_EQ(ending_of(run), "diverged");
  EXPECT_EQ(read_run(run, make_tet(), {}).vertex, 2U);
  run.rows.resize(20);  // and is not too slow for having ended
  displace(run, 2, {0, 1001.0, 0});
  EXPECT_EQ(ending_of(run), "diverged");
}

TEST(StabilityReading, TurnedAndFlatTetsAreCountedFromTheDisplacement) {
  RunHistory run = make_oscillation(0.0);
  displace(run, 3, {0, 0, -2.0});
  EXPECT_EQ(ending_of(run), "inverted");
  EXPECT_EQ(read_run(run, make_tet(), {}).inverted, 1U);
  displace(run, 3, {0, 0, -1.0});
  EXPECT_EQ(ending_of(run), "inverted");
  displace(run, 3, {0, 0, -0.99});
  EXPECT_EQ(ending_of(run), "oscillating");
  run = make_growth(1.0);
  displace(run, 3, {0, 0, -2.0});
  EXPECT_EQ(ending_of(run), "energy_growing");
}

TEST(StabilityReading, WhatIsNoNumberNeverPassesForOne) {
  RunHistory run = make_oscillation(40.0);
  run.displacement_m[1].y = kNan;
  EXPECT_EQ(ending_of(run), "non_finite");
  EXPECT_EQ(read_run(run, make_tet(), {}).vertex, 1U);
  run = make_oscillation(40.0);
  run.rows.back().is_finite = false;  // a velocity
  EXPECT_EQ(ending_of(run), "non_finite");
  // Energies that an inverted tet has none of are left out; what is seen of the others stands.
  run = make_growth(1.0);
  run.rows[7].elastic_j = run.rows[7].most_total_j = run.rows[7].least_total_j = kNan;
  EXPECT_EQ(ending_of(run), "energy_growing");
}

TEST(StabilityReading, ARunThatBreaksOffWithoutAReasonWasTooSlow) {
  RunHistory run = make_oscillation(0.0);
  run.rows.resize(20);
  EXPECT_EQ(ending_of(run), "too_slow");
}

std::string error_of(RunHistory run) {
  try {
    check_history(run, make_tet(), "runs[0]");
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(StabilityReading, HistoriesThatAreNoneAreRefused) {
  const auto error_with = [](const std::function<void(RunHistory&)>& change) {
    RunHistory run = make_oscillation(0.0);
    change(run);
    return error_of(run);
  };
  EXPECT_EQ(error_with([](RunHistory&) {}), "no error");
  EXPECT_THAT(error_with([](RunHistory& run) { run.step_s = kNan; }), HasSubstr("a step above zero"));
  EXPECT_THAT(error_with([](RunHistory& run) { run.steps = 0; }), HasSubstr("at least one step"));
  EXPECT_THAT(error_with([](RunHistory& run) { run.rows.clear(); }), HasSubstr("rows from step 0 on"));
  EXPECT_THAT(error_with([](RunHistory& run) { run.rows.erase(run.rows.begin() + 5, run.rows.begin() + 7); }),
              HasSubstr("runs[0]: expected a row at least every 20 steps, found none between 40 and 70"));
  EXPECT_THAT(error_with([](RunHistory& run) { std::swap(run.rows[3], run.rows[4]); }),
              HasSubstr("steps that rise"));
  EXPECT_THAT(error_with([](RunHistory& run) { run.rows[3].time_s = 0.5; }),
              HasSubstr("step 30: expected the time"));
  EXPECT_THAT(error_with([](RunHistory& run) { run.rows[3].kinetic_j = -1.0; }), HasSubstr("not negative"));
  EXPECT_THAT(error_with([](RunHistory& run) { run.rows[3].most_kinetic_j = 0.0; }),
              HasSubstr("above its greatest"));
  EXPECT_THAT(error_with([](RunHistory& run) { run.rows[3].inverted = 2; }), HasSubstr("at most 1 inverted"));
  EXPECT_THAT(error_with([](RunHistory& run) { run.rows[3].is_finite = false; }), HasSubstr("not finite"));
  EXPECT_THAT(error_with([](RunHistory& run) { run.rows[3].unsolved = 2; }), HasSubstr("become fewer"));
  EXPECT_THAT(error_with([](RunHistory& run) { run.displacement_m.pop_back(); }), HasSubstr("4 vertices"));
  EXPECT_THAT(error_with([](RunHistory& run) { run.displacement_m[0].x = 0.5; }),
              HasSubstr("farthest vertex"));
  EXPECT_THAT(error_with([](RunHistory& run) { run.rows.back().farthest_m = kNan; }),
              HasSubstr("farthest vertex"));
}

TEST(StabilityReading, TheEnergyOfRoundingIsThatOfAStrainedBody) {
  // A sixth of a cubic metre, lambda = mu = 0.4 E at Poisson's ratio 1/4.
  EXPECT_NEAR(rounding_energy(make_tet(), 10.0, 0.25, 2.0, 1e-3), 3.0 * 1.2 * 10.0 * 2.0 / 6.0 * 1e-6, 1e-18);
}

/// Stretches to 256, 512, ... with these means, and peaks twice as large.
TrialHistory make_trial(const std::vector<double>& means) {
  TrialHistory trial;
  trial.step_s = 1e-3;
  trial.start_j = 1.0;
  std::uint64_t until = 256;
  for (const double mean : means) {
    trial.stretches.push_back({until, mean, 2.0 * mean});
    until *= 2;
  }
  return trial;
}

TrialEnding trial_ending(const TrialHistory& trial, std::uint64_t horizon = 4096) {
  return read_trial(trial, {1e6, horizon}, "bracket.lower");
}

TEST(StabilityReading, TrialsAreStableOnceTheirMotionIsBounded) {
  EXPECT_EQ(trial_ending(make_trial({1.0, 1.0, 1.0})), TrialEnding::kStable);
  EXPECT_EQ(trial_ending(make_trial({1.0, 3.0, 5.0, 5.05})), TrialEnding::kStable);
  EXPECT_EQ(trial_ending(make_trial({1.0, 1e-30})), TrialEnding::kStable);
  EXPECT_EQ(trial_ending(make_trial({1.0, 1.5, 2.1, 2.6, 2.9})), TrialEnding::kStable);  // ratios fall
  EXPECT_EQ(trial_ending(make_trial({1.0, 1.0})), TrialEnding::kStable);
  EXPECT_EQ(trial_ending(make_trial({1.0, 1.5, 2.1})), TrialEnding::kTooShort);  // ratios fall, but soon
  EXPECT_EQ(trial_ending(make_trial({1.0})), TrialEnding::kTooShort);
  EXPECT_EQ(trial_ending(make_trial({})), TrialEnding::kTooShort);
}

TEST(StabilityReading, TrialsGrowFastOrSlowlyOrBeyondAllNumbers) {
  EXPECT_EQ(trial_ending(make_trial({1.0, 1001.0})), TrialEnding::kGrows);
  EXPECT_EQ(trial_ending(make_trial({1.0, 1.03, 1.07, 1.15, 1.40})), TrialEnding::kGrows);
  EXPECT_EQ(trial_ending(make_trial({1.0, 1.03})), TrialEnding::kGrows);
  EXPECT_EQ(trial_ending(make_trial({1.0, kNan})), TrialEnding::kGrows);
  EXPECT_EQ(trial_ending(make_trial({std::numeric_limits<double>::infinity()})), TrialEnding::kGrows);
  TrialHistory peak = make_trial({1.0, 1.0, 1.0});
  peak.stretches[1].most_kinetic_j = 2e6;
  EXPECT_EQ(trial_ending(peak), TrialEnding::kGrows);
  peak.stretches[1].most_kinetic_j = kNan;
  EXPECT_EQ(trial_ending(peak), TrialEnding::kGrows);
  TrialHistory nothing = make_trial({1.0, 1.0, 1.0});
  nothing.start_j = kNan;
  EXPECT_EQ(trial_ending(nothing), TrialEnding::kGrows);
  // Where forces are not linear, only what exceeds the start for certain counts.
  TrialHistory large = make_trial({1.0, 30.0, 90.0});
  large.is_linear = false;
  EXPECT_EQ(trial_ending(large), TrialEnding::kStable);
}

TEST(StabilityReading, StretchesHaveTheirPlaces) {
  TrialHistory trial = make_trial({1.0, 1.0, 1.0});
  trial.stretches.erase(trial.stretches.begin() + 1);
  EXPECT_THROW(trial_ending(trial), InputError);
}

}  // namespace
}  // namespace palpate::judge
