#include "core/dynamics/linear_algebra/linear_solver.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/base/error.h"
#include "core/dynamics/linear_algebra/block_cholesky.h"
#include "tests/support/dynamics_cases.h"

namespace palpate::dynamics {
namespace {

using testing_support::field_distance;
using testing_support::field_norm;
using testing_support::make_random_field;

/// A chain of vertices, each bound to the next by the symmetric positive definite block `spring`, the first
/// one also to the ground.
BlockMatrix make_chain(Index vertices, const Mat3& spring) {
  std::vector<Index> offsets;
  std::vector<Index> ends;
  for (Index v = 0; v + 1 < vertices; ++v) {
    offsets.push_back(2 * v);
    ends.insert(ends.end(), {v, v + 1});
  }
  offsets.push_back(2 * (vertices - 1));
  const std::vector<VertexGroups> groups{{offsets, ends}};
  BlockMatrix matrix = build_block_matrix(vertices, groups);
  add_block(matrix, 0, 0, spring);
  for (Index v = 0; v + 1 < vertices; ++v) {
    add_block(matrix, v, v, spring);
    add_block(matrix, v + 1, v + 1, spring);
    add_block(matrix, v, v + 1, (-1.0) * spring);
    add_block(matrix, v + 1, v, (-1.0) * spring);
  }
  return matrix;
}

constexpr Mat3 kSpring{{3.0, 1.0, 0.5, 1.0, 2.0, 0.2, 0.5, 0.2, 1.0}};
constexpr std::array kMethods{LinearMethod::kDirect, LinearMethod::kConjugateGradients};

TEST(LinearSolver, FindsWhatTheMatrixWasAppliedTo) {
  const Index n = 40;
  const BlockMatrix matrix = make_chain(n, kSpring);
  const std::vector<std::uint8_t> held(n, 0);
  const std::vector<Vec3> truth = make_random_field(n, 1.0, 2);
  std::vector<Vec3> rhs(n);
  multiply(matrix, truth, rhs);
  for (const LinearMethod method : kMethods) {
    LinearSolver solver({method, 1e-13});
    ASSERT_EQ(solver.prepare(matrix, held), LinearStatus::kSolved);
    EXPECT_EQ(solver.is_direct(), method == LinearMethod::kDirect);
    std::vector<Vec3> x(n);
    ASSERT_EQ(solver.solve(rhs, x).status, LinearStatus::kSolved);
    EXPECT_LT(field_distance(x, truth), 1e-9 * field_norm(truth));
  }
}

TEST(LinearSolver, AKeptMatrixIsFactoredUnlessItsFactorsAreNotToBeHad) {
  const Index n = 2000;
  const BlockMatrix matrix = make_chain(n, kSpring);
  std::vector<std::uint8_t> held(n, 0);
  held[5] = 3;
  std::vector<Vec3> truth = make_random_field(n, 1.0, 2);
  truth[5].x = truth[5].y = 0.0;
  std::vector<Vec3> rhs(n);
  multiply(matrix, truth, rhs);
  int calls = 0;
  const FactorMaker counted = [&calls](const LowerHalf& half) {
    ++calls;
    return factor_simplicial(half);
  };
  const FactorMaker none = [](const LowerHalf&) -> std::unique_ptr<SymmetricFactor> {
    throw UnavailableError("no memory");
  };
  const auto solves = [&](const FactorMaker& factor, MatrixUse use, bool is_direct) {
    LinearSolver solver({LinearMethod::kAuto, 1e-13, 0, 1, factor});
    ASSERT_EQ(solver.prepare(matrix, held, use), LinearStatus::kSolved);
    EXPECT_EQ(solver.is_direct(), is_direct);
    std::vector<Vec3> x(n);
    ASSERT_EQ(solver.solve(rhs, x).status, LinearStatus::kSolved);
    EXPECT_LT(field_distance(x, truth), 1e-6 * field_norm(truth));  // its condition number is some n^2
  };
  solves({}, MatrixUse::kFewTimes, false);
  solves({}, MatrixUse::kKept, true);
  solves(counted, MatrixUse::kFewTimes, false);
  EXPECT_EQ(calls, 0);
  solves(counted, MatrixUse::kKept, true);
  EXPECT_EQ(calls, 1);
  solves(none, MatrixUse::kKept, false);
}

TEST(BlockMatrix, TheMirrorOfTheUpperHalfIsBelowTheDiagonal) {
  BlockMatrix matrix = make_chain(5, kSpring);
  const BlockMatrix wanted = matrix;
  for (std::size_t v = 0; v < matrix.rows(); ++v) {
    for (std::size_t k = matrix.offsets[v]; k < matrix.offsets[v + 1]; ++k) {
      if (matrix.columns[k] < v) matrix.blocks[k] = Mat3{};
    }
  }
  mirror_upper_half(matrix);
  for (std::size_t k = 0; k < matrix.blocks.size(); ++k) EXPECT_EQ(matrix.blocks[k].m, wanted.blocks[k].m);
}

TEST(LinearSolver, HeldComponentsStayAtZeroAndLeaveTheSystem) {
  const Index n = 12;
  const BlockMatrix matrix = make_chain(n, kSpring);
  std::vector<std::uint8_t> held(n, 0);
  held[3] = 7;
  held[7] = 2;
  const std::vector<Vec3> rhs = make_random_field(n, 1.0, 5);
  for (const LinearMethod method : kMethods) {
    LinearSolver solver({method, 1e-13});
    ASSERT_EQ(solver.prepare(matrix, held), LinearStatus::kSolved);
    std::vector<Vec3> x(n);
    solver.solve(rhs, x);
    EXPECT_EQ(x[3], (Vec3{}));
    EXPECT_EQ(x[7].y, 0.0);
    std::vector<Vec3> back(n);
    multiply(matrix, x, back);
    for (Index v = 0; v < n; ++v) {
      if (held[v] == 7) continue;
      EXPECT_NEAR(back[v].x, rhs[v].x, 1e-10);
      EXPECT_NEAR(back[v].z, rhs[v].z, 1e-10);
      if (held[v] == 0) {
        EXPECT_NEAR(back[v].y, rhs[v].y, 1e-10);
      }
    }
  }
}

TEST(LinearSolver, AnIndefiniteMatrixIsToldAsSuch) {
  BlockMatrix matrix = make_chain(20, kSpring);
  add_block(matrix, 10, 10, (-20.0) * kIdentity);
  const std::vector<std::uint8_t> held(20, 0);
  const std::vector<Vec3> rhs = make_random_field(20, 1.0, 3);
  std::vector<Vec3> x(20);
  LinearSolver direct({LinearMethod::kDirect});
  EXPECT_EQ(direct.prepare(matrix, held), LinearStatus::kIndefinite);
  LinearSolver iterating({LinearMethod::kConjugateGradients});
  iterating.prepare(matrix, held);
  EXPECT_EQ(iterating.solve(rhs, x).status, LinearStatus::kIndefinite);
}

TEST(LinearSolver, IterationsThatRunOutAreToldAsSuch) {
  const BlockMatrix matrix = make_chain(200, kSpring);
  const std::vector<std::uint8_t> held(200, 0);
  LinearSolver solver({LinearMethod::kConjugateGradients, 1e-30, 3});
  solver.prepare(matrix, held);
  std::vector<Vec3> x(200);
  const LinearResult result = solver.solve(make_random_field(200, 1.0, 3), x);
  EXPECT_EQ(result.status, LinearStatus::kNotConverged);
  EXPECT_EQ(result.iterations, 3U);
}

TEST(BlockCholesky, IsExactWhereTheFactorFillsNothing) {
  // A chain's factor has the pattern of its lower half: what is left is the single precision.
  const Index n = 30;
  const BlockMatrix matrix = make_chain(n, kSpring);
  std::vector<std::uint8_t> held(n, 0);
  held[4] = 5;
  const BlockCholesky factor = factor_incomplete(matrix, held, 0.0);
  EXPECT_EQ(factor.shift, 0.0);
  std::vector<Vec3> truth = make_random_field(n, 1.0, 2);
  truth[4].x = truth[4].z = 0.0;
  std::vector<Vec3> rhs(n);
  multiply(matrix, truth, rhs);
  rhs[4].x = rhs[4].z = 0.0;
  std::vector<Vec3> x(n);
  apply_inverse(factor, rhs, x);
  EXPECT_LT(field_distance(x, truth), 1e-3 * field_norm(truth));  // 6e-8 x the condition number, about 4 n^2
}

TEST(BlockCholesky, AShiftKeepsItPositive) {
  BlockMatrix matrix = make_chain(30, kSpring);
  add_block(matrix, 10, 10, (-20.0) * kIdentity);
  const std::vector<std::uint8_t> held(30, 0);
  const BlockCholesky factor = factor_incomplete(matrix, held, 0.05);
  EXPECT_GT(factor.shift, 0.0);
  const std::vector<Vec3> b = make_random_field(30, 1.0, 2);
  std::vector<Vec3> x(30);
  apply_inverse(factor, b, x);
  double product = 0.0;
  for (std::size_t v = 0; v < 30; ++v) product += dot(b[v], x[v]);
  EXPECT_GT(product, 0.0);
}

TEST(BlockMatrix, ABlockOutsideThePatternIsAFault) {
  BlockMatrix matrix = make_chain(5, kSpring);
  EXPECT_THROW(add_block(matrix, 0, 4, kSpring), ContractError);
}

}  // namespace
}  // namespace palpate::dynamics
