// The user's surfaces that are mended: what is changed, and what is refused all the same.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>
#include <string>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/io/off.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "experiments/meshes/mesh_source.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/surfaces.h"

namespace palpate::experiments {
namespace {

using testing::HasSubstr;

class SurfaceRepairs : public testing::Test {
 protected:
  std::filesystem::path file_of(const SurfaceMesh& surface) const {
    write_off(folder_ / "surface.off", surface);
    return folder_ / "surface.off";
  }

  /// What is said of a surface without a repair.
  std::string refusal(const SurfaceMesh& surface, bool repair = false) const {
    try {
      mesh_surface({file_of(surface), {}, repair});
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }

  /// The filling of the mended surface; its first note is on the repair.
  MadeMesh mended(const SurfaceMesh& surface) const { return mesh_surface({file_of(surface), {}, true}); }

  test::ScratchFolder folder_;
};

/// The ball without the triangles around vertex `v`, which stays unused.
SurfaceMesh pierced(SurfaceMesh surface, Index v) {
  std::erase_if(surface.triangles,
                [&](const Triangle& t) { return std::find(t.begin(), t.end(), v) != t.end(); });
  return surface;
}

TEST_F(SurfaceRepairs, AGoodOneStaysAsItIs) {
  const SurfaceMesh ball = build_geodesic_sphere(3);
  const MadeMesh made = mended(ball);
  EXPECT_EQ(made.notes.at(0), "repair: nothing had to be changed");
  EXPECT_EQ(build_boundary(made.mesh).size(), ball.triangles.size());
  EXPECT_NEAR(total_volume(made.mesh), enclosed_volume(ball), 1e-12);
}

TEST_F(SurfaceRepairs, EveryRefusalNamesTheWay) {
  const SurfaceMesh ball = build_geodesic_sphere(2);
  for (const SurfaceMesh& bad :
       {pierced(ball, 5), test::turned(ball), test::united(ball, test::moved(ball, 1.0, {1, 0.1, 0.2}))}) {
    EXPECT_THAT(refusal(bad), HasSubstr("; --repair may mend it (in a scene: repair: true)"));
  }
}

TEST_F(SurfaceRepairs, HolesAreFilled) {
  const SurfaceMesh ball = build_geodesic_sphere(4);
  const SurfaceMesh open = pierced(pierced(ball, 5), 40);
  EXPECT_THAT(refusal(open), HasSubstr("(open)"));
  const MadeMesh made = mended(open);
  EXPECT_THAT(made.notes.at(0), HasSubstr("repaired: 2 holes filled with "));
  EXPECT_THAT(made.notes.at(0), HasSubstr("volume none before (it was not closed), "));
  // Flat lids take less away than the caps of their rims have: each is below pi h^2 (1 - h / 3), h the height
  // of the vertex above the lid, at most that of an edge.
  EXPECT_LT(total_volume(made.mesh), enclosed_volume(ball));
  EXPECT_GT(total_volume(made.mesh), 0.97 * enclosed_volume(ball));
}

TEST_F(SurfaceRepairs, TurnedTrianglesAreTurnedBack) {
  const SurfaceMesh ball = build_geodesic_sphere(3);
  SurfaceMesh some = ball;
  for (const std::size_t k : {3U, 17U, 60U}) std::swap(some.triangles[k][0], some.triangles[k][1]);
  MadeMesh made = mended(some);
  EXPECT_THAT(made.notes.at(0), HasSubstr("repaired: 3 triangles turned around; "));
  EXPECT_NEAR(total_volume(made.mesh), enclosed_volume(ball), 1e-12);
  made = mended(test::turned(ball));
  EXPECT_THAT(made.notes.at(0),
              HasSubstr(std::to_string(ball.triangles.size()) + " triangles turned around"));
  EXPECT_THAT(made.notes.at(0), HasSubstr("volume -"));
  EXPECT_NEAR(total_volume(made.mesh), enclosed_volume(ball), 1e-12);
}

TEST_F(SurfaceRepairs, CracksAreClosedAndDoublesTakenOut) {
  const SurfaceMesh ball = build_geodesic_sphere(3);
  SurfaceMesh soup;  // each triangle with corners of its own, a little off; the first one twice
  for (const Triangle& t : ball.triangles) {
    const auto first = static_cast<Index>(soup.points.size());
    for (const Index v : t)
      soup.points.push_back(ball.points[v] + Vec3{1e-8 * static_cast<double>(first % 7), 0, 0});
    soup.triangles.push_back({first, first + 1, first + 2});
  }
  soup.triangles.push_back(soup.triangles.front());
  std::set<std::array<double, 3>> places;  // a file's points at one place are one before anything is mended
  for (const Vec3& p : soup.points) places.insert({p.x, p.y, p.z});
  const MadeMesh made = mended(soup);
  EXPECT_THAT(made.notes.at(0),
              HasSubstr(std::to_string(places.size() - ball.points.size()) + " points merged"));
  EXPECT_THAT(made.notes.at(0), HasSubstr("1 triangle without area or doubled taken out"));
  EXPECT_NEAR(total_volume(made.mesh), enclosed_volume(ball), 1e-6);
}

TEST_F(SurfaceRepairs, ADentThroughTheOtherSideIsTakenOut) {
  SurfaceMesh ball = build_geodesic_sphere(5);
  const double whole = enclosed_volume(ball);
  const auto top =
      static_cast<std::size_t>(std::max_element(ball.points.begin(), ball.points.end(),
                                                [](const Vec3& a, const Vec3& b) { return a.z < b.z; }) -
                               ball.points.begin());
  ball.points[top] = {0.45, 0, 0.7};  // below its neighbours' triangles and through them
  const Vec3 sideways = ball.points[top];
  ball.points[top] = sideways + Vec3{0.6, 0, 0.1};  // out through the side
  EXPECT_THAT(refusal(ball), HasSubstr("pairs of triangles that intersect"));
  const MadeMesh made = mended(ball);
  EXPECT_THAT(made.notes.at(0), HasSubstr("that intersected"));
  EXPECT_NEAR(total_volume(made.mesh), whole, 0.1 * whole);
}

TEST_F(SurfaceRepairs, LooseScrapsAreTakenOut) {
  const SurfaceMesh ball = build_geodesic_sphere(3);
  const SurfaceMesh scrap{{{3, 0, 0}, {3.1, 0, 0}, {3, 0.1, 0}}, {{0, 1, 2}}};
  const MadeMesh made = mended(test::united(ball, scrap));
  EXPECT_THAT(made.notes.at(0), HasSubstr("repaired: 1 small open piece taken out; "));
  EXPECT_NEAR(total_volume(made.mesh), enclosed_volume(ball), 1e-12);
}

TEST_F(SurfaceRepairs, WhatCannotBeMendedIsRefusedAsBefore) {
  const SurfaceMesh flat{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}};
  const std::string message = refusal(flat, true);
  EXPECT_THAT(message, HasSubstr("expected "));
  EXPECT_THAT(message, HasSubstr("which did not mend it"));
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
}

}  // namespace
}  // namespace palpate::experiments
