#include "core/dynamics/linear_algebra/laplace_factor.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "core/base/error.h"
#include "core/base/random.h"
#include "tests/support/dynamics_cases.h"

namespace palpate::dynamics {
namespace {

/// A random graph's Laplacian plus 1 on the diagonal: eigenvalues from 1 to 1 + twice the largest degree.
std::vector<ScalarEntry> random_laplacian(std::size_t size, SplitMix64& random) {
  std::vector<ScalarEntry> entries;
  for (std::size_t v = 0; v < size; ++v)
    entries.push_back({static_cast<Index>(v), static_cast<Index>(v), 1.0});
  for (std::size_t k = 0; k < 4 * size; ++k) {
    const auto a = static_cast<Index>(random.below(size));
    const auto b = static_cast<Index>(random.below(size));
    if (a == b) continue;
    const double weight = random.uniform();
    entries.push_back({a, a, weight});
    entries.push_back({b, b, weight});
    entries.push_back({a, b, -weight});
  }
  return entries;
}

TEST(LaplaceFactor, SolvesAsADenseFactorisationDoes) {
  SplitMix64 random(7);
  constexpr std::size_t kSize = 80;
  const std::vector<ScalarEntry> entries = random_laplacian(kSize, random);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(kSize, kSize);
  for (const ScalarEntry& entry : entries) {
    dense(entry.row, entry.column) += entry.value;
    if (entry.row != entry.column) dense(entry.column, entry.row) += entry.value;
  }
  const std::vector<Vec3> b = testing_support::make_random_field(kSize, 1.0, 3);
  std::vector<Vec3> x(kSize);
  LaplaceScratch scratch;
  solve(factor_laplace(kSize, entries), b, scratch, x);
  Eigen::MatrixXd right(kSize, 3);
  for (Eigen::Index v = 0; v < right.rows(); ++v) {
    const Vec3& each = b[static_cast<std::size_t>(v)];
    right.row(v) << each.x, each.y, each.z;
  }
  const Eigen::MatrixXd wanted = dense.llt().solve(right);
  double off = 0.0;
  for (Eigen::Index v = 0; v < right.rows(); ++v) {
    const Vec3& found = x[static_cast<std::size_t>(v)];
    off = std::max(off, (wanted.row(v) - Eigen::RowVector3d(found.x, found.y, found.z)).norm());
  }
  // Single precision times the condition number, some 20.
  EXPECT_LT(off, 1e-5 * wanted.norm());
  EXPECT_GT(off, 0.0) << "it is single precision";
}

TEST(LaplaceFactor, RefusesWhatIsNotPositiveDefinite) {
  const std::vector<ScalarEntry> entries{{0, 0, 1.0}, {1, 1, 1.0}, {1, 0, 2.0}};
  EXPECT_THROW(factor_laplace(2, entries), InputError);
}

}  // namespace
}  // namespace palpate::dynamics
