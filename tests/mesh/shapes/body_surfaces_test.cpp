// Built bodies: closed surfaces of the topology and size that they claim, free of self-intersections.
#include "core/mesh/shapes/body_surfaces.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <map>
#include <string>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "tests/support/cgal_oracle.h"

namespace palpate {
namespace {

using Build = SurfaceMesh (*)(int);

struct BuiltCase {
  const char* name;
  Build build;
  std::int64_t euler;  // V - E + F of the skin
  std::size_t pieces;
};

const std::array<BuiltCase, 4> kCases{{{"spleen", build_spleen_surface, 2, 1},
                                       {"stomach", build_stomach_surface, 4, 2},
                                       {"lobes", build_lobes_surface, 2, 1},
                                       {"ring", build_ring_surface, 0, 1}}};

/// Each directed edge once, and its opposite too: closed, manifold along edges, turned one way.
bool is_closed(const SurfaceMesh& skin) {
  std::map<std::array<Index, 2>, int> sides;
  for (const Triangle& t : skin.triangles) {
    for (std::size_t k = 0; k < 3; ++k) ++sides[{t[k], t[(k + 1) % 3]}];
  }
  for (const auto& [side, count] : sides) {
    const auto opposite = sides.find({side[1], side[0]});
    if (count != 1 || opposite == sides.end()) return false;
  }
  return true;
}

TEST(BodySurfaces, AreClosedAndOfTheirTopology) {
  for (const BuiltCase& c : kCases) {
    for (const int frequency : {3, 8}) {
      const SurfaceMesh skin = c.build(frequency);
      EXPECT_TRUE(is_closed(skin)) << c.name;
      const auto euler = static_cast<std::int64_t>(skin.points.size()) -
                         static_cast<std::int64_t>(skin.triangles.size() / 2);
      EXPECT_EQ(euler, c.euler) << c.name;
      EXPECT_GT(enclosed_volume(skin), 0.0) << c.name;
      EXPECT_EQ(skin, c.build(frequency)) << c.name;
    }
  }
}

TEST(BodySurfaces, DoNotIntersectThemselves) {
  for (const BuiltCase& c : kCases) EXPECT_FALSE(test::is_self_intersecting(c.build(20))) << c.name;
}

/// The ring without its saddle, which is a shear and keeps volumes: 2 pi^2 R r^2 for a tube r(1 + e cos u)
/// has the first moment of its section besides: V = integral over u of (pi t^2) R du, t = r (1 + e cos u), so
/// V = 2 pi^2 R r^2 (1 + e^2 / 2). Inscribed polygons fall short by O(1 / n^2).
TEST(BodySurfaces, TheRingHasItsVolume) {
  const double exact = 2.0 * M_PI * M_PI * 40.0 * 14.0 * 14.0 * (1.0 + 0.5 * 0.28 * 0.28);
  const double coarse = enclosed_volume(build_ring_surface(8)) - exact;
  const double fine = enclosed_volume(build_ring_surface(16)) - exact;
  EXPECT_LT(coarse, 0.0);
  EXPECT_NEAR(coarse / fine, 4.0, 0.4);  // order 2; the next term is of order 4
  EXPECT_NEAR(fine, 0.0, 0.02 * exact);
}

TEST(BodySurfaces, RefuseAFrequencyThatIsNone) {
  for (const BuiltCase& c : kCases) {
    EXPECT_THROW(c.build(0), InputError) << c.name;
    EXPECT_THROW(c.build(1001), InputError) << c.name;
  }
}

}  // namespace
}  // namespace palpate
