#include "core/springs/network/tet_shares.h"

#include <gtest/gtest.h>

#include "core/mesh/geometry.h"
#include "core/mesh/shapes/shapes.h"
#include "core/springs/identification/closed_forms.h"
#include "core/springs/identification/stiffness_fit.h"
#include "core/springs/network/network.h"
#include "tests/support/small_meshes.h"

namespace palpate::springs {
namespace {

using namespace testing_support;

double sum_of_kll(const SpringNetwork& network) {
  double sum = 0.0;
  for (std::size_t s = 0; s < network.springs.size(); ++s)
    sum += network.stiffness_n_per_m[s] * network.rest_length_m[s] * network.rest_length_m[s];
  return sum;
}

TEST(TetShares, WithoutOppositeSpringsATetsConstantsAreAddedAsTheyAre) {
  const TetMesh two = make_two_tets();
  SpringNetwork network = build_spring_network(two);
  TetShares shares(two, network);
  shares.add(0, {1, 2, 3, 4, 5, 6});
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_EQ(network.stiffness_n_per_m[shares.springs_of(0)[i]], static_cast<double>(i + 1));
}

TEST(TetShares, TwoTetsGiveASeventhToTheSpringBetweenTheirApexes) {
  const TetMesh two = make_two_tets();
  SpringNetwork network = build_spring_network(two, true);
  ASSERT_EQ(network.springs.size(), 10u);
  set_van_gelder(two, 1.0, network);
  // Each tet: 6 E V_T in seven equal parts of k l^2.
  const double part = 6.0 * total_volume(two) / 7.0;
  std::vector<bool> is_edge(10, false);
  for (const auto& springs : build_tet_springs(two, network)) {
    for (const Index s : springs) is_edge[s] = true;
  }
  int opposite = 0;
  for (std::size_t s = 0; s < 10; ++s) {
    if (is_edge[s]) continue;
    ++opposite;
    EXPECT_NEAR(network.stiffness_n_per_m[s] * network.rest_length_m[s] * network.rest_length_m[s], part,
                1e-14);
  }
  EXPECT_EQ(opposite, 1);
}

TEST(TetShares, WhatAMethodSaysOfTheSumHoldsWithOppositeSprings) {
  const TetMesh mesh = build_kuhn_cube(3, 0.2, 5);
  const Material material{1000.0, 0.25, 0.0};
  const auto check = [&](auto&& set) {
    SpringNetwork edges = build_spring_network(mesh);
    SpringNetwork more = build_spring_network(mesh, true);
    ASSERT_GT(more.springs.size(), edges.springs.size());
    set(edges);
    set(more);
    EXPECT_NEAR(sum_of_kll(more) / sum_of_kll(edges), 1.0, 1e-13);
    for (const double k : more.stiffness_n_per_m) EXPECT_GE(k, 0.0);
  };
  check([&](SpringNetwork& network) { set_van_gelder(mesh, 1000.0, network); });
  check([&](SpringNetwork& network) { set_lloyd(mesh, 1000.0, network); });
  check([&](SpringNetwork& network) { set_maciel(mesh, 1000.0, network); });
  check([&](SpringNetwork& network) { set_stiffness_fit(mesh, material, network); });
}

}  // namespace
}  // namespace palpate::springs
