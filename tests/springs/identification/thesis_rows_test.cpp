// Appendix B of the thesis against eq. 3.15, of which it is meant to be the Fourier series.
#include "core/springs/identification/thesis_rows.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/mesh/shapes/shapes.h"
#include "core/springs/network/network.h"
#include "tests/support/angles.h"

namespace palpate::springs {
namespace {

using test::kPi;

constexpr std::uint64_t kSeed = 2008;

std::vector<Vec3> random_directions(std::size_t count) {
  SplitMix64 random(kSeed);
  std::vector<Vec3> directions;
  while (directions.size() < count) {
    const Vec3 v{2.0 * random.uniform() - 1.0, 2.0 * random.uniform() - 1.0, 2.0 * random.uniform() - 1.0};
    if (length_sq(v) <= 1.0 && length_sq(v) > 0.01) directions.push_back((1.0 / length(v)) * v);
  }
  return directions;
}

Vec3 direction_of(double alpha, double beta) {
  return {std::sin(alpha) * std::cos(beta), std::sin(alpha) * std::sin(beta), std::cos(alpha)};
}

/// The bracket of eq. 3.15 for a spring of direction e when the solid is stretched along n.
double equation_3_15(const Vec3& e, const Vec3& n, double lambda1) {
  const double c = dot(e, n);
  return lambda1 + (1.0 - 2.0 * lambda1) * c * c + (lambda1 - 1.0) * c * c * c * c;
}

/// A term of the Fourier series in the stretch's angles: cos or sin of p alpha times cos or sin of q beta.
struct Mode {
  int p;
  int q;
  bool sin_alpha;
  bool sin_beta;

  double at(double alpha, double beta) const {
    return (sin_alpha ? std::sin(p * alpha) : std::cos(p * alpha)) *
           (sin_beta ? std::sin(q * beta) : std::cos(q * beta));
  }
};

std::vector<Mode> all_modes() {
  std::vector<Mode> modes;
  for (int p = 0; p <= 4; ++p) {
    for (int q = 0; q <= 4; ++q) {
      for (const bool sin_alpha : {false, true}) {
        for (const bool sin_beta : {false, true}) {
          if ((sin_alpha && p == 0) || (sin_beta && q == 0)) continue;
          modes.push_back({p, q, sin_alpha, sin_beta});
        }
      }
    }
  }
  return modes;
}

/// Fourier coefficients of eq. 3.15 in the angles of n, one column a direction. The trapezoidal rule with 16
/// points a period is exact for trigonometric polynomials of degree below 16; products here have degree 8.
Eigen::MatrixXd fourier_coefficients(const std::vector<Vec3>& directions, double lambda1) {
  constexpr int kPoints = 16;
  const std::vector<Mode> modes = all_modes();
  const auto columns = static_cast<Eigen::Index>(directions.size());
  Eigen::MatrixXd coefficients = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(modes.size()), columns);
  for (int i = 0; i < kPoints; ++i) {
    for (int j = 0; j < kPoints; ++j) {
      const double alpha = 2.0 * kPi * i / kPoints;
      const double beta = 2.0 * kPi * j / kPoints;
      for (Eigen::Index d = 0; d < columns; ++d) {
        const double value =
            equation_3_15(directions[static_cast<std::size_t>(d)], direction_of(alpha, beta), lambda1);
        for (std::size_t m = 0; m < modes.size(); ++m)
          coefficients(static_cast<Eigen::Index>(m), d) += value * modes[m].at(alpha, beta);
      }
    }
  }
  return coefficients / (kPoints * kPoints);
}

Eigen::MatrixXd thesis_matrix(const std::vector<Vec3>& directions, ThesisRows rows, double lambda1) {
  Eigen::MatrixXd matrix(kThesisRows, static_cast<Eigen::Index>(directions.size()));
  for (std::size_t d = 0; d < directions.size(); ++d) {
    const auto column = thesis_row_coefficients(directions[d], rows, lambda1);
    for (std::size_t r = 0; r < kThesisRows; ++r)
      matrix(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(d)) = column[r];
  }
  return matrix;
}

Eigen::MatrixXd with_ones(const Eigen::MatrixXd& matrix) {
  Eigen::MatrixXd more(matrix.rows() + 1, matrix.cols());
  more << matrix, Eigen::RowVectorXd::Ones(matrix.cols());
  return more;
}

/// Rank by the singular values of the matrix with rows of length 1; sets the smallest relative one that
/// counts and the largest that does not.
int rank_of(Eigen::MatrixXd matrix) {
  for (Eigen::Index r = 0; r < matrix.rows(); ++r) {
    if (matrix.row(r).norm() > 1e-12) matrix.row(r).normalize();
  }
  const Eigen::VectorXd values =
      Eigen::JacobiSVD<Eigen::MatrixXd>(matrix * matrix.transpose()).singularValues();
  int rank = 0;
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const double relative = values(i) / values(0);
    EXPECT_TRUE(relative > 1e-5 || relative < 1e-13) << "no clear rank: " << relative;
    if (relative > 1e-5) ++rank;
  }
  return rank;
}

/// Is one vector a multiple of the other (both not zero)?
bool are_parallel(const Eigen::RowVectorXd& a, const Eigen::RowVectorXd& b) {
  const double lengths = a.norm() * b.norm();
  return lengths > 1e-9 && std::abs(std::abs(a.dot(b)) / lengths - 1.0) < 1e-12;
}

/// Rows (from 1) that are no Fourier coefficient of eq. 3.15, at several lambda1, so that nothing that holds
/// at -1/4 alone hides a misprint.
std::vector<int> rows_that_are_no_coefficient(ThesisRows rows) {
  const std::vector<Vec3> directions = random_directions(40);
  std::array<bool, kThesisRows> is_wrong{};
  for (const double lambda1 : {kThesisLambda1, -0.4, 0.15}) {
    const Eigen::MatrixXd series = fourier_coefficients(directions, lambda1);
    const Eigen::MatrixXd matrix = thesis_matrix(directions, rows, lambda1);
    for (Eigen::Index r = 0; r < matrix.rows(); ++r) {
      bool found = false;
      for (Eigen::Index m = 0; m < series.rows(); ++m)
        found = found || are_parallel(matrix.row(r), series.row(m));
      if (!found) is_wrong[static_cast<std::size_t>(r)] = true;
    }
  }
  std::vector<int> wrong;
  for (int r = 0; r < static_cast<int>(kThesisRows); ++r) {
    if (is_wrong[static_cast<std::size_t>(r)]) wrong.push_back(r + 1);
  }
  return wrong;
}

TEST(ThesisRows, EightOfThePrintedRowsAreNotInTheFourierSeries) {
  EXPECT_EQ(rows_that_are_no_coefficient(ThesisRows::kPrinted),
            (std::vector<int>{3, 4, 5, 6, 11, 12, 14, 15}));
}

TEST(ThesisRows, TheCorrectedRowsAreTheFourierSeriesOfEquation3_15) {
  EXPECT_EQ(rows_that_are_no_coefficient(ThesisRows::kCorrected), std::vector<int>{});
  // And no coefficient is missing: the series has the rank of the rows.
  const std::vector<Vec3> directions = random_directions(60);
  const Eigen::MatrixXd series = fourier_coefficients(directions, kThesisLambda1);
  const Eigen::MatrixXd corrected = thesis_matrix(directions, ThesisRows::kCorrected, kThesisLambda1);
  Eigen::MatrixXd both(series.rows() + corrected.rows(), series.cols());
  both << series, corrected;
  EXPECT_EQ(rank_of(series), 14);
  EXPECT_EQ(rank_of(both), 14);
}

TEST(ThesisRows, RanksAre16PrintedAnd14CorrectedAnd15WithStiffness) {
  const std::vector<Vec3> directions = random_directions(400);
  const Eigen::MatrixXd printed = thesis_matrix(directions, ThesisRows::kPrinted, kThesisLambda1);
  const Eigen::MatrixXd corrected = thesis_matrix(directions, ThesisRows::kCorrected, kThesisLambda1);
  EXPECT_EQ(rank_of(printed), 16);
  EXPECT_EQ(rank_of(corrected), 14);
  EXPECT_EQ(rank_of(with_ones(corrected)), 15);
}

TEST(ThesisRows, ThePrintedRowsDemandThatTheSpringsHaveNoStiffness) {
  // B.1, B.4 as printed and B.13 span 1, cos 2a and cos 4a, so together they ask for sum k U^2 = 0.
  const std::vector<Vec3> directions = random_directions(400);
  const Eigen::MatrixXd printed = thesis_matrix(directions, ThesisRows::kPrinted, kThesisLambda1);
  EXPECT_EQ(rank_of(with_ones(printed)), rank_of(printed));
  const auto three = [&](const Eigen::MatrixXd& rows) {
    Eigen::MatrixXd some(3, rows.cols());
    some << rows.row(0), rows.row(3), rows.row(12);
    return some;
  };
  EXPECT_EQ(rank_of(three(printed)), 3);
  EXPECT_EQ(rank_of(with_ones(three(printed))), 3);
  EXPECT_EQ(rank_of(three(thesis_matrix(directions, ThesisRows::kCorrected, kThesisLambda1))), 2);
}

TEST(ThesisRows, B19ContradictsB4AndIsRight) {
  const std::vector<Vec3> directions = random_directions(50);
  const Eigen::MatrixXd printed = thesis_matrix(directions, ThesisRows::kPrinted, kThesisLambda1);
  const Eigen::MatrixXd corrected = thesis_matrix(directions, ThesisRows::kCorrected, kThesisLambda1);
  Eigen::RowVectorXd b19(printed.cols());
  for (std::size_t d = 0; d < directions.size(); ++d) {
    const double a = std::acos(directions[d].z);
    b19(static_cast<Eigen::Index>(d)) = 21.0 + 68.0 * std::cos(2.0 * a) - 25.0 * std::cos(4.0 * a);
  }
  EXPECT_FALSE(are_parallel(b19, printed.row(3)));
  EXPECT_TRUE(are_parallel(b19, corrected.row(3)));
  Eigen::MatrixXd with_b19 = printed;
  with_b19.row(3) = b19;
  EXPECT_EQ(rank_of(with_b19), 15);
  EXPECT_EQ(rank_of(with_ones(with_b19)), 16);  // then the stiffness row is not contradicted
}

TEST(ThesisRows, B18ToB23AreB1AndB4ToB8TimesFourWithTheSignOfB4Mended) {
  for (const Vec3& e : random_directions(40)) {
    const auto printed = thesis_row_coefficients(e, ThesisRows::kPrinted);
    const auto mended = thesis_row_coefficients(e, ThesisRows::kB4Sign);
    const auto substituted = thesis_row_coefficients(e, ThesisRows::kSubstituted);
    for (std::size_t r = 0; r < kThesisRows; ++r) {
      // B.22 and B.23 have their signs turned round, which changes nothing in "= 0".
      const double factor = r == 0 || (r >= 3 && r <= 5) ? 4.0 : (r == 6 || r == 7 ? -4.0 : 1.0);
      EXPECT_NEAR(substituted[r], factor * mended[r], 1e-12) << r + 1;
      EXPECT_TRUE(r == 3 || mended[r] == printed[r]) << r + 1;
    }
    EXPECT_EQ(mended[3], thesis_row_coefficients(e, ThesisRows::kCorrected)[3]);
  }
  EXPECT_THROW(thesis_row_coefficients({0, 0, 1}, ThesisRows::kSubstituted, -0.3), ContractError);
  const std::vector<Vec3> directions = random_directions(400);
  for (const ThesisRows rows : {ThesisRows::kB4Sign, ThesisRows::kSubstituted}) {
    const Eigen::MatrixXd matrix = thesis_matrix(directions, rows, kThesisLambda1);
    EXPECT_EQ(rank_of(matrix), 15);
    EXPECT_EQ(rank_of(with_ones(matrix)), 16);  // room for stiffness, other than to the letter
  }
}

TEST(ThesisRows, OnlyATransverseRatioOfAQuarterLeavesRoomForStiffness) {
  // At lambda1 = -1/4 eq. 3.15 is (2/7)(P2 - P4); elsewhere its mean over n is not zero and forces sum w = 0.
  const std::vector<Vec3> directions = random_directions(60);
  const Vec3 n = direction_of(0.3, 1.1);
  for (const Vec3& e : directions) {
    const double c = dot(e, n);
    const double p2 = 0.5 * (3.0 * c * c - 1.0);
    const double p4 = (35.0 * c * c * c * c - 30.0 * c * c + 3.0) / 8.0;
    EXPECT_NEAR(equation_3_15(e, n, kThesisLambda1), 2.0 / 7.0 * (p2 - p4), 1e-14);
  }
  for (const double lambda1 : {-0.3, -0.2, 0.0}) {
    const Eigen::MatrixXd series = fourier_coefficients(directions, lambda1);
    EXPECT_EQ(rank_of(series), 15);
    EXPECT_EQ(rank_of(with_ones(series)), 15) << lambda1;
  }
  EXPECT_EQ(rank_of(with_ones(fourier_coefficients(directions, kThesisLambda1))), 15);
}

TEST(ThesisRows, TheSameStiffnessInAllDirectionsIsNoFurtherConstraint) {
  // Eq. 3.16's sum, (c^2 + lambda1 s^2)^2 at many n, less its mean over n: in the span of eq. 3.15's series.
  const std::vector<Vec3> directions = random_directions(60);
  const std::vector<Vec3> stretches = random_directions(90);
  const Eigen::MatrixXd series = fourier_coefficients(directions, kThesisLambda1);
  Eigen::MatrixXd both(series.rows() + 30, series.cols());
  for (Eigen::Index d = 0; d < series.cols(); ++d) {
    for (Eigen::Index n = 0; n < 30; ++n) {
      const double c =
          dot(directions[static_cast<std::size_t>(d)], stretches[static_cast<std::size_t>(60 + n)]);
      const double strain = c * c + kThesisLambda1 * (1.0 - c * c);
      both(series.rows() + n, d) = strain * strain - 1.0 / 6.0;
    }
  }
  both.topRows(series.rows()) = series;
  EXPECT_EQ(rank_of(series), 14);
  EXPECT_EQ(rank_of(both), 14);
}

TEST(ThesisRows, StretchingResistanceIsATwelfthNotASixth) {
  // W = 1/2 sum of 1/2 k u^2 with u = U e (c^2 - s^2 / 4): d2W/de2 is half of eq. 3.16's sum, so 1/12 sum w
  // when the springs point everywhere alike. Mean over a fine grid of the sphere (midpoints in cos alpha).
  constexpr int kPoints = 400;
  double mean = 0.0;
  for (int i = 0; i < kPoints; ++i) {
    const double c = (2.0 * i + 1.0) / kPoints - 1.0;
    const double strain = c * c + kThesisLambda1 * (1.0 - c * c);
    mean += strain * strain / kPoints;
  }
  EXPECT_NEAR(mean, 1.0 / 6.0, 1e-5);         // eq. 3.17 has this ...
  EXPECT_NEAR(0.5 * mean, 1.0 / 12.0, 1e-5);  // ... and each spring is shared by two vertices (eq. 3.14)
}

TEST(ThesisRows, APrintedRowChangesWhenASpringIsSeenFromItsOtherEnd) {
  // Every term of eq. 3.15 is even in the spring's direction.
  const Vec3 e = direction_of(0.7, 0.4);
  const auto corrected = thesis_row_coefficients(e, ThesisRows::kCorrected);
  const auto reversed = thesis_row_coefficients(-1.0 * e, ThesisRows::kCorrected);
  for (std::size_t r = 0; r < kThesisRows; ++r) EXPECT_NEAR(corrected[r], reversed[r], 1e-13);
  const auto printed = thesis_row_coefficients(e, ThesisRows::kPrinted);
  const auto printed_reversed = thesis_row_coefficients(-1.0 * e, ThesisRows::kPrinted);
  EXPECT_GT(std::abs(printed[2] - printed_reversed[2]), 0.1);
  EXPECT_GT(std::abs(printed[10] - printed_reversed[10]), 0.1);
}

TEST(ThesisRows, TheAnswerIsTheLeastSquaresOne) {
  // The gradient of the dense problem vanishes where k > 0 and points inwards where k = 0.
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 21);
  constexpr double kModulus = 300.0;
  for (const ThesisRows rows :
       {ThesisRows::kPrinted, ThesisRows::kB4Sign, ThesisRows::kSubstituted, ThesisRows::kCorrected}) {
    for (const double weight : {1.0, 30.0}) {
      SpringNetwork network = build_spring_network(mesh);
      ThesisOptions options;
      options.rows = rows;
      options.stiffness_row_weight = weight;
      const NonnegativeReport report = identify_thesis(mesh, kModulus, options, network);
      EXPECT_TRUE(report.converged);
      const std::vector<double> volumes = build_influence_volumes(mesh);
      const auto count = static_cast<Eigen::Index>(network.springs.size());
      Eigen::MatrixXd a = Eigen::MatrixXd::Zero(18 * static_cast<Eigen::Index>(volumes.size()), count);
      Eigen::VectorXd b = Eigen::VectorXd::Zero(a.rows());
      Eigen::VectorXd w(count);
      for (Eigen::Index s = 0; s < count; ++s) {
        const auto spring = static_cast<std::size_t>(s);
        const double u = network.rest_length_m[spring];
        w(s) = network.stiffness_n_per_m[spring] * u * u / kModulus;
        for (std::size_t end = 0; end < 2; ++end) {
          const Index v = network.springs[spring][end];
          const Vec3 d = mesh.points[network.springs[spring][1 - end]] - mesh.points[v];
          const auto column = thesis_row_coefficients((1.0 / u) * d, rows);
          const Eigen::Index first = 18 * static_cast<Eigen::Index>(v);
          for (std::size_t r = 0; r < 17; ++r) a(first + static_cast<Eigen::Index>(r), s) = column[r];
          a(first + 17, s) = weight;
        }
      }
      for (std::size_t v = 0; v < volumes.size(); ++v)
        b(18 * static_cast<Eigen::Index>(v) + 17) = weight * 12.0 * volumes[v];
      const Eigen::VectorXd gradient = a.transpose() * (a * w - b);
      const double scale = (a.transpose() * b).cwiseAbs().maxCoeff();
      for (Eigen::Index s = 0; s < count; ++s) {
        EXPECT_GE(w(s), 0.0);
        if (w(s) > 0.0) {
          EXPECT_NEAR(gradient(s) / scale, 0.0, 1e-8);
        } else {
          EXPECT_GE(gradient(s) / scale, -1e-8);
        }
      }
    }
  }
}

TEST(ThesisRows, WithOppositeSpringsARidgeMakesTheAnswerOneThatIsFound) {
  // The ridge moves a well-determined problem little: the answer minimises |A w - b|^2 + r |w|^2.
  const TetMesh mesh = build_kuhn_cube(5, 0.25, 7);
  for (const ThesisRows rows : {ThesisRows::kPrinted, ThesisRows::kCorrected}) {
    SpringNetwork network = build_spring_network(mesh, true);
    ThesisOptions options;
    options.rows = rows;
    options.ridge_relative = kOppositeRidge;
    const NonnegativeReport report = identify_thesis(mesh, 1000.0, options, network);
    EXPECT_TRUE(report.converged);
    EXPECT_LT(report.cg_iterations, 20000U);
    options.ridge_relative = 10.0;
    SpringNetwork pulled = build_spring_network(mesh, true);
    EXPECT_TRUE(identify_thesis(mesh, 1000.0, options, pulled).converged);
    const auto sum = [](const SpringNetwork& of) {
      double total = 0.0;
      for (std::size_t s = 0; s < of.springs.size(); ++s)
        total += of.stiffness_n_per_m[s] * of.rest_length_m[s] * of.rest_length_m[s];
      return total;
    };
    EXPECT_LT(sum(pulled), sum(network));
  }
  ThesisOptions negative;
  negative.ridge_relative = -1.0;
  SpringNetwork network = build_spring_network(build_bar(1));
  EXPECT_THROW(identify_thesis(build_bar(1), 1.0, negative, network), ContractError);
}

TEST(ThesisRows, AWeightOfZeroIsAFaultOfTheCaller) {
  SpringNetwork network = build_spring_network(build_bar(1));
  ThesisOptions options;
  options.stiffness_row_weight = 0.0;
  EXPECT_THROW(identify_thesis(build_bar(1), 1.0, options, network), ContractError);
}

}  // namespace
}  // namespace palpate::springs
