// Fitted oscillations, on signals in closed form.
#include "core/judge/motion/oscillation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "core/base/error.h"
#include "tests/support/angles.h"
#include "tests/support/signals.h"

namespace palpate::judge {
namespace {

using test::kPi;
using test::ringing;
using test::times;
using test::values;

TEST(Oscillation, IsFoundExactlyWhereItIsOne) {
  const std::vector<double> t = times(2.0, 700);
  for (const double hz : {0.9, 7.3, 40.0}) {
    for (const double decay : {-0.2, 0.0, 0.8, 4.0}) {
      SCOPED_TRACE(std::to_string(hz) + " Hz, decay " + std::to_string(decay));
      const OscillationFit fit = *fit_oscillations(t, values(t, ringing(hz, decay)), {0.0, 2.0}, 3);
      ASSERT_EQ(fit.oscillations.size(), 1U);
      EXPECT_NEAR(fit.oscillations[0].frequency_hz, hz, 1e-7 * hz);
      EXPECT_NEAR(fit.oscillations[0].decay_per_s, decay, 1e-6);
      EXPECT_NEAR(fit.oscillations[0].amplitude, 2.0, 1e-6);
      EXPECT_NEAR(fit.oscillations[0].phase_rad, 0.4, 1e-6);
      EXPECT_NEAR(fit.offset, 0.3, 1e-6);
      EXPECT_LT(fit.unexplained, 1e-6);
    }
  }
}

// Seen from the middle, the same motion has the amplitude and the phase that it has by then.
TEST(Oscillation, OfAWindow) {
  const std::vector<double> t = times(2.0, 1000);
  const Oscillation found = fit_oscillations(t, values(t, ringing(5.0, 0.9)), {1.0, 2.0}, 1)->oscillations[0];
  EXPECT_NEAR(found.amplitude, 2.0 * std::exp(-0.9), 1e-6);
  EXPECT_NEAR(found.phase_rad, 0.4, 1e-6);
  EXPECT_NEAR(found.frequency_hz, 5.0, 1e-6);
}

// Two modes that are closer than the window tells apart by itself, and a third.
TEST(Oscillation, SeveralAreToldApart) {
  const std::vector<double> t = times(0.6, 600);
  const auto mode = [](double x, double size, double hz, double decay, double phase) {
    return size * std::exp(-decay * x) * std::cos(2.0 * kPi * hz * x + phase);
  };
  const auto signal = [&](double scale) {
    return values(t, [&, scale](double x) {
      return 0.1 + mode(x, 2.0, scale * 5.1, 1.0, 0.3) + mode(x, 1.0, scale * 6.2, 1.5, -1.0) +
             mode(x, 0.4, scale * 15.0, 3.0, 2.0);
    });
  };
  const OscillationFit fit = *fit_oscillations(t, signal(1.0), {0.0, 0.6}, 3);
  ASSERT_EQ(fit.oscillations.size(), 3U);
  EXPECT_LT(fit.unexplained, 1e-5);
  EXPECT_NEAR(fit.oscillations[0].frequency_hz, 5.1, 1e-3);
  EXPECT_NEAR(fit.oscillations[0].decay_per_s, 1.0, 1e-2);
  EXPECT_NEAR(fit.oscillations[1].frequency_hz, 6.2, 1e-3);
  EXPECT_NEAR(fit.oscillations[2].amplitude, 0.4, 1e-3);
  const OscillationFit faster = *fit_oscillations_like(t, signal(1.08), {0.0, 0.6}, fit);
  OscillationFit mixed = fit;  // the start at five quarters of a frequency may end at the next one
  std::swap(mixed.oscillations[0], mixed.oscillations[1]);
  const OscillationFit other = *fit_oscillations_like(t, signal(1.08), {0.0, 0.6}, mixed);
  EXPECT_NEAR(other.oscillations[1].frequency_hz, faster.oscillations[0].frequency_hz, 1e-3);
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_NEAR(faster.oscillations[k].frequency_hz / fit.oscillations[k].frequency_hz, 1.08, 1e-3);
}

// Up to two samples a period: 340 periods in 700 samples.
TEST(Oscillation, AllFrequenciesThatTheSamplesTellApartAreScanned) {
  const std::vector<double> t = times(2.0, 700);
  for (const double hz : {110.0, 170.0}) {
    const OscillationFit fit = *fit_oscillations(t, values(t, ringing(hz, 0.5)), {0.0, 2.0}, 2);
    EXPECT_NEAR(fit.oscillations[0].frequency_hz, hz, 1e-6 * hz);
    EXPECT_LT(fit.unexplained, 1e-6);
  }
}

// A motion far from what it is held against is found where it is, not where it was expected.
TEST(Oscillation, FarFromTheReferencesItIsStillFound) {
  const std::vector<double> t = times(2.0, 800);
  const OscillationFit like = *fit_oscillations(t, values(t, ringing(9.0, 0.5)), {0.0, 2.0}, 3);
  for (const double hz : {2.0, 4.1, 31.0}) {
    const OscillationFit fit = *fit_oscillations_like(t, values(t, ringing(hz, 2.0)), {0.0, 2.0}, like);
    ASSERT_EQ(fit.oscillations.size(), like.oscillations.size());
    EXPECT_NEAR(fit.oscillations[0].frequency_hz, hz, 1e-6 * hz);
    EXPECT_NEAR(fit.oscillations[0].decay_per_s, 2.0, 1e-5);
    EXPECT_FALSE(explains_too_little(fit));
  }
}

// One of two modes is missing: the other is paired with its own, wherever that stands.
TEST(Oscillation, WhatHasNoPartnerHasNoAmplitude) {
  const std::vector<double> t = times(2.0, 800);
  const auto mode = [](double x, double size, double hz) { return size * std::cos(2.0 * kPi * hz * x); };
  const std::vector<double> both = values(t, [&](double x) { return mode(x, 2.0, 3.0) + mode(x, 1.0, 8.0); });
  const OscillationFit like = *fit_oscillations(t, both, {0.0, 2.0}, 2);
  ASSERT_EQ(like.oscillations.size(), 2U);
  const OscillationFit fit =
      *fit_oscillations_like(t, values(t, [&](double x) { return mode(x, 2.0, 3.1); }), {0.0, 2.0}, like);
  EXPECT_NEAR(fit.oscillations[0].frequency_hz, 3.1, 1e-5);
  EXPECT_NEAR(fit.oscillations[1].amplitude, 0.0, 1e-5);
}

// A frequency that runs from 2 to 40 Hz is no sum of two oscillations, and noise is none at all.
TEST(Oscillation, WhatIsNoneExplainsTooLittle) {
  const std::vector<double> t = times(2.0, 800);
  const auto sweep = [](double x) { return std::cos(2.0 * kPi * (2.0 + 9.5 * x) * x); };
  EXPECT_TRUE(explains_too_little(*fit_oscillations(t, values(t, sweep), {0.0, 2.0}, 2)));
  std::mt19937 random(3);
  std::normal_distribution<double> noise;
  std::vector<double> x(t.size());
  for (double& v : x) v = noise(random);
  EXPECT_TRUE(explains_too_little(*fit_oscillations(t, x, {0.0, 2.0}, 4)));
  EXPECT_FALSE(explains_too_little(*fit_oscillations(t, values(t, ringing(5.0, 1.0)), {0.0, 2.0}, 1)));
  OscillationFit none;
  none.unexplained = std::nan("");
  EXPECT_TRUE(explains_too_little(none));
}

// What is gone in a moment is not the strongest, however large it starts.
TEST(Oscillation, TheStrongestIsThatOfTheWholeWindow) {
  const std::vector<double> t = times(1.0, 1000);
  const std::vector<double> x = values(t, [](double s) {
    return std::cos(2.0 * kPi * 5.0 * s) + 2.0 * std::exp(-40.0 * s) * std::cos(2.0 * kPi * 30.0 * s);
  });
  const OscillationFit fit = *fit_oscillations(t, x, {0.0, 1.0}, 2);
  ASSERT_EQ(fit.oscillations.size(), 2U);
  EXPECT_NEAR(fit.oscillations[0].frequency_hz, 5.0, 1e-4);
  EXPECT_NEAR(fit.oscillations[1].amplitude, 2.0, 1e-3);
}

// Noise of a tenth of the amplitude is what is left over; the figures stay near.
TEST(Oscillation, WithNoiseSaysHowMuchItLeavesOver) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, 0.1 * std::sqrt(2.0));
  const std::vector<double> t = times(2.0, 2000);
  std::vector<double> x = values(t, ringing(5.0, 0.0));
  for (double& v : x) v += noise(random);
  const OscillationFit fit = *fit_oscillations(t, x, {0.0, 2.0}, 1);
  EXPECT_NEAR(fit.unexplained, 0.1, 0.01);
  EXPECT_NEAR(fit.oscillations[0].amplitude, 2.0, 0.05);
  EXPECT_NEAR(fit.oscillations[0].frequency_hz, 5.0, 0.01);
}

TEST(Oscillation, NothingWhereNothingMoves) {
  const std::vector<double> t = times(1.0, 100);
  EXPECT_FALSE(fit_oscillations(t, std::vector<double>(t.size(), 0.25), {0.0, 1.0}, 2));
  EXPECT_FALSE(fit_oscillations(t, values(t, ringing(3.0, 0.0)), {0.98, 1.0}, 2));
}

TEST(OscillationErrors, InClosedForm) {
  const Oscillation truth{2.0, 3.0, 10.0, 1.0};
  const Oscillation found{2.2, -3.0, 9.0, 1.5};
  const OscillationError error = compare_oscillations(found, truth);
  EXPECT_NEAR(error.amplitude, 0.1, 1e-12);
  EXPECT_NEAR(error.phase_deg, (2.0 * kPi - 6.0) * 180.0 / kPi, 1e-9);
  EXPECT_NEAR(error.frequency, -0.1, 1e-12);
  EXPECT_NEAR(*error.decay, 0.5, 1e-12);
  EXPECT_NEAR(error.damping_ratio, 1.5 / (18.0 * kPi) - 1.0 / (20.0 * kPi), 1e-12);
  Oscillation steady = truth;
  steady.decay_per_s = 0.0;
  EXPECT_FALSE(compare_oscillations(found, steady).decay);
  steady.amplitude = 0.0;
  EXPECT_THROW(compare_oscillations(found, steady), ContractError);
}

}  // namespace
}  // namespace palpate::judge
