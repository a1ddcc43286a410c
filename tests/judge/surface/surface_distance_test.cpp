#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/judge/surface/surface.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/small_meshes.h"

namespace palpate::judge {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

constexpr double kRounding = 1e-14;  // a few roundings of coordinates of size 1
const SurfaceDistanceOptions kTight{.relative_gap = 1e-6};

SurfaceMesh scaled(SurfaceMesh surface, double factor) {
  for (Vec3& p : surface.points) p = factor * p;
  return surface;
}

SurfaceMesh moved(SurfaceMesh surface, const Vec3& by) {
  for (Vec3& p : surface.points) p = p + by;
  return surface;
}

/// Checks that the bracket holds the exact value and is as narrow as was asked for.
void expect_bracket(double lower, double upper, double exact, const SurfaceDistanceOptions& options,
                    double diagonal) {
  EXPECT_LE(lower, exact + kRounding);
  EXPECT_GE(upper, exact - kRounding);
  EXPECT_LE(upper, std::max(lower * (1.0 + options.relative_gap), lower + options.absolute_gap * diagonal));
}

/// A unit square from below z = 0, its middle at height `middle`, four triangles; or two if it is flat.
SurfaceMesh make_square(double middle, bool is_divided) {
  SurfaceMesh square;
  square.points = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, middle}};
  if (is_divided) {
    square.triangles = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  } else {
    square.triangles = {{0, 1, 2}, {0, 2, 3}};
  }
  return square;
}

/// Squared distance by another way than the judge's: the best of the plane's point, if its weights are all
/// positive, and of many points on the sides, each side by its own quadratic.
double brute_distance(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const auto to_side = [&](const Vec3& u, const Vec3& v) {
    const Vec3 side = v - u;
    const double t = std::min(1.0, std::max(0.0, dot(p - u, side) / length_sq(side)));
    return length(p - (1.0 - t) * u - t * v);
  };
  double best = std::min({to_side(a, b), to_side(b, c), to_side(c, a)});
  const Vec3 u = b - a;
  const Vec3 v = c - a;
  const Vec3 w = p - a;
  const double determinant = length_sq(u) * length_sq(v) - dot(u, v) * dot(u, v);
  const double s = (dot(w, u) * length_sq(v) - dot(w, v) * dot(u, v)) / determinant;
  const double t = (dot(w, v) * length_sq(u) - dot(w, u) * dot(u, v)) / determinant;
  if (s >= 0.0 && t >= 0.0 && s + t <= 1.0) best = std::min(best, length(w - s * u - t * v));
  return best;
}

struct Sampled {
  double largest = 0.0;
  double reach = 0.0;  ///< no point of the surface is farther from a sample
};

Sampled brute_directed(const SurfaceMesh& from, const SurfaceMesh& to, int n) {
  Sampled result;
  for (const Triangle& t : from.triangles) {
    const Vec3& a = from.points[t[0]];
    const Vec3 u = (1.0 / n) * (from.points[t[1]] - a);
    const Vec3 v = (1.0 / n) * (from.points[t[2]] - a);
    result.reach = std::max({result.reach, length(u), length(v), length(u - v)});
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; i + j <= n; ++j) {
        const Vec3 p = a + static_cast<double>(i) * u + static_cast<double>(j) * v;
        double nearest = std::numeric_limits<double>::infinity();
        for (const Triangle& s : to.triangles) {
          nearest = std::min(nearest, brute_distance(p, to.points[s[0]], to.points[s[1]], to.points[s[2]]));
        }
        result.largest = std::max(result.largest, nearest);
      }
    }
  }
  return result;
}

TEST(SurfaceDistance, ConcentricGeodesicSpheres) {
  const SurfaceMesh inner = build_geodesic_sphere(6);
  const SurfaceMesh outer = scaled(inner, 1.2);
  double greatest_height = 0.0;  // of the faces' planes over the centre
  for (const Triangle& t : inner.triangles) {
    const Vec3& a = inner.points[t[0]];
    const Vec3 normal = cross(inner.points[t[1]] - a, inner.points[t[2]] - a);
    greatest_height = std::max(greatest_height, dot(normal, a) / length(normal));
  }
  const SurfaceDistance d = measure_surface_distance(outer, inner, kTight);
  expect_bracket(d.forward.lower, d.forward.upper, 0.2, kTight, d.diagonal);  // at the corners
  // From inside, a face is below the face 1.2 times as far out.
  expect_bracket(d.backward.lower, d.backward.upper, 0.2 * greatest_height, kTight, d.diagonal);
  EXPECT_EQ(d.upper(), d.forward.upper);
}

TEST(SurfaceDistance, TranslatedCube) {
  const SurfaceMesh cube = build_boundary(make_kuhn_block(1, 1, 1));
  ASSERT_EQ(cube.triangles.size(), 12U);
  const double shift = 0.125;
  const SurfaceDistance d = measure_surface_distance(moved(cube, {shift, 0, 0}), cube, kTight);
  // The end that left is `shift` away, the other one at most so; along the sides a strip stands out.
  const double inner = shift / 3.0 * (1.0 + (1.0 - 2.0 * shift) * (2.0 - 2.0 * shift));
  const double mean = (shift + inner + 4.0 * 0.5 * shift * shift) / 6.0;
  for (const DirectedDistance& directed : {d.forward, d.backward}) {
    expect_bracket(directed.lower, directed.upper, shift, kTight, d.diagonal);
    EXPECT_NEAR(directed.mean, mean, directed.mean_error);
    EXPECT_LE(directed.mean_error, 0.02);
  }
}

TEST(SurfaceDistance, ADentIsFoundFromBothSides) {
  for (const double depth : {1e-6, 0.25, 1.0}) {
    const SurfaceDistance d =
        measure_surface_distance(make_square(0.0, false), make_square(-depth, true), kTight);
    // The flat square's corners are on the other one: the greatest distance is from the inside of a side.
    const double to_slope = depth * 0.5 / std::sqrt(0.25 + depth * depth);
    expect_bracket(d.forward.lower, d.forward.upper, to_slope, kTight, d.diagonal);
    expect_bracket(d.backward.lower, d.backward.upper, depth, kTight, d.diagonal);
  }
}

TEST(SurfaceDistance, AHoleShowsInOneDirectionOnly) {
  const SurfaceMesh whole = build_geodesic_sphere(4);
  SurfaceMesh open = whole;
  open.triangles.pop_back();
  const SurfaceDistance d = measure_surface_distance(open, whole);
  EXPECT_LE(d.forward.upper, kRounding);
  EXPECT_GT(d.backward.lower, 0.05);  // half the radius of the missing triangle's inscribed circle at least
}

TEST(SurfaceDistance, TheSameCubeInOtherTrianglesIsAtDistanceZero) {
  SurfaceMesh fine = build_boundary(make_kuhn_block(7, 7, 7));
  const SurfaceMesh coarse = scaled(build_boundary(make_kuhn_block(1, 1, 1)), 7.0);
  const SurfaceDistance d = measure_surface_distance(fine, coarse);
  EXPECT_LE(d.upper(), 1e-7 * d.diagonal);
  EXPECT_LE(d.mean(), kRounding);
  fine.points[0].x -= 1e-3;  // a corner
  const SurfaceDistance broken = measure_surface_distance(fine, coarse);
  EXPECT_NEAR(broken.lower(), 1e-3, kRounding);
  EXPECT_NEAR(broken.upper(), 1e-3, 2e-5);
}

TEST(SurfaceDistance, ASurfaceIsAtDistanceZeroFromItself) {
  const SurfaceMesh bean = build_bean_surface(6);
  const SurfaceDistance d = measure_surface_distance(bean, bean);
  EXPECT_LE(d.upper(), d.diagonal * kRounding);
  EXPECT_LE(d.mean(), d.diagonal * kRounding);
}

TEST(SurfaceDistance, AgreesWithBruteForceOnRandomTriangles) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    SplitMix64 random(seed);
    const double size = seed % 3 == 0 ? 0.02 : (seed % 3 == 1 ? 0.3 : 2.0);
    const SurfaceMesh a = random_triangles(12, size, random);
    const SurfaceMesh b = random_triangles(15, size, random);
    const SurfaceDistanceOptions options{.relative_gap = 1e-3};
    const SurfaceDistance d = measure_surface_distance(a, b, options);
    const Sampled forward = brute_directed(a, b, 24);
    EXPECT_LE(forward.largest, d.forward.upper + kRounding);
    EXPECT_GE(forward.largest + forward.reach, d.forward.lower);
    EXPECT_LE(d.forward.upper, d.forward.lower * (1.0 + options.relative_gap));
    const Sampled backward = brute_directed(b, a, 24);
    EXPECT_LE(backward.largest, d.backward.upper + kRounding);
    EXPECT_GE(backward.largest + backward.reach, d.backward.lower);
  }
}

TEST(SurfaceDistance, ALimitOnTheWorkWidensTheBracketAndKeepsItRight) {
  const SurfaceMesh a = make_square(0.0, false);
  const SurfaceMesh b = make_square(-1.0, true);
  const SurfaceDistance d =
      measure_surface_distance(a, b, {.relative_gap = 0.0, .absolute_gap = 1e-18, .max_pieces = 1});
  const double exact = 0.5 / std::sqrt(1.25);
  EXPECT_LE(d.forward.lower, exact + kRounding);
  EXPECT_GE(d.forward.upper, exact - kRounding);
  EXPECT_GT(d.forward.upper, d.forward.lower);  // it was left as it was after the corners
}

TEST(SurfaceDistance, TinyAndHugeCoordinates) {
  for (const double scale : {1e-300, 1e-9, 1e9, 1e300}) {
    const SurfaceMesh cube = scaled(build_boundary(make_kuhn_block(2, 2, 2)), scale);
    const SurfaceDistance d = measure_surface_distance(moved(cube, {0.25 * scale, 0, 0}), cube);
    EXPECT_NEAR(d.lower() / scale, 0.25, 1e-12) << scale;
    EXPECT_NEAR(d.upper() / scale, 0.25, 0.0026) << scale;
  }
}

TEST(SurfaceDistance, EmptyAndBrokenSurfaces) {
  const SurfaceMesh cube = build_boundary(make_kuhn_block(1, 1, 1));
  EXPECT_EQ(measure_surface_distance({}, {}).upper(), 0.0);
  EXPECT_TRUE(std::isinf(measure_surface_distance({}, cube).lower()));
  EXPECT_TRUE(std::isinf(measure_surface_distance(cube, {}).lower()));
  SurfaceMesh broken = cube;
  broken.triangles.push_back({0, 1, 99});
  EXPECT_THROW(measure_surface_distance(broken, cube), ContractError);
  broken = cube;
  broken.points[0].x = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(measure_surface_distance(cube, broken), ContractError);
  EXPECT_THROW(measure_surface_distance(cube, cube, {.absolute_gap = 0.0}), ContractError);
  SurfaceMesh needle = cube;  // a triangle without area is its sides
  needle.triangles.push_back({0, 0, 1});
  EXPECT_LE(measure_surface_distance(needle, cube).upper(), 1e-7 * 2.0);
}

TEST(BuildBoundary, HasTheFacesOfOneTet) {
  EXPECT_EQ(build_boundary(make_two_tets()).triangles.size(), 6U);
  const TetMesh hollow = make_hollow_cube();
  EXPECT_EQ(build_boundary(hollow).triangles.size(), 12U * (9 + 1));
  double six_volumes = 0.0;  // by the divergence theorem: the faces look outwards
  for (const Triangle& t : build_boundary(hollow).triangles) {
    six_volumes += dot(cross(hollow.points[t[0]], hollow.points[t[1]]), hollow.points[t[2]]);
  }
  EXPECT_DOUBLE_EQ(six_volumes, 6.0 * 26.0);
}

}  // namespace
}  // namespace palpate::judge
