#include "core/simplify/quality/batch_quality.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/base/random.h"
#include "core/mesh/orientation.h"

namespace palpate::simplify {
namespace {

using Corners = std::array<Vec3, 4>;

/// Tets of all kinds: round, flat down to 10^-8, far from the origin, small and large.
std::vector<Corners> make_tets(int count) {
  SplitMix64 random(7);
  std::vector<Corners> tets;
  for (int n = 0; n < count; ++n) {
    const double flat = n % 3 == 0 ? std::pow(10.0, -8.0 * random.uniform()) : 1.0;
    const double size = std::pow(10.0, 6.0 * random.uniform() - 3.0);
    const double far = n % 5 == 0 ? 1000.0 * size : 0.0;
    Corners p;
    for (Vec3& x : p) {
      x = {far + size * random.uniform(), size * random.uniform(), size * flat * random.uniform()};
    }
    tets.push_back(p);
  }
  return tets;
}

void add(TetBatch& batch, const Corners& p) {
  batch.add(p[0], p[1], p[2], p[3]);
}

TEST(BatchQuality, IsTheQualityFactorOnTheGrid) {
  for (const QualityMetric& metric : {kThesisMetric, kMeanRatioMetric, QualityMetric{thesis_shape, false}}) {
    int positive = 0;
    for (const Corners& p : make_tets(4000)) {
      const double ideal_volume = std::abs(length_sq(p[1] - p[0])) * std::sqrt(length_sq(p[1] - p[0])) / 9.0;
      TetBatch batch;
      add(batch, p);
      measure_batch(metric, ideal_volume, batch);
      const bool is_up = orientation(p[0], p[1], p[2], p[3]) > 0;
      EXPECT_EQ(is_positive(batch, 0), is_up);
      EXPECT_EQ(batch.quality[0], std::ldexp(std::round(std::ldexp(batch.quality[0], 36)), -36));
      if (!is_up) continue;
      ++positive;
      const double q = quality_factor(metric, measure_tet(metric, p[0], p[1], p[2], p[3]), ideal_volume);
      EXPECT_NEAR(batch.quality[0], q, 0x1p-36);
    }
    EXPECT_GT(positive, 1500);
  }
}

TEST(BatchQuality, APlaceInABatchDoesNotShow) {
  const std::vector<Corners> tets = make_tets(TetBatch::kCapacity);
  for (std::size_t size = 1; size <= tets.size(); ++size) {
    TetBatch batch;
    for (std::size_t i = 0; i < size; ++i) add(batch, tets[tets.size() - size + i]);
    measure_batch(kThesisMetric, 0.02, batch);
    TetBatch alone;
    add(alone, tets.back());
    measure_batch(kThesisMetric, 0.02, alone);
    EXPECT_EQ(batch.quality[size - 1], alone.quality[0]) << size;
  }
}

TEST(BatchQuality, ARegularTetHasTheThesisQuality) {
  TetBatch batch;
  batch.add({1, 1, 1}, {-1, 1, -1}, {1, -1, -1}, {-1, -1, 1});
  measure_batch(kThesisMetric, 8.0 / 3.0, batch);
  // Solid angle 3 acos(1/3) - pi at each corner.
  EXPECT_NEAR(batch.quality[0], std::cbrt((3.0 * std::acos(1.0 / 3.0) - std::acos(-1.0)) / 0.55), 0x1p-36);
}

TEST(BatchQuality, FlatAndInvertedTetsHaveNone) {
  TetBatch batch;
  batch.add({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0});
  batch.add({0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1});
  batch.add({0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0});
  measure_batch(kThesisMetric, 0.1, batch);
  for (std::size_t i = 0; i < batch.size; ++i) {
    EXPECT_FALSE(is_positive(batch, i));
    EXPECT_EQ(batch.quality[i], 0.0) << i;
  }
}

TEST(BatchQuality, SumsOnTheGridDoNotDependOnTheirOrder) {
  SplitMix64 random(3);
  std::vector<double> terms(60000);
  for (double& term : terms) term = round_to_grid(random.uniform());
  double forward = 0.0;
  for (const double term : terms) forward += term;
  shuffle(std::span<double>(terms), random);
  double shuffled = 0.0;
  for (const double term : terms) shuffled += term;
  EXPECT_EQ(forward, shuffled);
}

}  // namespace
}  // namespace palpate::simplify
