// Points found in a mesh, and fields there.
#include "core/dynamics/finite_elements/tet_locator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/mesh/shapes/shapes.h"

namespace palpate::dynamics {
namespace {

Vec3 quadratic_field(const Vec3& p) {
  return {1.0 + p.x * p.y - p.z, p.z * p.z + 2.0 * p.x, p.y * p.z - p.x * p.x};
}

Vec3 linear_field(const Vec3& p) {
  return {1.0 + p.x - 2.0 * p.z, p.y, 3.0 * p.x};
}

class Located : public testing::Test {
 protected:
  Vec3 draw_point() { return {random_.uniform(), random_.uniform(), random_.uniform()}; }

  /// Largest difference between a field of elements and `field`, over points that are drawn.
  double worst(const ElementSpace& space, const std::vector<Vec3>& values, Vec3 (*field)(const Vec3&)) {
    double most = 0.0;
    for (int draw = 0; draw < 500; ++draw) {
      const Vec3 point = draw_point();
      most = std::max(most, length(evaluate(space, values, locator_.find(point)) - field(point)));
    }
    return most;
  }

  TetMesh mesh_ = build_kuhn_cube(4, 0.35, 3);
  TetLocator locator_{mesh_};
  SplitMix64 random_{21};
};

TEST_F(Located, PointsLieWhereTheirCoordinatesSay) {
  for (int draw = 0; draw < 1000; ++draw) {
    const Vec3 point = draw_point();
    const TetPlace place = locator_.find(point);
    Vec3 there;
    for (std::size_t i = 0; i < 4; ++i) {
      ASSERT_GE(place.at[i], -1e-12);
      there = there + place.at[i] * mesh_.points[mesh_.tets[place.tet][i]];
    }
    ASSERT_LT(length(there - point), 1e-12);
  }
  for (const Vec3& corner : mesh_.points) {
    const TetPlace place = locator_.find(corner);
    EXPECT_NEAR(*std::max_element(place.at.begin(), place.at.end()), 1.0, 1e-12);
  }
}

TEST_F(Located, ElementsEvaluateTheirOwnPolynomialsExactly) {
  for (const int order : {1, 2}) {
    const ElementSpace space = build_element_space(mesh_, order);
    const auto field = order == 1 ? linear_field : quadratic_field;
    std::vector<Vec3> values;
    for (const Vec3& point : space.points) values.push_back(field(point));
    EXPECT_LT(worst(space, values, field), 1e-12) << order;
    std::swap(values.front(), values.back());
    EXPECT_GT(worst(space, values, field), 1e-3) << "values in the wrong place must be seen";
  }
}

TEST_F(Located, APointOutsideIsRefused) {
  EXPECT_THROW(locator_.find({1.001, 0.5, 0.5}), InputError);
  EXPECT_THROW(locator_.find({NAN, 0.5, 0.5}), InputError);
  EXPECT_NO_THROW(locator_.find({1.0 + 1e-13, 0.5, 0.5}));
}

/// Cells as small as the tets would be more than memory has.
TEST(TetLocator, FewSmallTetsInALargeBoxAreFound) {
  TetMesh mesh = build_kuhn_cube(1, 0.0, 0);
  const std::size_t each = mesh.points.size();
  const std::size_t tets = mesh.tets.size();
  for (std::size_t v = 0; v < each; ++v) mesh.points.push_back(mesh.points[v] + Vec3{1e7, 1e7, 1e7});
  for (std::size_t t = 0; t < tets; ++t) {
    Tet far = mesh.tets[t];
    for (Index& v : far) v += static_cast<Index>(each);
    mesh.tets.push_back(far);
  }
  const TetLocator locator(mesh);
  EXPECT_LT(locator.find({0.4, 0.3, 0.2}).tet, tets);
  EXPECT_GE(locator.find({1e7 + 0.4, 1e7 + 0.3, 1e7 + 0.2}).tet, tets);
}

}  // namespace
}  // namespace palpate::dynamics
