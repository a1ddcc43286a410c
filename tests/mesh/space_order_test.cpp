#include "core/mesh/space_order.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "core/base/random.h"

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

}  // namespace
}  // namespace palpate
