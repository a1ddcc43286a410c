#include "core/judge/displacement/reference_estimate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/linear_elasticity.h"
#include "tests/support/small_meshes.h"

namespace palpate::judge {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

constexpr double kModulus = 1.5;
constexpr double kShear = 1.0;

using Field = std::vector<Vec3>;

/// A part of an error: `shape` x h^order.
struct Term {
  Field shape;
  double order;
};

Field random_field(std::size_t count, SplitMix64& random, double scale) {
  Field field(count);
  for (Vec3& u : field)
    u = scale * Vec3{random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
  return field;
}

void add(Field& sum, double factor, const Field& part) {
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = sum[i] + factor * part[i];
}

/// The truth plus the terms at h = 1, 1/2, 1/4, ...
std::vector<Field> levels_of(const Field& truth, const std::vector<Term>& terms, int count) {
  std::vector<Field> levels;
  for (int k = 0; k < count; ++k) {
    levels.push_back(truth);
    for (const Term& term : terms) add(levels.back(), std::exp2(-k * term.order), term.shape);
  }
  return levels;
}

class ReferenceEstimates : public ::testing::Test {
 protected:
  TetMesh mesh_ = build_kuhn_cube(3, 0.2, 1);
  SplitMix64 random_{77};
  Field truth_ = random_field(mesh_.points.size(), random_, 2.0);
  Field shape_ = random_field(mesh_.points.size(), random_, 0.05);

  ReferenceEstimate estimate(const std::vector<Field>& levels, const ReferenceOptions& options = {}) const {
    return estimate_reference(mesh_, levels, kModulus, kShear, options);
  }
  /// The true errors of the estimate's field, relative to that field as the estimate's are.
  DisplacementError true_error(const ReferenceEstimate& found) const {
    return compare_displacement(mesh_, truth_, found.field, kModulus, kShear);
  }
};

TEST_F(ReferenceEstimates, ASequenceOfOneOrderIsExtrapolatedToItsLimit) {
  for (const double order : {1.0, 1.5, 2.0, 3.0, 4.0}) {
    // The order 1 and 4 lie on the border of the rule: a little inside, so that rounding does not decide.
    const double inside = order == 1.0 ? 1.001 : (order == 4.0 ? 3.999 : order);
    const ReferenceEstimate found = estimate(levels_of(truth_, {{shape_, inside}}, 3));
    EXPECT_EQ(found.kind, ReferenceKind::kExtrapolated) << found.rule;
    ASSERT_TRUE(found.order && found.alignment && found.error.relative_l2);
    EXPECT_NEAR(*found.order, inside, 1e-10);
    EXPECT_NEAR(*found.alignment, 1.0, 1e-12);
    EXPECT_LE(true_error(found).relative_l2, 1e-12);
    EXPECT_EQ(found.levels, 3U);
    ASSERT_EQ(found.difference.size(), 2U);
    EXPECT_NEAR(found.difference[0] / found.difference[1], std::exp2(inside), 1e-9);
    const double x = std::exp2(inside) - 1.0;
    EXPECT_NEAR(*found.error.relative_l2, found.difference[1] * std::max(1.0 / x, 1.0 - 1.0 / x), 1e-12);
  }
}

TEST_F(ReferenceEstimates, OfMoreLevelsTheLastThreeCount) {
  std::vector<Field> levels = levels_of(truth_, {{shape_, 2.0}}, 4);
  const ReferenceEstimate all = estimate(levels);
  levels.erase(levels.begin());
  EXPECT_EQ(all.field, estimate(levels).field);
  EXPECT_EQ(all.levels, 4U);
  EXPECT_NEAR(*all.order, 2.0, 1e-10);
}

// The proof in docs/judge.md, by trial: sums of terms of different orders, that point the same way or nowhere
// in particular, are never better than they are said to be.
TEST_F(ReferenceEstimates, AreNeverOptimisticForMixturesOfOrders) {
  int extrapolated = 0;
  for (int trial = 0; trial < 400; ++trial) {
    std::vector<Term> terms;
    const std::size_t count = 1 + random_.below(4);
    for (std::size_t i = 0; i < count; ++i) {
      Field part(truth_.size());
      add(part, 0.2 + random_.uniform(), shape_);  // what all have in common
      const Field own = random_field(truth_.size(), random_, 0.05 * random_.uniform());
      add(part, 1.0, own);
      for (Vec3& u : part) u = std::exp2(4.0 * random_.uniform() - 2.0) * u;
      terms.push_back({part, 1.0 + 4.0 * random_.uniform()});
    }
    const std::size_t levels = 2 + random_.below(2);
    ReferenceOptions options;
    if (levels == 2 && trial % 3 > 0) options.stated_order = 1.0 + 3.0 * random_.uniform();
    const ReferenceEstimate found = estimate(levels_of(truth_, terms, static_cast<int>(levels)), options);
    const DisplacementError real = true_error(found);
    ASSERT_TRUE(found.error.relative_l2) << found.rule;
    EXPECT_LE(real.relative_l2, *found.error.relative_l2 * (1 + 1e-9)) << trial << ": " << found.rule;
    if (found.error.relative_energy) {
      EXPECT_LE(real.relative_energy, *found.error.relative_energy * (1 + 1e-9))
          << trial << ": " << found.rule;
    }
    if (found.kind == ReferenceKind::kExtrapolated) ++extrapolated;
  }
  EXPECT_GT(extrapolated, 200);
}

TEST_F(ReferenceEstimates, BelowOrderOneTheFinestIsTakenWithAnErrorThatHolds) {
  for (const double order : {0.3, 0.5, 0.9}) {
    const ReferenceEstimate found = estimate(levels_of(truth_, {{shape_, order}}, 3));
    EXPECT_EQ(found.kind, ReferenceKind::kFinest) << found.rule;
    EXPECT_NEAR(*found.order, order, 1e-10);
    // One term: the error is the true one, D / (2^p - 1), and not D.
    EXPECT_NEAR(*found.error.relative_l2, true_error(found).relative_l2, 1e-9);
    EXPECT_GT(*found.error.relative_l2, found.difference[1]);
  }
}

TEST_F(ReferenceEstimates, AboveOrderFourTheFinestIsTakenAndTheOrderNotBelieved) {
  const ReferenceEstimate found = estimate(levels_of(truth_, {{shape_, 6.0}}, 3));
  EXPECT_EQ(found.kind, ReferenceKind::kFinest) << found.rule;
  EXPECT_NEAR(*found.error.relative_l2, found.difference[0] / 16.0, 1e-12);
}

TEST_F(ReferenceEstimates, DifferencesThatDoNotShrinkGiveNoEstimate) {
  for (const double order : {0.0, -0.5}) {
    std::vector<Field> levels = levels_of(truth_, {{shape_, 1.0}}, 2);
    levels.push_back(levels[1]);
    Field step = levels[1];
    add(step, -1.0, levels[0]);
    add(levels[2], std::exp2(-order), step);
    const ReferenceEstimate found = estimate(levels);
    EXPECT_EQ(found.kind, ReferenceKind::kFinest);
    EXPECT_FALSE(found.error.relative_l2 || found.error.relative_max || found.error.relative_energy);
    EXPECT_TRUE(is_reference_too_coarse(1e9, found.error.relative_l2));
    EXPECT_EQ(found.field, levels[2]);
  }
}

TEST_F(ReferenceEstimates, DifferencesThatPointElsewhereAreNotExtrapolated) {
  // u, u + a, u + a - a / 2: the differences shrink by order 1, but swing.
  std::vector<Field> levels{truth_, truth_, truth_};
  add(levels[0], 1.0, shape_);
  add(levels[2], 0.5, shape_);
  const ReferenceEstimate found = estimate(levels);
  EXPECT_EQ(found.kind, ReferenceKind::kFinest);
  EXPECT_NEAR(*found.alignment, -1.0, 1e-12);
  EXPECT_NEAR(*found.error.relative_l2, found.difference[0], 1e-12);
  EXPECT_LE(true_error(found).relative_l2, *found.error.relative_l2);
}

TEST_F(ReferenceEstimates, TheSameLevelTwiceIsNoProof) {
  std::vector<Field> levels = levels_of(truth_, {{shape_, 2.0}}, 2);
  levels.push_back(levels[1]);
  EXPECT_FALSE(estimate(levels).error.relative_l2);
}

TEST_F(ReferenceEstimates, LevelsThatAgreeToSolverNoiseAreNotExtrapolated) {
  std::vector<Field> levels;
  for (int k = 0; k < 3; ++k) {
    levels.push_back(truth_);
    add(levels.back(), 1.0, random_field(truth_.size(), random_, 1e-9));
  }
  const ReferenceEstimate found = estimate(levels);
  EXPECT_EQ(found.kind, ReferenceKind::kFinest);
  EXPECT_LT(*found.error.relative_l2, 1e-8);
  EXPECT_GT(*found.error.relative_l2, 1e-11);
}

TEST_F(ReferenceEstimates, TwoLevelsAreExtrapolatedWithAStatedOrderOnly) {
  const std::vector<Field> levels = levels_of(truth_, {{shape_, 2.0}}, 2);
  const ReferenceEstimate plain = estimate(levels);
  EXPECT_EQ(plain.kind, ReferenceKind::kFinest);
  EXPECT_EQ(plain.field, levels[1]);
  EXPECT_FALSE(plain.order);
  EXPECT_NEAR(*plain.error.relative_l2, plain.difference[0], 1e-12);
  const ReferenceEstimate stated = estimate(levels, {.stated_order = 2.0});
  EXPECT_EQ(stated.kind, ReferenceKind::kExtrapolated);
  EXPECT_LE(true_error(stated).relative_l2, 1e-12);
  EXPECT_NEAR(*stated.error.relative_l2, stated.difference[0] * 2.0 / 3.0, 1e-12);
  for (const double bad : {0.9, 4.1, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THROW(estimate(levels, {.stated_order = bad}), InputError);
}

TEST_F(ReferenceEstimates, OneLevelHasNoEstimateAndEveryRowIsMarked) {
  const ReferenceEstimate found = estimate({truth_});
  EXPECT_EQ(found.field, truth_);
  EXPECT_FALSE(found.error.relative_l2 || found.error.relative_max || found.error.relative_energy);
  EXPECT_TRUE(found.difference.empty());
  EXPECT_TRUE(is_reference_too_coarse(0.5, found.error.relative_l2));
}

TEST_F(ReferenceEstimates, QuadraticNodesAreTakenToo) {
  const TetMesh tet = make_corner_tet();
  truth_ = random_field(10, random_, 1.0);
  const ReferenceEstimate found = estimate_reference(
      tet, levels_of(truth_, {{random_field(10, random_, 0.1), 2.0}}, 3), kModulus, kShear, {});
  EXPECT_LE(compare_displacement(tet, truth_, found.field, kModulus, kShear).relative_energy, 1e-12);
}

TEST_F(ReferenceEstimates, BadInput) {
  EXPECT_THROW(estimate({}), ContractError);
  EXPECT_THROW(estimate({truth_, Field(truth_.size() - 1)}), ContractError);
  EXPECT_THROW(estimate({truth_, Field(truth_.size())}), InputError);
  Field broken = truth_;
  broken[3].z = std::numeric_limits<double>::infinity();
  EXPECT_THROW(estimate({broken, truth_}), InputError);
}

TEST(ReferenceMark, FiveTimesBetterOrMarked) {
  EXPECT_FALSE(is_reference_too_coarse(0.05, 0.01));
  EXPECT_TRUE(is_reference_too_coarse(0.0499, 0.01));
  EXPECT_TRUE(is_reference_too_coarse(0.05, std::nullopt));
  EXPECT_TRUE(is_reference_too_coarse(std::numeric_limits<double>::quiet_NaN(), 0.01));
}

/// Linear tets on the cube with 2, 4, 8 cells a side, at the vertices of the coarsest.
class TrueProblem : public ::testing::Test {
 protected:
  static constexpr LameParameters kMaterial{kModulus, kShear};

  /// Every second (fourth, ...) vertex of the finer cubes is one of the coarser ones.
  std::vector<Field> solve(const LameParameters& material) const {
    std::vector<Field> levels;
    for (const int cells : {4, 8, 16}) {
      const TetMesh fine = build_kuhn_cube(cells, 0.0, 1);
      const Field all = solve_smooth_problem(fine, material, kMaterial);
      const auto step = static_cast<std::size_t>(cells / 4);
      const auto side = static_cast<std::size_t>(cells) + 1;
      Field at;
      for (const Vec3& p : mesh_.points) {
        const auto grid = [&](double x) { return step * static_cast<std::size_t>(std::lround(4.0 * x)); };
        const std::size_t v = (grid(p.z) * side + grid(p.y)) * side + grid(p.x);
        EXPECT_LE(length(fine.points[v] - p), 1e-15);
        at.push_back(all[v]);
      }
      levels.push_back(std::move(at));
    }
    return levels;
  }

  ReferenceEstimate estimate(const std::vector<Field>& levels) const {
    return estimate_reference(mesh_, levels, kModulus, kShear);
  }

  TetMesh mesh_ = build_kuhn_cube(4, 0.0, 1);
  Field truth_ = [this] {
    Field field;
    for (const Vec3& p : mesh_.points) field.push_back(smooth_displacement(p));
    return field;
  }();
};

TEST_F(TrueProblem, OrderTwoIsObservedAndTheErrorHolds) {
  const std::vector<Field> levels = solve(kMaterial);
  const ReferenceEstimate found = estimate(levels);
  EXPECT_EQ(found.kind, ReferenceKind::kExtrapolated) << found.rule;
  EXPECT_NEAR(*found.order, 2.0, 0.2);
  const auto error_of = [&](const Field& field) {
    return compare_displacement(mesh_, field, truth_, kModulus, kShear).relative_l2;
  };
  EXPECT_LE(error_of(found.field), *found.error.relative_l2);
  EXPECT_LT(error_of(found.field), 0.5 * error_of(levels.back()));
  // Without the last level: still no better than it is said to be.
  const std::vector<Field> coarse(levels.begin(), levels.end() - 1);
  const ReferenceEstimate two = estimate(coarse);
  EXPECT_LE(error_of(two.field), *two.error.relative_l2);
}

// A reference that is wrong at every level converges as well as a right one. Linear tets, refined, have the
// same limit as a right one and not that of a wrong one.
TEST_F(TrueProblem, AWrongReferenceIsFoundByAnotherMethod) {
  const ReferenceEstimate linear = estimate(solve(kMaterial));
  ReferenceEstimate right;
  right.field = truth_;
  right.error = {0.001, 0.001, 0.001, 0.001};
  const ReferenceAgreement good = compare_references(mesh_, right, linear, kModulus, kShear);
  EXPECT_TRUE(good.agree) << good.relative_l2 << " " << *good.expected;

  ReferenceEstimate scaled = right;
  for (Vec3& u : scaled.field) u = 1.05 * u;
  EXPECT_FALSE(compare_references(mesh_, scaled, linear, kModulus, kShear).agree);

  const ReferenceEstimate other = estimate(solve({4.0 * kModulus, kShear}));  // nu 0.3 taken for 0.43
  ASSERT_TRUE(other.error.relative_l2);
  EXPECT_LT(*other.error.relative_l2, 0.05) << "its own estimate says nothing";
  EXPECT_FALSE(compare_references(mesh_, right, other, kModulus, kShear).agree);
  EXPECT_FALSE(compare_references(mesh_, linear, other, kModulus, kShear).agree);

  ReferenceEstimate unknown = right;
  unknown.error = {};
  const ReferenceAgreement none = compare_references(mesh_, unknown, linear, kModulus, kShear);
  EXPECT_FALSE(none.agree || none.expected);
}

}  // namespace
}  // namespace palpate::judge
