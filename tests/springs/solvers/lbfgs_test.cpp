#include "core/springs/solvers/lbfgs.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/error.h"

namespace {

using namespace palpate;
using namespace palpate::springs;

TEST(Lbfgs, FindsTheMinimumOfABadlyScaledQuadratic) {
  // f = 1/2 sum 10^(j/4) (x_j - j)^2: condition 1e5.
  const auto f = [](std::span<const double> x, std::span<double> gradient) {
    double value = 0.0;
    for (std::size_t j = 0; j < x.size(); ++j) {
      const double scale = std::pow(10.0, static_cast<double>(j) / 4.0);
      const double off = x[j] - static_cast<double>(j);
      value += 0.5 * scale * off * off;
      gradient[j] = scale * off;
    }
    return value;
  };
  std::vector<double> x(21, 0.0);
  LbfgsOptions options;
  options.gradient_tolerance = 1e-12;
  options.max_iterations = 3000;
  options.decrease_tolerance = 0.0;
  const LbfgsReport report = minimize_lbfgs(f, x, options);
  EXPECT_EQ(report.stop, LbfgsStop::kGradient);
  for (std::size_t j = 0; j < x.size(); ++j) EXPECT_NEAR(x[j], static_cast<double>(j), 1e-6);
  EXPECT_LT(report.value, 1e-12 * report.start_value);
}

double rosenbrock(std::span<const double> x, std::span<double> gradient) {
  const double a = 1.0 - x[0];
  const double b = x[1] - x[0] * x[0];
  gradient[0] = -2.0 * a - 400.0 * x[0] * b;
  gradient[1] = 200.0 * b;
  return a * a + 100.0 * b * b;
}

TEST(Lbfgs, FollowsRosenbrocksValleyAndNeverRises) {
  double last = std::numeric_limits<double>::infinity();
  for (std::size_t most = 0; most <= 60; ++most) {
    std::vector<double> x{-1.2, 1.0};
    LbfgsOptions options;
    options.max_iterations = most;
    options.gradient_tolerance = 1e-9;
    options.decrease_tolerance = 0.0;
    const LbfgsReport report = minimize_lbfgs(rosenbrock, x, options);
    EXPECT_LE(report.value, last);
    EXPECT_LE(report.iterations, most);
    last = report.value;
    if (most == 60) {
      EXPECT_NEAR(x[0], 1.0, 1e-6);
      EXPECT_NEAR(x[1], 1.0, 1e-6);
    }
  }
}

TEST(Lbfgs, StepsBackFromWhereThereIsNoValue) {
  // f = x - log x, infinite for x <= 0; minimum at 1.
  const auto f = [](std::span<const double> x, std::span<double> gradient) {
    if (x[0] <= 0.0) return std::numeric_limits<double>::infinity();
    gradient[0] = 1.0 - 1.0 / x[0];
    return x[0] - std::log(x[0]);
  };
  std::vector<double> x{30.0};
  LbfgsOptions options;
  options.first_step = 100.0;
  options.decrease_tolerance = 0.0;
  minimize_lbfgs(f, x, options);
  EXPECT_NEAR(x[0], 1.0, 1e-4);
}

TEST(Lbfgs, StopsAtOnceAtAMinimumAndRefusesAStartWithoutAValue) {
  const auto f = [](std::span<const double> x, std::span<double> gradient) {
    gradient[0] = 2.0 * x[0];
    return x[0] * x[0];
  };
  std::vector<double> x{0.0};
  EXPECT_EQ(minimize_lbfgs(f, x, {}).iterations, 0U);
  const auto nowhere = [](std::span<const double>, std::span<double>) {
    return std::numeric_limits<double>::infinity();
  };
  EXPECT_THROW(minimize_lbfgs(nowhere, x, {}), ContractError);
}

}  // namespace
