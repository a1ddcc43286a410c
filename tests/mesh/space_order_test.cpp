#include "core/mesh/space_order.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "core/base/random.h"
#include "core/mesh/shapes/shapes.h"

namespace palpate {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(SpaceOrder, CornersOfACubeFollowTheCurve) {
  // x changes fastest, then y, then z: the bits of a key, from the lowest.
  const std::vector<Vec3> corners{{1, 1, 1}, {0, 1, 1}, {1, 0, 1}, {0, 0, 1},
                                  {1, 1, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 0}};
  EXPECT_THAT(order_in_space(corners), ElementsAre(7, 6, 5, 4, 3, 2, 1, 0));
}

TEST(SpaceOrder, EqualPointsGoByNumber) {
  const std::vector<Vec3> points{{1, 0, 0}, {0, 0, 0}, {1, 0, 0}, {0, 0, 0}};
  EXPECT_THAT(order_in_space(points), ElementsAre(1, 3, 0, 2));
  EXPECT_THAT(order_in_space(std::vector<Vec3>(3, Vec3{2, 3, 4})), ElementsAre(0, 1, 2));
  EXPECT_THAT(order_in_space({}), IsEmpty());
}

TEST(SpaceOrder, IsAPermutationThatKeepsNeighboursTogetherOnAnyNumberOfThreads) {
  SplitMix64 random(8);
  std::vector<Vec3> points(20000);
  for (Vec3& p : points) p = {random.uniform(), random.uniform(), random.uniform()};
  const std::vector<Index> order = order_in_space(points);
  EXPECT_EQ(order_in_space(points, 3), order);
  std::vector<Index> sorted(order);
  std::sort(sorted.begin(), sorted.end());
  for (Index i = 0; i < sorted.size(); ++i) ASSERT_EQ(sorted[i], i);
  const auto path = [&](const auto& number) {
    double sum = 0.0;
    for (std::size_t i = 1; i < points.size(); ++i) sum += length(points[number(i)] - points[number(i - 1)]);
    return sum;
  };
  const double along = path([&](std::size_t i) { return std::size_t{order[i]}; });
  const double at_random = path([](std::size_t i) { return i; });
  // A step of about n^(-1/3) = 0.037 against a mean distance of 0.66 of two random points.
  EXPECT_LT(along, 0.15 * at_random);
}

TEST(SpaceOrder, ASortedMeshIsTheSameMeshWithTetsByTheirSmallestVertex) {
  const TetMesh given = build_kuhn_cube(5, 0.2, 3);
  TetMesh sorted = given;
  const MeshOrigin origin = sort_in_space(sorted);
  EXPECT_EQ(origin.vertices, order_in_space(given.points));
  ASSERT_EQ(origin.tets.size(), given.tets.size());
  Index before = 0;
  for (std::size_t t = 0; t < sorted.tets.size(); ++t) {
    Tet as_given = sorted.tets[t];
    for (Index& v : as_given) v = origin.vertices[v];
    ASSERT_EQ(as_given, given.tets[origin.tets[t]]) << t;
    const Index smallest = *std::min_element(sorted.tets[t].begin(), sorted.tets[t].end());
    EXPECT_GE(smallest, before);
    before = smallest;
  }
  for (std::size_t v = 0; v < sorted.points.size(); ++v)
    ASSERT_EQ(sorted.points[v], given.points[origin.vertices[v]]);
  TetMesh on_threads = given;
  EXPECT_EQ(sort_in_space(on_threads, 3).tets, origin.tets);
  EXPECT_EQ(on_threads, sorted);
}

}  // namespace
}  // namespace palpate
