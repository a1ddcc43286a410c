#include "core/springs/solvers/nonnegative_least_squares.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/base/random.h"
#include "tests/support/dense_nonnegative.h"

namespace {

using namespace palpate;
using namespace palpate::springs;
using namespace palpate::springs::testing_support;

struct Problem {
  DenseMatrix matrix;
  std::vector<double> rhs;
};

double symmetric(SplitMix64& random) {
  return 2.0 * random.uniform() - 1.0;
}

Problem zero_problem(std::size_t rows, std::size_t columns) {
  Problem problem;
  problem.matrix.rows = rows;
  problem.matrix.columns = columns;
  problem.matrix.entry.assign(rows * columns, 0.0);
  problem.rhs.assign(rows, 0.0);
  return problem;
}

Problem random_problem(std::size_t rows, std::size_t columns, std::uint64_t seed) {
  SplitMix64 random(seed);
  Problem problem = zero_problem(rows, columns);
  for (double& value : problem.matrix.entry) value = symmetric(random);
  for (double& value : problem.rhs) value = symmetric(random);
  return problem;
}

std::vector<double> solve(const Problem& problem, NonnegativeReport& report,
                          const NonnegativeOptions& options = {}) {
  std::vector<double> x(problem.matrix.columns, 0.0);
  report = solve_nonnegative(as_map(problem.matrix), problem.rhs, x, options);
  return x;
}

/// Largest difference, over the largest entry of `truth`.
double difference(std::span<const double> x, std::span<const double> truth) {
  double largest = 0.0;
  double size = 1e-300;
  for (std::size_t j = 0; j < x.size(); ++j) {
    largest = std::max(largest, std::abs(x[j] - truth[j]));
    size = std::max(size, std::abs(truth[j]));
  }
  return largest / size;
}

void expect_finite_and_nonnegative(std::span<const double> x) {
  for (const double value : x) {
    EXPECT_TRUE(std::isfinite(value));
    EXPECT_GE(value, 0.0);
  }
}

TEST(NonnegativeLeastSquares, FindsTheMinimumThatEnumerationFinds) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const std::size_t columns = 1 + seed % 9;
    const Problem problem = random_problem(columns + 3 + seed % 4, columns, seed);
    NonnegativeReport report;
    const std::vector<double> x = solve(problem, report);
    const std::vector<double> truth = minimum_by_enumeration(problem.matrix, problem.rhs);
    EXPECT_TRUE(report.converged) << "seed " << seed;
    EXPECT_LE(report.kkt_relative, 1e-10);
    const auto scale = static_cast<double>(problem.rhs.size());
    EXPECT_NEAR(objective(problem.matrix, problem.rhs, x), objective(problem.matrix, problem.rhs, truth),
                1e-12 * scale)
        << "seed " << seed;
    EXPECT_LT(difference(x, truth), 1e-6) << "seed " << seed;
    EXPECT_EQ(report.zeros, static_cast<std::size_t>(std::count(x.begin(), x.end(), 0.0)));
  }
}

TEST(NonnegativeLeastSquares, AgreesWithActiveSetsAndReportsTheTrueResidual) {
  for (std::uint64_t seed = 100; seed < 110; ++seed) {
    const Problem problem = random_problem(90, 60, seed);
    NonnegativeReport report;
    const std::vector<double> x = solve(problem, report);
    const std::vector<double> truth = minimum_by_active_sets(problem.matrix, problem.rhs);
    ASSERT_LT(dense_kkt(problem.matrix, problem.rhs, truth), 1e-11) << "the reference itself, seed " << seed;
    EXPECT_LT(difference(x, truth), 1e-8) << "seed " << seed;
    EXPECT_GT(report.zeros, 10U);
    const double kkt = dense_kkt(problem.matrix, problem.rhs, x);
    EXPECT_LE(kkt, 1e-10);
    EXPECT_NEAR(kkt, report.kkt_relative, 1e-14);
  }
}

TEST(NonnegativeLeastSquares, TheOraclesRejectAnAnswerThatIsAlittleOff) {
  const Problem problem = random_problem(20, 8, 5);
  std::vector<double> x = minimum_by_enumeration(problem.matrix, problem.rhs);
  const double least = objective(problem.matrix, problem.rhs, x);
  ASSERT_LT(dense_kkt(problem.matrix, problem.rhs, x), 1e-13);
  x[0] += 1e-3;
  EXPECT_GT(dense_kkt(problem.matrix, problem.rhs, x), 1e-5);
  EXPECT_GT(objective(problem.matrix, problem.rhs, x), least);
}

TEST(NonnegativeLeastSquares, RidgePullsTowardsAClosedForm) {
  // A = I: x = max(0, (b + r t) / (1 + r)).
  const std::size_t count = 40;
  Problem problem = zero_problem(count, count);
  SplitMix64 random(3);
  std::vector<double> toward(count);
  for (std::size_t j = 0; j < count; ++j) {
    problem.matrix.entry[j * count + j] = 1.0;
    problem.rhs[j] = symmetric(random);
    toward[j] = symmetric(random);
  }
  for (const double ridge : {0.0, 0.1, 1.0, 1e3}) {
    NonnegativeOptions options;
    options.ridge = ridge;
    options.toward = toward;
    NonnegativeReport report;
    const std::vector<double> x = solve(problem, report, options);
    EXPECT_TRUE(report.converged);
    for (std::size_t j = 0; j < count; ++j)
      EXPECT_NEAR(x[j], std::max(0.0, (problem.rhs[j] + ridge * toward[j]) / (1.0 + ridge)), 1e-9);
  }
}

TEST(NonnegativeLeastSquares, RidgeMakesAnUnderdeterminedProblemUnique) {
  const Problem problem = random_problem(6, 20, 11);
  std::vector<double> answers[2];
  for (int i = 0; i < 2; ++i) {
    std::vector<double> x(20, i == 0 ? 0.0 : 3.0);
    NonnegativeOptions options;
    options.ridge = 1e-2;
    const NonnegativeReport report = solve_nonnegative(as_map(problem.matrix), problem.rhs, x, options);
    EXPECT_TRUE(report.converged);
    answers[i] = x;
  }
  EXPECT_LT(difference(answers[0], answers[1]), 1e-6);
}

TEST(NonnegativeLeastSquares, RankDeficientProblemsEndAtAMinimum) {
  for (std::uint64_t seed = 20; seed < 40; ++seed) {
    Problem problem = random_problem(12, 10, seed);
    for (std::size_t r = 0; r < 12; ++r) {
      problem.matrix.entry[r * 10 + 9] = problem.matrix.at(r, 0);
      problem.matrix.entry[r * 10 + 8] = problem.matrix.at(r, 1) - problem.matrix.at(r, 2);
    }
    NonnegativeReport report;
    const std::vector<double> x = solve(problem, report);
    expect_finite_and_nonnegative(x);
    EXPECT_TRUE(report.converged) << "seed " << seed;
    EXPECT_LE(dense_kkt(problem.matrix, problem.rhs, x), 1.1e-10) << "seed " << seed;
  }
}

TEST(NonnegativeLeastSquares, ColumnScalesDoNotMatter) {
  const Problem problem = random_problem(30, 20, 8);
  Problem scaled = problem;
  std::vector<double> scale(20);
  for (std::size_t c = 0; c < 20; ++c) {
    scale[c] = std::pow(2.0, 4.0 * static_cast<double>(c) - 40.0);
    for (std::size_t r = 0; r < 30; ++r) scaled.matrix.entry[r * 20 + c] *= scale[c];
  }
  for (double& value : scaled.rhs) value *= 0x1.0p-30;
  NonnegativeReport report;
  NonnegativeReport scaled_report;
  const std::vector<double> x = solve(problem, report);
  const std::vector<double> y = solve(scaled, scaled_report);
  // Powers of two: the same bits.
  for (std::size_t c = 0; c < 20; ++c) EXPECT_EQ(x[c] * 0x1.0p-30 / scale[c], y[c]);
  EXPECT_EQ(report.kkt_relative, scaled_report.kkt_relative);
}

TEST(NonnegativeLeastSquares, ZeroColumnsAndZeroRightHandSides) {
  Problem problem = random_problem(9, 5, 2);
  for (std::size_t r = 0; r < 9; ++r) problem.matrix.entry[r * 5 + 3] = 0.0;
  std::vector<double> x{0.0, 0.0, 0.0, 7.0, 0.0};
  EXPECT_TRUE(solve_nonnegative(as_map(problem.matrix), problem.rhs, x, {}).converged);
  EXPECT_EQ(x[3], 7.0);

  std::fill(problem.rhs.begin(), problem.rhs.end(), 0.0);
  x = {1.0, 2.0, 3.0, 7.0, -4.0};
  const NonnegativeReport report = solve_nonnegative(as_map(problem.matrix), problem.rhs, x, {});
  EXPECT_TRUE(report.converged);
  EXPECT_EQ(report.zeros, 4U);
  EXPECT_EQ(x, (std::vector<double>{0.0, 0.0, 0.0, 7.0, 0.0}));

  std::vector<double> none;
  const DenseMatrix empty;
  EXPECT_TRUE(solve_nonnegative(as_map(empty), none, none, {}).converged);
}

TEST(NonnegativeLeastSquares, EverythingAtTheBound) {
  // A = [2 1; 1 2], b = -A (1, 1): the gradient at zero is positive.
  Problem problem = zero_problem(2, 2);
  problem.matrix.entry = {2.0, 1.0, 1.0, 2.0};
  problem.rhs = {-3.0, -3.0};
  NonnegativeReport report;
  EXPECT_EQ(solve(problem, report), (std::vector<double>{0.0, 0.0}));
  EXPECT_EQ(report.zeros, 2U);
  EXPECT_EQ(report.kkt_relative, 0.0);
}

TEST(NonnegativeLeastSquares, AnIterationLimitIsSaidAndTheAnswerStaysFinite) {
  const Problem problem = random_problem(90, 60, 4);
  NonnegativeOptions options;
  options.max_iterations = 1;
  NonnegativeReport report;
  const std::vector<double> x = solve(problem, report, options);
  EXPECT_FALSE(report.converged);
  EXPECT_EQ(report.iterations, 1U);
  EXPECT_GT(report.kkt_relative, 1e-10);
  expect_finite_and_nonnegative(x);
}

TEST(NonnegativeLeastSquares, NearlySingularProblemsEndAtAMinimum) {
  // Hilbert's matrix: condition 1e10 at 8 columns and 1e16 at 12, and their squares for A^T A. Clipped steps
  // alone stall at 1e-4.
  for (const std::size_t count : {6U, 8U, 10U, 12U}) {
    DenseMatrix hilbert{count, count, std::vector<double>(count * count)};
    std::vector<double> rhs(count);
    for (std::size_t r = 0; r < count; ++r)
      for (std::size_t c = 0; c < count; ++c) {
        hilbert.entry[r * count + c] = 1.0 / static_cast<double>(r + c + 1);
        rhs[r] += (c % 3 == 0 ? -0.5 : 1.0) * hilbert.at(r, c);
      }
    std::vector<double> x(count, 0.0);
    const NonnegativeReport report = solve_nonnegative(as_map(hilbert), rhs, x, {});
    expect_finite_and_nonnegative(x);
    EXPECT_TRUE(report.converged) << count;
    EXPECT_LE(dense_kkt(hilbert, rhs, x), 1.01e-10) << count;
    EXPECT_LE(objective(hilbert, rhs, x),
              objective(hilbert, rhs, minimum_by_enumeration(hilbert, rhs)) + 1e-12);
  }
}

TEST(NonnegativeLeastSquares, SinglePrecisionStepsChangeNothingInTheAnswer) {
  const Problem problem = random_problem(90, 60, 6);
  const LinearMap map = as_map(problem.matrix);
  std::vector<double> image(90);
  NormalEquations equations;
  equations.diagonal = map.column_norms_sq;
  equations.linear.resize(60);
  map.apply_transposed(problem.rhs, equations.linear);
  equations.apply = [&](std::span<const double> in, std::span<double> out) {
    map.apply(in, image);
    map.apply_transposed(image, out);
  };
  std::vector<double> full(60, 0.0);
  ASSERT_TRUE(solve_nonnegative(equations, full, {}).converged);
  equations.apply_single = [&](std::span<const float> in, std::span<float> out) {
    std::vector<double> wide(in.begin(), in.end());
    std::vector<double> result(60);
    equations.apply(wide, result);
    std::transform(result.begin(), result.end(), out.begin(), [](double v) { return static_cast<float>(v); });
  };
  std::vector<double> single(60, 0.0);
  const NonnegativeReport report = solve_nonnegative(equations, single, {});
  EXPECT_TRUE(report.converged);
  EXPECT_LE(dense_kkt(problem.matrix, problem.rhs, single), 1e-10);
  EXPECT_LT(difference(single, full), 1e-8);

  // One that lies is found out: the residual is never its own, and full precision takes over.
  equations.apply_single = [](std::span<const float> in, std::span<float> out) {
    std::transform(in.begin(), in.end(), out.rbegin(), [](float v) { return -v; });
  };
  std::vector<double> misled(60, 0.0);
  EXPECT_TRUE(solve_nonnegative(equations, misled, {}).converged);
  EXPECT_LT(difference(misled, full), 1e-8);
}

TEST(NonnegativeLeastSquares, TheSameInputGivesTheSameBytes) {
  const Problem problem = random_problem(90, 60, 7);
  NonnegativeReport report;
  const std::vector<double> first = solve(problem, report);
  EXPECT_EQ(first, solve(problem, report));
}

TEST(NonnegativeLeastSquares, RefusesWhatIsNoProblem) {
  const Problem problem = random_problem(5, 3, 1);
  const LinearMap map = as_map(problem.matrix);
  std::vector<double> x(3, 0.0);
  std::vector<double> short_x(2, 0.0);
  EXPECT_THROW(solve_nonnegative(map, problem.rhs, short_x, {}), ContractError);
  const std::vector<double> short_rhs(4, 0.0);
  EXPECT_THROW(solve_nonnegative(map, short_rhs, x, {}), ContractError);
  std::vector<double> bad_rhs = problem.rhs;
  bad_rhs[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(solve_nonnegative(map, bad_rhs, x, {}), ContractError);
  std::vector<double> bad_start(3, std::numeric_limits<double>::infinity());
  EXPECT_THROW(solve_nonnegative(map, problem.rhs, bad_start, {}), ContractError);
  NonnegativeOptions options;
  options.ridge = -1.0;
  EXPECT_THROW(solve_nonnegative(map, problem.rhs, x, options), ContractError);
  options.ridge = 0.0;
  options.toward = short_x;
  EXPECT_THROW(solve_nonnegative(map, problem.rhs, x, options), ContractError);
}

}  // namespace
