#include "core/dynamics/spring_engine/plain_layout.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <vector>

#include "core/mesh/shapes/shapes.h"
#include "core/mesh/space_order.h"
#include "tests/support/dynamics_cases.h"

namespace palpate::dynamics {
namespace {

using namespace testing_support;

TEST(PlainLayout, TheCurveVisitsEachVertexOnceAndNeighboursSoon) {
  const TetMesh mesh = build_kuhn_cube(12, 0.2, 5);
  std::vector<Index> order = order_in_space(mesh.points);
  double along = 0.0;
  for (std::size_t k = 1; k < order.size(); ++k)
    along += length(mesh.points[order[k]] - mesh.points[order[k - 1]]) / static_cast<double>(order.size());
  EXPECT_LT(along, 2.5 / 12.0);  // cells; a random order makes 8
  std::sort(order.begin(), order.end());
  for (std::size_t k = 0; k < order.size(); ++k) ASSERT_EQ(order[k], k);
}

TEST(PlainLayout, EachSpringIsInOneBlockOrAcrossTwo) {
  const TetMesh mesh = build_kuhn_cube(5, 0.2, 5);
  const SpringNetwork net = make_edge_springs(mesh, 1.0);
  std::vector<Index> place(mesh.points.size());
  std::iota(place.rbegin(), place.rend(), Index{0});
  const SpringBlocks blocks = build_spring_blocks(net.springs, place, 50);
  ASSERT_EQ(blocks.inside.size(), (mesh.points.size() + 49) / 50);
  std::vector<int> seen(net.springs.size());
  for (std::size_t b = 0; b < blocks.inside.size(); ++b) {
    for (const SpringFan& fan : blocks.inside[b]) {
      ASSERT_NE(fan.springs[0], kNoIndex);
      bool is_over = false;
      for (const Index s : fan.springs) {
        is_over = is_over || s == kNoIndex;
        ASSERT_EQ(s == kNoIndex, is_over);
        if (is_over) continue;
        EXPECT_TRUE(net.springs[s][0] == fan.hub || net.springs[s][1] == fan.hub);
        for (const Index end : net.springs[s]) EXPECT_EQ(place[end] / 50, b);
        seen[s] += 2;
      }
    }
    for (const Index s : blocks.across[b]) {
      EXPECT_NE(place[net.springs[s][0]] / 50 == b, place[net.springs[s][1]] / 50 == b);
      seen[s] += 1;
    }
  }
  for (const int count : seen) EXPECT_EQ(count, 2);
}

TEST(PlainLayout, FewFansAreNotFull) {
  const TetMesh mesh = build_kuhn_cube(13, 0.2, 5);
  const SpringNetwork net = make_edge_springs(mesh, 1.0);
  const std::vector<Index> order = order_in_space(mesh.points);
  std::vector<Index> place(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) place[order[k]] = static_cast<Index>(k);
  const SpringBlocks blocks = build_spring_blocks(net.springs, place, 2048);
  std::size_t fans = 0;
  std::size_t springs = 0;
  for (const auto& block : blocks.inside) {
    fans += block.size();
    for (const SpringFan& fan : block)
      springs += static_cast<std::size_t>(4 - std::count(fan.springs.begin(), fan.springs.end(), kNoIndex));
  }
  // Only a vertex without later neighbours can leave some, three at the most: one in some fifteen of nearly
  // seven springs each, so less than 3%.
  EXPECT_LT(4 * fans, springs + springs * 3 / 100);
  EXPECT_GE(4 * fans, springs);
}

}  // namespace
}  // namespace palpate::dynamics
