// Errors of histories, on signals in closed form.
#include "core/judge/motion/motion_error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "tests/support/angles.h"
#include "tests/support/signals.h"

namespace palpate::judge {
namespace {

using test::kPi;
using test::ringing;
using test::times;
using test::values;

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
