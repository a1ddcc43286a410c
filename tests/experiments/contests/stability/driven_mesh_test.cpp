// Meshes driven to extremes, as the contest stability makes them of its settings.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/judge/mesh/tet_shape.h"
#include "core/mesh/geometry.h"
#include "core/mesh/shapes/shapes.h"
#include "experiments/contests/stability/driven_mesh.h"

namespace palpate::experiments {
namespace {

using testing::HasSubstr;

TetMesh make_bar() {
  TetMesh mesh = build_bar(2);
  for (Vec3& p : mesh.points) p = {p.y, p.x, p.z};  // its length along y, in a mirror
  for (Tet& t : mesh.tets) std::swap(t[0], t[1]);
  return mesh;
}

Vec3 size_of(const TetMesh& mesh) {
  const BoundingBox box = bounding_box(mesh.points);
  return box.high - box.low;
}

TEST(ExtremeMesh, IsScaledWithItsLengthAlongX) {
  const DrivenMesh driven = drive_mesh(make_bar(), {});
  EXPECT_NEAR(size_of(driven.mesh).x, 0.1, 1e-15);
  EXPECT_NEAR(total_volume(driven.mesh), 0.1 * 0.025 * 0.025, 1e-12);
  EXPECT_EQ(driven.flattened, 0U);
  EXPECT_NEAR(driven.min_dihedral_deg, 45.0, 1e-9);
}

TEST(ExtremeMesh, SliversHaveTheAngleThatWasWantedAndNoTetIsTurned) {
  for (const double wanted : {1.0, 1e-3}) {
    ExtremeMesh options;
    options.sliver_deg = wanted;
    const DrivenMesh driven = drive_mesh(make_bar(), options);
    EXPECT_GE(driven.flattened, 3U);
    EXPECT_NEAR(driven.min_dihedral_deg / wanted, 1.0, 0.5);
    for (const Tet& t : driven.mesh.tets) {
      const auto& p = driven.mesh.points;
      EXPECT_TRUE(judge::measure_tet(p[t[0]], p[t[1]], p[t[2]], p[t[3]]).is_positive);
    }
    const DrivenMesh again = drive_mesh(make_bar(), options);
    EXPECT_EQ(again.mesh, driven.mesh);
  }
}

TEST(ExtremeMesh, AGradedMeshHasElementsOfAllSizesAndKeepsTheirShapes) {
  ExtremeMesh options;
  options.size_ratio = 1e4;
  const DrivenMesh driven = drive_mesh(build_bar(4), options);
  double least = 1.0;
  double most = 0.0;
  for (const Tet& t : driven.mesh.tets) {
    const auto& p = driven.mesh.points;
    const double volume = signed_volume(p[t[0]], p[t[1]], p[t[2]], p[t[3]]);
    ASSERT_GT(volume, 0.0);
    least = std::min(least, volume);
    most = std::max(most, volume);
  }
  EXPECT_GT(std::cbrt(most / least), 1e3);  // from the middle of the first layer to that of the last
  EXPECT_GT(driven.min_dihedral_deg, 3.0);
  const Vec3 size = size_of(driven.mesh);
  EXPECT_NEAR(std::max({size.x, size.y, size.z}), 0.1, 1e-12);
}

TEST(ExtremeMesh, CoordinatesAreScaledThenShifted) {
  ExtremeMesh options;
  options.coordinate_scale = 1e-6;
  options.coordinate_shift_m = 3.0;
  const DrivenMesh driven = drive_mesh(make_bar(), options);
  EXPECT_EQ(bounding_box(driven.mesh.points).low.x, 3.0);
  EXPECT_NEAR(size_of(driven.mesh).x, 1e-7, 1e-15);
}

TEST(ExtremeMesh, RefusesWhatIsNoNumber) {
  const auto error_with = [](auto&& change) -> std::string {
    ExtremeMesh options;
    change(options);
    try {
      drive_mesh(build_bar(1), options);
    } catch (const InputError& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_THAT(error_with([](ExtremeMesh& m) { m.size_m = std::nan(""); }), HasSubstr("size_m: expected"));
  EXPECT_THAT(error_with([](ExtremeMesh& m) { m.size_ratio = 0.5; }), HasSubstr("size_ratio: expected"));
  EXPECT_THAT(error_with([](ExtremeMesh& m) { m.coordinate_scale = 0.0; }), HasSubstr("coordinate_scale"));
  EXPECT_THAT(error_with([](ExtremeMesh& m) { m.coordinate_shift_m = INFINITY; }),
              HasSubstr("coordinate_shift_m"));
}

}  // namespace
}  // namespace palpate::experiments
