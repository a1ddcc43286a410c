// Errors of histories, on signals in closed form.
#include "core/judge/motion_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "core/base/error.h"

namespace palpate::judge {
namespace {

constexpr double kPi = std::numbers::pi;

std::vector<double> times(double end, int intervals) {
  std::vector<double> out;
  for (int k = 0; k <= intervals; ++k) out.push_back(end * k / intervals);
  return out;
}

std::vector<double> values(const std::vector<double>& at, const std::function<double(double)>& f) {
  std::vector<double> out;
  for (const double t : at) out.push_back(f(t));
  return out;
}

/// 0.3 + 2 exp(-decay t) cos(2 pi hz t + 0.4).
std::function<double(double)> ringing(double hz, double decay) {
  return [=](double t) { return 0.3 + 2.0 * std::exp(-decay * t) * std::cos(2.0 * kPi * hz * t + 0.4); };
}

double worst_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double worst = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) worst = std::max(worst, std::fabs(a[k] - b[k]));
  return worst;
}

TEST(Sampling, OrdersTwoAndFour) {
  const std::vector<double> at = times(0.997, 331);
  const auto f = ringing(1.5, 0.7);
  std::vector<double> straight;
  std::vector<double> smooth;
  for (const int intervals : {40, 80}) {
    const std::vector<double> t = times(1.0, intervals);
    straight.push_back(worst_difference(sample_straight(t, values(t, f), at), values(at, f)));
    smooth.push_back(worst_difference(sample_smooth(t, values(t, f), at), values(at, f)));
  }
  EXPECT_NEAR(std::log2(straight[0] / straight[1]), 2.0, 0.3);
  EXPECT_NEAR(std::log2(smooth[0] / smooth[1]), 4.0, 0.4);
}

TEST(Sampling, CubicsAreExactOnUnevenTimesAndEndsStay) {
  const std::vector<double> t{0.0, 0.1, 0.35, 0.4, 0.8, 1.0};
  const auto cubic = [](double x) { return 1.0 - 2.0 * x + 3.0 * x * x - 4.0 * x * x * x; };
  const std::vector<double> at{0.0, 0.05, 0.2, 0.37, 0.5, 0.99, 1.0};
  EXPECT_LT(worst_difference(sample_smooth(t, values(t, cubic), at), values(at, cubic)), 1e-14);
  const std::vector<double> beyond{-1.0, 2.0};
  EXPECT_EQ(sample_straight(t, t, beyond), (std::vector<double>{0.0, 1.0}));
  EXPECT_THROW(sample_straight(t, at, beyond), ContractError);
  EXPECT_THROW(sample_straight({}, {}, beyond), ContractError);
}

// x = (1 + a) sin: the error is a. Shifted by an angle p: 2 sin(p / 2) over whole periods.
TEST(HistoryError, OfASineThatIsTooLargeOrTooLate) {
  const std::vector<double> t = times(2.0, 4000);
  const std::vector<std::vector<double>> truth{values(t, [](double x) { return std::sin(2.0 * kPi * x); })};
  const std::vector<std::vector<double>> large{
      values(t, [](double x) { return 1.1 * std::sin(2.0 * kPi * x); })};
  const std::vector<std::vector<double>> late{
      values(t, [](double x) { return std::sin(2.0 * kPi * x - 0.2); })};
  EXPECT_NEAR(*history_error(t, large, truth), 0.1, 1e-12);
  EXPECT_NEAR(*history_error(t, late, truth), 2.0 * std::sin(0.1), 1e-6);
  EXPECT_EQ(*history_error(t, truth, truth), 0.0);
  const std::vector<std::vector<double>> zero{std::vector<double>(t.size(), 0.0)};
  EXPECT_FALSE(history_error(t, truth, zero));
  EXPECT_NEAR(*history_error(t, zero, truth), 1.0, 1e-12);
  EXPECT_THROW(history_error(t, {}, truth), ContractError);
}

TEST(MainDirection, IsThatOfTheLargestSpread) {
  std::vector<Vec3> path;
  for (int k = 0; k < 50; ++k) {
    const double s = std::sin(0.7 * k);
    path.push_back({5.0 - 0.6 * s + 0.01 * std::cos(2.0 * k), 1.0, -3.0 - 0.8 * s});
  }
  const Vec3 found = *main_direction(path);
  EXPECT_NEAR(found.x, 0.6, 1e-3);
  EXPECT_NEAR(found.y, 0.0, 1e-12);
  EXPECT_NEAR(found.z, 0.8, 1e-3);
  EXPECT_FALSE(main_direction(std::vector<Vec3>(10, Vec3{1.0, 2.0, 3.0})));
  EXPECT_FALSE(main_direction({}));
}

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

TEST(FrequencyErrors, LeaveRigidMotionsOut) {
  const std::vector<double> found{1e-9, 1.1, 1.8};
  const std::vector<double> truth{1e-7, 1.0, 2.0};
  const std::vector<double> errors = frequency_errors(found, truth, 1e-3);
  ASSERT_EQ(errors.size(), 2U);
  EXPECT_NEAR(errors[0], 0.1, 1e-12);
  EXPECT_NEAR(errors[1], -0.1, 1e-12);
  EXPECT_THROW(frequency_errors(found, std::vector<double>(2), 1e-3), ContractError);
}

}  // namespace
}  // namespace palpate::judge
