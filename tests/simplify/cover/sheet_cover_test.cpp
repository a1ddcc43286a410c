#include "core/simplify/cover/sheet_cover.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/random.h"
#include "core/judge/surface/surface.h"
#include "tests/support/triangle_corners.h"

namespace palpate::simplify {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

constexpr Index kCells = 6;

/// A sheet of jittered triangles over the square from 0 to kCells, with heights up to `height`.
SurfaceMesh random_sheet(double height, SplitMix64& random) {
  SurfaceMesh sheet;
  for (Index y = 0; y <= kCells; ++y) {
    for (Index x = 0; x <= kCells; ++x) {
      const double jitter = 0.25;
      sheet.points.push_back({x + jitter * (2.0 * random.uniform() - 1.0),
                              y + jitter * (2.0 * random.uniform() - 1.0), height * random.uniform()});
    }
  }
  for (Index y = 0; y < kCells; ++y) {
    for (Index x = 0; x < kCells; ++x) {
      const Index a = y * (kCells + 1) + x;
      const Index b = a + 1;
      const Index c = a + kCells + 2;
      const Index d = a + kCells + 1;
      if (random.below(2) == 0) {
        sheet.triangles.push_back({a, b, c});
        sheet.triangles.push_back({a, c, d});
      } else {
        sheet.triangles.push_back({a, b, d});
        sheet.triangles.push_back({b, c, d});
      }
    }
  }
  return sheet;
}

/// A triangle above the sheet's middle, turned up.
SurfaceMesh random_triangle(double height, SplitMix64& random) {
  SurfaceMesh one{{}, {{0, 1, 2}}};
  const double turn = 6.28 * random.uniform();
  const double size = 0.3 + 1.5 * random.uniform();
  const double middle_x = 2.5 + random.uniform();
  const double middle_y = 2.5 + random.uniform();
  for (int k = 0; k < 3; ++k) {
    const double angle = turn + 2.094 * k + 0.6 * random.uniform();
    one.points.push_back(
        {middle_x + size * std::cos(angle), middle_y + size * std::sin(angle), height * random.uniform()});
  }
  return one;
}

/// What SheetCover is asked, seen against `direction`.
struct Question {
  std::vector<Tile> by;
  Tile t;
  std::vector<Index> used;
  double reach = 0.0;  ///< after a yes

  Question(const SurfaceMesh& one, const SurfaceMesh& sheet, const Vec3& direction = {0.0, 0.0, 1.0}) {
    SheetCover cover(1.0);
    cover.look_against(direction, one.points.front());
    for (std::size_t i = 0; i < sheet.triangles.size(); ++i)
      by.push_back(cover.tile(sheet.triangles[i], triangle_corners(sheet, i)));
    t = cover.tile(one.triangles.front(), triangle_corners(one, 0));
  }

  bool holds(double limit) {
    SheetCover cover(limit);
    const bool is_covered = cover.is_covered(t, by, used);
    reach = cover.reach();
    return is_covered;
  }
};

/// The height of a sheet over (x, y), by looking at each triangle for itself.
double height_of(const SurfaceMesh& sheet, double x, double y) {
  for (std::size_t i = 0; i < sheet.triangles.size(); ++i) {
    const auto [a, b, c] = triangle_corners(sheet, i);
    const auto area = [](const Vec3& p, const Vec3& q, double u, double v) {
      return (q.x - p.x) * (v - p.y) - (q.y - p.y) * (u - p.x);
    };
    const double wa = area(b, c, x, y);
    const double wb = area(c, a, x, y);
    const double wc = area(a, b, x, y);
    if (wa >= 0.0 && wb >= 0.0 && wc >= 0.0) return (wa * a.z + wb * b.z + wc * c.z) / (wa + wb + wc);
  }
  return std::numeric_limits<double>::quiet_NaN();
}

/// The greatest difference of heights at many places of a triangle: a bit less than the greatest of all.
double sampled_difference(const SurfaceMesh& one, const SurfaceMesh& sheet) {
  constexpr int kSteps = 60;
  double greatest = 0.0;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; i + j <= kSteps; ++j) {
      const double u = static_cast<double>(i) / kSteps;
      const double v = static_cast<double>(j) / kSteps;
      const Vec3 p = (1.0 - u - v) * one.points[0] + u * one.points[1] + v * one.points[2];
      greatest = std::max(greatest, std::fabs(p.z - height_of(sheet, p.x, p.y)));
    }
  }
  return greatest;
}

TEST(SheetCover, SaysYesFromTheGreatestDifferenceOfHeightsOn) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SplitMix64 random(seed);
    const SurfaceMesh sheet = random_sheet(0.6, random);
    const SurfaceMesh one = random_triangle(0.6, random);
    Question question(one, sheet);
    const double sampled = sampled_difference(one, sheet);
    EXPECT_FALSE(question.holds(0.999 * sampled)) << "seed " << seed;
    EXPECT_TRUE(question.holds(sampled + 0.1)) << "seed " << seed;  // slopes of 2, places 0.05 apart
    EXPECT_GE(question.reach, sampled) << "seed " << seed;
    EXPECT_LE(question.reach, sampled + 0.1) << "seed " << seed;
    const double reach = question.reach;
    EXPECT_TRUE(question.holds(reach + 1e-12)) << "seed " << seed;
    EXPECT_FALSE(question.used.empty());
    EXPECT_FALSE(question.holds(reach - 1e-6)) << "seed " << seed;
  }
}

TEST(SheetCover, ItsYesStandsBeforeTheJudge) {
  std::size_t yes = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SplitMix64 random(seed);
    const SurfaceMesh sheet = random_sheet(seed % 3 == 0 ? 2.0 : 0.6, random);
    const SurfaceMesh one = random_triangle(0.8, random);
    const Vec3 direction{0.6 * random.uniform() - 0.3, 0.6 * random.uniform() - 0.3, 1.0};
    Question question(one, sheet, direction);
    const judge::SurfaceDistance exact = judge::measure_surface_distance(one, sheet);
    for (const double limit : {0.2, 0.4, 0.6, 0.9}) {
      if (!question.holds(limit)) continue;
      ++yes;
      EXPECT_GE(question.reach, exact.forward.lower) << "seed " << seed;
      EXPECT_LE(question.reach, limit) << "seed " << seed;
      // What it used is enough by itself.
      SurfaceMesh enough{sheet.points, {}};
      for (const Index i : question.used) enough.triangles.push_back(sheet.triangles[i]);
      EXPECT_GE(question.reach, judge::measure_surface_distance(one, enough).forward.lower)
          << "seed " << seed;
    }
  }
  EXPECT_GT(yes, 300U);
}

TEST(SheetCover, SaysNoWhereATileIsMissingOrTurnedAway) {
  std::size_t inner = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    SplitMix64 random(seed);
    const SurfaceMesh sheet = random_sheet(0.2, random);
    const SurfaceMesh one = random_triangle(0.2, random);
    Question whole(one, sheet);
    ASSERT_TRUE(whole.holds(1.0));
    const std::vector<Index> used = whole.used;
    for (const Index i : used) {
      Question missing = whole;
      missing.by.erase(missing.by.begin() + i);
      EXPECT_FALSE(missing.holds(1.0)) << "seed " << seed << ", tile " << i;
      SurfaceMesh turned = sheet;
      std::swap(turned.triangles[i][0], turned.triangles[i][1]);
      EXPECT_FALSE(Question(one, turned).holds(1.0)) << "seed " << seed << ", tile " << i;
    }
    if (used.size() > 4) ++inner;
  }
  EXPECT_GT(inner, 30U);  // of which some tiles lie inside the triangle and hold none of its corners
}

TEST(SheetCover, SeesATipInsideAndARidgeAcrossASide) {
  const SurfaceMesh one{{{0, 0, 0}, {6, 0, 0}, {0, 6, 0}}, {{0, 1, 2}}};
  // A fan around a tip of height 1 over (1, 1), flat along its rim.
  const SurfaceMesh tip{{{1, 1, 1}, {-9, -9, 0}, {19, -9, 0}, {-9, 19, 0}},
                        {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}}};
  EXPECT_TRUE(Question(one, tip).holds(1.001));
  EXPECT_FALSE(Question(one, tip).holds(0.999));
  // A roof whose ridge runs over (3, y): only where it crosses the sides is it 1 above the
  // triangle.
  const SurfaceMesh roof{
      {{3, -9, 1}, {3, 19, 1}, {-9, -9, -3}, {-9, 19, -3}, {19, -9, -13. / 3}, {19, 19, -13. / 3}},
      {{0, 1, 2}, {1, 3, 2}, {0, 4, 1}, {4, 5, 1}}};
  EXPECT_TRUE(Question(one, roof).holds(1.001));
  EXPECT_FALSE(Question(one, roof).holds(0.999));
}

TEST(SheetCover, WhatOnlyTouchesIsNotUsed) {
  const SurfaceMesh sheet{{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 0, 0}},
                          {{0, 1, 2}, {0, 2, 3}, {1, 4, 2}}};
  const SurfaceMesh same{{{0, 0, 0.1}, {1, 0, 0.1}, {1, 1, 0.1}}, {{0, 1, 2}}};
  Question question(same, sheet);
  EXPECT_TRUE(question.holds(0.2));
  EXPECT_EQ(question.used, (std::vector<Index>{0}));
  const SurfaceMesh both{{{0.2, 0.1, 0.1}, {0.9, 0.1, 0.1}, {0.2, 0.9, 0.1}}, {{0, 1, 2}}};
  Question over_both(both, sheet);
  EXPECT_TRUE(over_both.holds(0.2));
  EXPECT_EQ(over_both.used, (std::vector<Index>{0, 1}));
}

TEST(SheetCover, NoNumberNoAreaNoYes) {
  const SurfaceMesh sheet{{{-9, -9, 0}, {9, -9, 0}, {0, 9, 0}}, {{0, 1, 2}}};
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const SurfaceMesh& one : {SurfaceMesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, nan}}, {{0, 1, 2}}},
                                 SurfaceMesh{{{0, 0, 0}, {1, 0, 0}, {0.5, nan, 0}}, {{0, 1, 2}}},
                                 SurfaceMesh{{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}}},
                                 SurfaceMesh{{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}, {{0, 1, 2}}}}) {
    EXPECT_FALSE(Question(one, sheet).holds(1.0));
  }
  const SurfaceMesh one{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  EXPECT_TRUE(Question(one, sheet).holds(1.0));
  EXPECT_FALSE(Question(one, sheet, {0, 0, -1}).holds(1.0));  // from behind
  EXPECT_FALSE(Question(one, sheet, {1, 0, 0}).holds(1.0));   // from the side
  EXPECT_FALSE(Question(one, sheet).holds(0.0));              // rounding has no room
}

}  // namespace
}  // namespace palpate::simplify
