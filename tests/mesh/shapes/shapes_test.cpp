#include "core/mesh/shapes/shapes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <string>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/orientation.h"
#include "core/mesh/topology.h"
#include "tests/support/cgal_oracle.h"

namespace palpate {
namespace {

using ::testing::HasSubstr;

void expect_all_positive(const TetMesh& mesh) {
  std::size_t bad = 0;
  for (const Tet& t : mesh.tets) {
    const auto& p = mesh.points;
    bad += orientation(p[t[0]], p[t[1]], p[t[2]], p[t[3]]) > 0 ? 0 : 1;
  }
  EXPECT_EQ(bad, 0U);
}

/// A ball: Euler 1 and a boundary that is one sphere (build_boundary throws for broken faces).
void expect_ball(const TetMesh& mesh) {
  EXPECT_EQ(mesh.points.size() + build_faces(mesh).size() - build_edges(mesh).size() - mesh.tets.size(), 1U);
  const std::vector<Triangle> boundary = build_boundary(mesh);
  const std::vector<std::uint8_t> flags = build_boundary_vertex_flags(mesh);
  const auto vertices = static_cast<std::size_t>(std::count(flags.begin(), flags.end(), 1));
  EXPECT_EQ(2 * vertices, boundary.size() + 4);  // V - 3F/2 + F = 2
  TetMesh copy = mesh;
  EXPECT_EQ(remove_isolated_vertices(copy), 0U);
}

/// Points that lie in one place.
std::size_t duplicate_points(const std::vector<Vec3>& points) {
  std::set<std::array<double, 3>> seen;
  for (const Vec3& p : points) seen.insert({p.x, p.y, p.z});
  return points.size() - seen.size();
}

bool is_on_box(const Vec3& p, double length_x) {
  return p.x == 0.0 || p.x == length_x || p.y == 0.0 || p.y == 1.0 || p.z == 0.0 || p.z == 1.0;
}

TEST(KuhnCube, HasItsClosedForms) {
  for (const std::size_t n : {1U, 2U, 3U, 10U}) {
    const TetMesh mesh = build_kuhn_cube(static_cast<int>(n), 0.0, 0);
    EXPECT_EQ(mesh.tets.size(), 6 * n * n * n);
    EXPECT_EQ(mesh.points.size(), (n + 1) * (n + 1) * (n + 1));
    EXPECT_EQ(build_boundary(mesh).size(), 12 * n * n);
    // Axes, face diagonals and space diagonals.
    EXPECT_EQ(build_edges(mesh).size(), 3 * n * (n + 1) * (n + 1) + 3 * n * n * (n + 1) + n * n * n);
    EXPECT_EQ(duplicate_points(mesh.points), 0U);
    expect_all_positive(mesh);
    expect_ball(mesh);
    const double expected = 1.0 / (6.0 * static_cast<double>(n * n * n));
    for (const Tet& t : mesh.tets) {
      const auto& p = mesh.points;
      EXPECT_NEAR(signed_volume(p[t[0]], p[t[1]], p[t[2]], p[t[3]]), expected, 1e-15);
    }
  }
}

TEST(KuhnCube, JitterKeepsTetsPositiveAndTheBoundaryInPlace) {
  for (const double jitter : {0.05, 0.3, 0.5}) {
    for (const std::uint64_t seed : {1U, 2U, 77U}) {
      const int n = 9;
      const TetMesh plain = build_kuhn_cube(n, 0.0, seed);
      const TetMesh mesh = build_kuhn_cube(n, jitter, seed);
      EXPECT_EQ(mesh.tets, plain.tets);
      expect_all_positive(mesh);
      expect_ball(mesh);
      std::size_t moved = 0;
      std::size_t inner = 0;
      for (std::size_t v = 0; v < mesh.points.size(); ++v) {
        const Vec3 move = mesh.points[v] - plain.points[v];
        if (is_on_box(plain.points[v], 1.0)) {
          EXPECT_EQ(mesh.points[v], plain.points[v]);
          continue;
        }
        ++inner;
        moved += length_sq(move) > 0.0 ? 1 : 0;
        const double most = std::max({std::fabs(move.x), std::fabs(move.y), std::fabs(move.z)});
        EXPECT_LE(most, jitter / n * (1.0 + 1e-12));
      }
      EXPECT_EQ(inner, 512U);
      EXPECT_EQ(moved, inner);
    }
  }
}

TEST(KuhnCube, TheSeedDecides) {
  EXPECT_EQ(build_kuhn_cube(6, 0.3, 1), build_kuhn_cube(6, 0.3, 1));
  EXPECT_NE(build_kuhn_cube(6, 0.3, 1), build_kuhn_cube(6, 0.3, 2));
  EXPECT_EQ(build_kuhn_cube(6, 0.0, 1), build_kuhn_cube(6, 0.0, 2));
}

TEST(Bar, HasItsClosedForms) {
  for (const std::size_t n : {1U, 2U, 4U}) {
    const TetMesh mesh = build_bar(static_cast<int>(n));
    EXPECT_EQ(mesh.tets.size(), 24 * n * n * n);
    EXPECT_EQ(mesh.points.size(), (4 * n + 1) * (n + 1) * (n + 1));
    EXPECT_EQ(build_boundary(mesh).size(), 2 * (2 * n * n + 16 * n * n));
    EXPECT_EQ(bounding_box(mesh.points).high, (Vec3{4, 1, 1}));
    EXPECT_EQ(bounding_box(mesh.points).low, (Vec3{0, 0, 0}));
    expect_all_positive(mesh);
    expect_ball(mesh);
  }
}

TEST(BccBar, HasItsClosedForms) {
  for (const std::size_t n : {1U, 2U, 3U, 5U}) {
    const TetMesh mesh = build_bcc_bar(static_cast<int>(n));
    EXPECT_EQ(mesh.tets.size(), 48 * n * n * n + 36 * n * n);
    EXPECT_EQ(mesh.points.size(), (4 * n + 1) * (n + 1) * (n + 1) + 4 * n * n * n + 18 * n * n);
    EXPECT_EQ(build_boundary(mesh).size(), 72 * n * n);
    EXPECT_EQ(bounding_box(mesh.points).high, (Vec3{4, 1, 1}));
    EXPECT_EQ(bounding_box(mesh.points).low, (Vec3{0, 0, 0}));
    EXPECT_EQ(duplicate_points(mesh.points), 0U);
    expect_all_positive(mesh);
    expect_ball(mesh);
    for (const Triangle& face : build_boundary(mesh)) {  // cut flat
      for (const Index v : face) EXPECT_TRUE(is_on_box(mesh.points[v], 4.0));
    }
  }
}

TEST(BccBar, EdgesAndTetsInsideAreTheLattices) {
  const int n = 4;
  const TetMesh mesh = build_bcc_bar(n);
  const double axis = 1.0 / n;
  const double half_diagonal = std::sqrt(3.0) / 2.0 / n;
  std::map<Index, int> degree;
  for (const Edge& e : build_edges(mesh)) {
    const Vec3& a = mesh.points[e[0]];
    const Vec3& b = mesh.points[e[1]];
    ++degree[e[0]];
    ++degree[e[1]];
    const double size = length(a - b);
    const bool is_lattice = std::fabs(size - axis) < 1e-15 || std::fabs(size - half_diagonal) < 1e-15;
    // Other edges end in the middle of an outer square: half an axis inward, half a face diagonal across.
    const bool is_outer =
        std::fabs(size - 0.5 * axis) < 1e-15 || std::fabs(size - std::sqrt(0.5) * axis) < 1e-15;
    EXPECT_TRUE(is_lattice || (is_outer && (is_on_box(a, 4.0) || is_on_box(b, 4.0))));
  }
  for (const auto& [v, edges] : degree) {
    const Vec3& p = mesh.points[v];
    const bool deep =
        p.x > axis && p.x < 4.0 - axis && p.y > axis && p.y < 1.0 - axis && p.z > axis && p.z < 1.0 - axis;
    EXPECT_TRUE(!deep || edges == 14);  // 8 half diagonals and 6 axes
  }
  std::size_t lattice_tets = 0;
  std::size_t cut_tets = 0;
  const double volume = 1.0 / (12.0 * n * n * n);
  for (const Tet& t : mesh.tets) {
    const auto& p = mesh.points;
    const double size = signed_volume(p[t[0]], p[t[1]], p[t[2]], p[t[3]]);
    lattice_tets += std::fabs(size - volume) < 1e-15 ? 1 : 0;
    cut_tets += std::fabs(size - 0.5 * volume) < 1e-15 ? 1 : 0;
  }
  EXPECT_EQ(cut_tets, 4U * 18 * n * n);
  EXPECT_EQ(lattice_tets + cut_tets, mesh.tets.size());
}

/// Each edge once in each direction, Euler 2, all vertices used.
void expect_closed_sphere(const SurfaceMesh& surface) {
  std::set<Edge> directed;
  std::set<Index> used;
  for (const Triangle& t : surface.triangles) {
    for (std::size_t s = 0; s < 3; ++s) {
      EXPECT_TRUE(directed.insert({t[s], t[(s + 1) % 3]}).second);
      used.insert(t[s]);
    }
  }
  for (const Edge& e : directed) EXPECT_EQ(directed.count({e[1], e[0]}), 1U);
  EXPECT_EQ(used.size(), surface.points.size());
  EXPECT_EQ(surface.points.size() + surface.triangles.size() - directed.size() / 2, 2U);
}

TEST(GeodesicSphere, HasItsClosedForms) {
  double former_volume = 0.0;
  for (const std::size_t f : {1U, 2U, 3U, 6U, 17U}) {
    const SurfaceMesh sphere = build_geodesic_sphere(static_cast<int>(f));
    EXPECT_EQ(sphere.points.size(), 10 * f * f + 2);
    EXPECT_EQ(sphere.triangles.size(), 20 * f * f);
    EXPECT_EQ(duplicate_points(sphere.points), 0U);
    expect_closed_sphere(sphere);
    for (const Vec3& p : sphere.points) EXPECT_NEAR(length(p), 1.0, 4e-16);
    for (const Triangle& t : sphere.triangles) {
      const auto& p = sphere.points;
      EXPECT_EQ(orientation({0, 0, 0}, p[t[0]], p[t[1]], p[t[2]]), 1);
    }
    EXPECT_GT(enclosed_volume(sphere), former_volume);
    former_volume = enclosed_volume(sphere);
  }
  EXPECT_LT(former_volume, 4.0 / 3.0 * std::acos(-1.0));
}

TEST(GeodesicSphere, VolumeConvergesWithTheSquareOfTheEdgeLength) {
  const double ball = 4.0 / 3.0 * std::acos(-1.0);
  const double coarse = ball - enclosed_volume(build_geodesic_sphere(10));
  const double fine = ball - enclosed_volume(build_geodesic_sphere(20));
  // The next term is of order h^4: below one percent of the ratio here.
  EXPECT_NEAR(coarse / fine, 4.0, 0.04);
}

TEST(GeodesicSphere, VerticesHaveFiveOrSixNeighbours) {
  const SurfaceMesh sphere = build_geodesic_sphere(7);
  std::vector<int> triangles(sphere.points.size(), 0);
  for (const Triangle& t : sphere.triangles) {
    for (const Index v : t) ++triangles[v];
  }
  for (std::size_t v = 0; v < triangles.size(); ++v) EXPECT_EQ(triangles[v], v < 12 ? 5 : 6);
}

TEST(Bean, IsClosedAndFreeOfSelfIntersections) {
  for (const int f : {1, 2, 3, 4, 5, 6, 8, 11, 16, 25, 40}) {
    SCOPED_TRACE(f);
    const SurfaceMesh bean = build_bean_surface(f);
    const auto n = static_cast<std::size_t>(f);
    EXPECT_EQ(bean.points.size(), 10 * n * n + 2);
    expect_closed_sphere(bean);
    EXPECT_GT(enclosed_volume(bean), 0.0);
    EXPECT_FALSE(test::is_self_intersecting(bean));
  }
}

TEST(Bean, TheOracleFindsASelfIntersection) {
  SurfaceMesh bean = build_bean_surface(6);
  bean.points[0] = bean.points[0] + Vec3{20, 20, 20};
  EXPECT_TRUE(test::is_self_intersecting(bean));
}

TEST(Bean, HasTheSizeOfAKidneyAndAHilum) {
  const SurfaceMesh bean = build_bean_surface(40);
  const BoundingBox box = bounding_box(bean.points);
  const Vec3 size = box.high - box.low;
  // The figures that the header states, to the digits stated.
  EXPECT_NEAR(size.x, 11.0, 0.05);
  EXPECT_NEAR(size.y, 5.5, 0.05);
  EXPECT_NEAR(size.z, 4.5, 0.05);
  EXPECT_NEAR(enclosed_volume(bean), 147.0, 0.5);
  // Concave: on the inner side (+y), the middle of the length lies deeper than both ends.
  double middle = -10.0;
  double left = -10.0;
  double right = -10.0;
  for (const Vec3& p : bean.points) {
    if (std::fabs(p.x) < 0.3) middle = std::max(middle, p.y);
    if (p.x < -2.0) left = std::max(left, p.y);
    if (p.x > 2.0) right = std::max(right, p.y);
  }
  EXPECT_LT(middle, left - 0.5);
  EXPECT_LT(middle, right - 0.5);
}

TEST(Bean, EdgesAreReasonablyEven) {
  for (const int f : {2, 6, 12, 40}) {
    const SurfaceMesh bean = build_bean_surface(f);
    double shortest = 1e9;
    double longest = 0.0;
    for (const Triangle& t : bean.triangles) {
      for (std::size_t s = 0; s < 3; ++s) {
        const double size = length(bean.points[t[s]] - bean.points[t[(s + 1) % 3]]);
        shortest = std::min(shortest, size);
        longest = std::max(longest, size);
      }
    }
    EXPECT_LT(longest, 4.0 * shortest) << f;
  }
}

template <typename Mesh>
bool is_same_bytes(const Mesh& a, const Mesh& b) {
  return a == b && std::memcmp(a.points.data(), b.points.data(), a.points.size() * sizeof(Vec3)) == 0;
}

TEST(Shapes, AreTheSameEveryTime) {
  EXPECT_TRUE(is_same_bytes(build_kuhn_cube(8, 0.4, 3), build_kuhn_cube(8, 0.4, 3)));
  EXPECT_TRUE(is_same_bytes(build_bar(3), build_bar(3)));
  EXPECT_TRUE(is_same_bytes(build_bcc_bar(3), build_bcc_bar(3)));
  EXPECT_TRUE(is_same_bytes(build_geodesic_sphere(9), build_geodesic_sphere(9)));
  EXPECT_TRUE(is_same_bytes(build_bean_surface(9), build_bean_surface(9)));
}

/// FNV-1a over the bits of the coordinates: the same on every machine with IEEE 754 doubles.
std::uint64_t hash_of(const std::vector<Vec3>& points) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const Vec3& p : points) {
    for (const double c : {p.x, p.y, p.z}) {
      std::uint64_t bits = 0;
      std::memcpy(&bits, &c, sizeof bits);
      for (int shift = 0; shift < 64; shift += 8) hash = (hash ^ (bits >> shift & 0xffU)) * 0x100000001b3ULL;
    }
  }
  return hash;
}

TEST(Shapes, AreTheSameInEveryBuild) {
  EXPECT_EQ(hash_of(build_kuhn_cube(8, 0.4, 3).points), 10074633782521906094ULL);
  EXPECT_EQ(hash_of(build_bean_surface(9).points), 15667390611376603805ULL);
}

TEST(Shapes, RefuseBadSizes) {
  const auto message = [](const std::function<void()>& action) {
    try {
      action();
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_EQ(message([] { build_kuhn_cube(0, 0.0, 0); }),
            "cells a side of the cube: expected a whole number from 1 to 560, found 0");
  EXPECT_THAT(message([] { build_kuhn_cube(561, 0.0, 0); }), HasSubstr("from 1 to 560, found 561"));
  EXPECT_THAT(message([] { build_kuhn_cube(-3, 0.0, 0); }), HasSubstr("found -3"));
  EXPECT_EQ(message([] { build_kuhn_cube(2, -0.1, 0); }),
            "jitter of the cube: expected a number from 0 to 0.5, found -0.100000");
  EXPECT_THAT(message([] { build_kuhn_cube(2, 0.51, 0); }), HasSubstr("found 0.51"));
  EXPECT_THAT(message([] { build_kuhn_cube(2, std::numeric_limits<double>::quiet_NaN(), 0); }),
              HasSubstr("from 0 to 0.5, found nan"));
  EXPECT_THAT(message([] { build_bar(0); }), HasSubstr("from 1 to 350, found 0"));
  EXPECT_THAT(message([] { build_bcc_bar(271); }), HasSubstr("from 1 to 270, found 271"));
  EXPECT_THAT(message([] { build_geodesic_sphere(0); }), HasSubstr("from 1 to 1000, found 0"));
  EXPECT_THAT(message([] { build_bean_surface(1001); }), HasSubstr("from 1 to 1000, found 1001"));
}

}  // namespace
}  // namespace palpate
