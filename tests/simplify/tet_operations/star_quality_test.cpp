#include "core/simplify/tet_operations/star_quality.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/random.h"
#include "core/judge/mesh/tet_shape.h"
#include "core/mesh/orientation.h"
#include "core/simplify/quality/quality.h"

namespace palpate::simplify {
namespace {

using Corners = std::array<Vec3, 4>;

Vec3 random_point(SplitMix64& random) {
  const double x = random.uniform();
  const double y = random.uniform();
  return {x, y, random.uniform()};
}

/// A positive tet in the unit cube, moved and scaled.
Corners random_tet(SplitMix64& random, double size, const Vec3& at) {
  Corners p;
  do {
    for (Vec3& x : p) x = random_point(random);
  } while (orientation(p[0], p[1], p[2], p[3]) <= 0);
  for (Vec3& x : p) x = at + size * x;
  return p;
}

/// The score by the formula in the header, in double precision, from other code.
double exact_score(const ScoreScale& scale, const Corners& p) {
  const TetFigures figures = measure_tet(kThesisMetric, p[0], p[1], p[2], p[3]);
  double cube = figures.shape * std::min(1.0, figures.volume / scale.ideal_volume);
  const judge::TetShape shape = judge::measure_tet(p[0], p[1], p[2], p[3]);
  if (scale.form == ScoreForm::kMeanRatio)
    cube = 0.2 * std::pow(shape.mean_ratio, 3.0) * std::min(1.0, 2.5 * figures.volume / scale.ideal_volume);
  const double sine =
      std::min(std::sin(shape.min_dihedral), std::sin(shape.max_dihedral));  // farthest from 90 degrees
  return std::min(cube, scale.dihedral_weight * sine * sine);
}

TEST(StarQuality, ScoresAreThoseOfTheFormula) {
  SplitMix64 random(3);
  for (const double size : {1.0, 1e-6, 2e7}) {
    for (const Vec3& at : {Vec3{0, 0, 0}, Vec3{30.0 * size, -70.0 * size, 4.0 * size}}) {
      for (int i = 0; i < 2000; ++i) {
        const Corners p = random_tet(random, size, at);
        const ScoreForm form = i % 2 == 0 ? ScoreForm::kSolidAngle : ScoreForm::kMeanRatio;
        const ScoreScale scale = scale_of_ideal_volume(0.03 * size * size * size, form);
        const double exact = exact_score(scale, p);
        const double score = score_tet(scale, p[0], p[1], p[2], p[3]);
        // Coordinates are rounded to 2^-24 of the tet's size. The volume's relative error is that over the
        // least height, which the score bounds: tets of score s have a height of at least about s.
        EXPECT_NEAR(score, exact, 1e-5 * exact + 1e-5) << size << " " << i;
      }
    }
  }
}

TEST(StarQuality, RegularTetScoresItsDihedralBoundAndFlatOnesNothing) {
  const double h = std::sqrt(2.0 / 3.0);
  const Corners p{Vec3{0, 0, 0}, Vec3{1, 0, 0}, Vec3{0.5, std::sqrt(0.75), 0},
                  Vec3{0.5, std::sqrt(1.0 / 12.0), h}};
  ScoreScale scale = scale_of_ideal_volume(std::sqrt(2.0) / 12.0);
  // sin^2 of the dihedral angle arccos(1/3) is 8/9.
  EXPECT_NEAR(score_tet(scale, p[0], p[1], p[2], p[3]), scale.dihedral_weight * 8.0 / 9.0, 1e-6);
  scale.dihedral_weight = 10.0;
  // The first term left out of the series is x^8 / 9 = 4.6e-6 for the regular tet, x = 0.283.
  EXPECT_NEAR(score_tet(scale, p[0], p[1], p[2], p[3]), 0.551286 / 0.55, 6e-6);
  EXPECT_LT(score_tet(scale, p[0], p[2], p[1], p[3]), 0.0);
  EXPECT_NEAR(score_tet(scale, p[0], p[1], p[2], {0.3, 0.3, 0.0}), 0.0, 1e-6);
}

TEST(StarQuality, EvaluatesAllItsTetsWhateverTheirNumber) {
  SplitMix64 random(8);
  for (std::size_t n = 1; n < 30; ++n) {
    const Vec3 apex = random_point(random);
    std::vector<Corners> tets;
    while (tets.size() < n) {
      Corners p = random_tet(random, 1.0, {});
      p[0] = apex;
      if (orientation(p[0], p[1], p[2], p[3]) > 0) tets.push_back(p);
    }
    const ScoreScale scale = scale_of_ideal_volume(0.02);
    StarQuality star;
    star.start(scale, apex);
    for (const Corners& p : tets) star.add(p[1], p[2], p[3]);
    star.close();
    ASSERT_EQ(star.size(), n);
    std::vector<float> scores;
    star.scores(apex, scores);
    ASSERT_EQ(scores.size(), n);
    double worst = 1e300;
    double sum = 0.0;
    for (std::size_t i = 0; i < n; ++i) {
      EXPECT_EQ(scores[i], score_tet(scale, tets[i][0], tets[i][1], tets[i][2], tets[i][3]));
      worst = std::min(worst, double{scores[i]});
      sum += gain_of_score(scale, double{scores[i]});
    }
    const StarFigures figures = star.evaluate(apex);
    EXPECT_EQ(figures.worst, worst);
    EXPECT_NEAR(figures.sum, sum, 1e-5 * std::fabs(sum));
    EXPECT_LT(star.evaluate(apex, 1.0).worst, 1.0);  // ends early, and says that it is below the bound
    EXPECT_TRUE(star.is_positive(apex));
    std::vector<float> behind;
    star.scores_from_behind(apex, behind);
    for (std::size_t i = 0; i < n; ++i) EXPECT_LE(behind[i], 0.0);
  }
}

TEST(StarQuality, FromBehindIsTheMirroredTet) {
  SplitMix64 random(5);
  const ScoreScale scale = scale_of_ideal_volume(0.02);
  for (int i = 0; i < 300; ++i) {
    const Corners p = random_tet(random, 1.0, {});
    StarQuality star;
    star.start(scale, p[0]);
    star.add(p[1], p[3], p[2]);
    star.close();
    std::vector<float> scores;
    star.scores_from_behind(p[0], scores);
    const double direct = score_tet(scale, p[0], p[1], p[2], p[3]);
    EXPECT_NEAR(scores[0], direct, 1e-5 * direct + 1e-6);
    EXPECT_FALSE(star.is_positive(p[0]));
  }
}

TEST(StarQuality, FiguresBeyondSinglePrecisionAreNeverGood) {
  const ScoreScale scale = scale_of_ideal_volume(1.0);
  for (const double size : {1e-30, 1e-15, 1e15, 1e30, 1e100}) {
    const double score = score_tet(scale, {0, 0, 0}, {size, 0, 0}, {0, size, 0}, {0, 0, size});
    EXPECT_FALSE(std::isnan(score));
    EXPECT_LT(score, 0.6) << size;  // the corner tet's own score is 0.51 at most
  }
}

TEST(StarQuality, VolumeCentroidOfAnOctahedronSeenFromInside) {
  const std::array<Vec3, 6> p{Vec3{1, 0, 0},  Vec3{-1, 0, 0}, Vec3{0, 1, 0},
                              Vec3{0, -1, 0}, Vec3{0, 0, 1},  Vec3{0, 0, -1}};
  StarQuality star;
  const Vec3 apex{0.2, -0.1, 0.3};
  star.start(scale_of_ideal_volume(0.1), apex);
  for (std::size_t s = 0; s < 8; ++s) {
    const Vec3& a = p[s & 1U];
    const Vec3& b = p[2 + (s >> 1U & 1U)];
    const Vec3& c = p[4 + (s >> 2U & 1U)];
    if (orientation(apex, a, b, c) > 0) {
      star.add(a, b, c);
    } else {
      star.add(a, c, b);
    }
  }
  star.close();
  const Vec3 centroid = star.volume_centroid(apex);
  EXPECT_NEAR(length(centroid), 0.0, 1e-15);  // of the whole octahedron, wherever the apex is
}

TEST(GainOfScore, GrowsAndIsSteeperWhereScoresAreLow) {
  const ScoreScale scale;
  EXPECT_LT(gain_of_score(scale, 0.1), gain_of_score(scale, 0.2));
  EXPECT_GT(gain_of_score(scale, 0.2) - gain_of_score(scale, 0.1),
            gain_of_score(scale, 0.5) - gain_of_score(scale, 0.4));
  EXPECT_EQ(gain_of_score(scale, -3.0), gain_of_score(scale, 0.0));
}

}  // namespace
}  // namespace palpate::simplify
