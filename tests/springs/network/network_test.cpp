#include "core/springs/network/network.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <set>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "core/springs/identification/closed_forms.h"
#include "core/springs/network/weak_vertices.h"
#include "tests/support/small_meshes.h"

namespace palpate::springs {
namespace {

using namespace testing_support;

TEST(SpringNetwork, OneSpringAnEdgeAtItsRestLength) {
  const TetMesh tet = make_corner_tet();
  const SpringNetwork network = build_spring_network(tet);
  EXPECT_EQ(network.springs, (std::vector<Edge>{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}));
  const double root = std::sqrt(2.0);
  EXPECT_EQ(network.rest_length_m, (std::vector<double>{1, 1, 1, root, root, root}));
  EXPECT_EQ(network.stiffness_n_per_m, std::vector<double>(6, 0.0));
  const TetMesh bar = build_bar(2);
  EXPECT_EQ(build_spring_network(bar).springs, build_edges(bar));
}

TEST(SpringNetwork, FaceOppositeJoinsTheApexesOfEachInteriorFace) {
  const SpringNetwork network = build_spring_network(make_two_tets(), true);
  ASSERT_EQ(network.springs.size(), 10U);
  const TetMesh two = make_two_tets();
  const auto shared = [&](Index v) {
    return std::find(two.tets[0].begin(), two.tets[0].end(), v) != two.tets[0].end() &&
           std::find(two.tets[1].begin(), two.tets[1].end(), v) != two.tets[1].end();
  };
  const std::vector<Edge> edges = build_edges(two);
  for (const Edge& spring : network.springs) {
    if (std::find(edges.begin(), edges.end(), spring) != edges.end()) continue;
    EXPECT_FALSE(shared(spring[0]) || shared(spring[1]));
  }
}

TEST(SpringNetwork, FaceOppositeAgainstBruteForce) {
  const TetMesh mesh = build_kuhn_cube(3, 0.2, 5);
  std::set<Edge> expected;
  for (const Edge& edge : build_edges(mesh)) expected.insert(edge);
  for (std::size_t s = 0; s < mesh.tets.size(); ++s) {
    for (std::size_t t = 0; t < s; ++t) {
      const std::set<Index> a(mesh.tets[s].begin(), mesh.tets[s].end());
      const std::set<Index> b(mesh.tets[t].begin(), mesh.tets[t].end());
      std::vector<Index> apart;
      std::set_symmetric_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(apart));
      if (apart.size() == 2) expected.insert({std::min(apart[0], apart[1]), std::max(apart[0], apart[1])});
    }
  }
  const SpringNetwork network = build_spring_network(mesh, true);
  EXPECT_EQ(network.springs, std::vector<Edge>(expected.begin(), expected.end()));
}

TEST(SpringNetwork, InfluenceVolumesAddUpToTheVolume) {
  const TetMesh one = make_corner_tet();
  for (const double volume : build_influence_volumes(one)) EXPECT_DOUBLE_EQ(volume, 1.0 / 24.0);
  const TetMesh mesh = build_kuhn_cube(4, 0.3, 11);
  const std::vector<double> volumes = build_influence_volumes(mesh);
  EXPECT_NEAR(std::accumulate(volumes.begin(), volumes.end(), 0.0), 1.0, 1e-13);
}

TEST(SpringNetwork, LumpedMassesAreDensityTimesInfluenceVolume) {
  const TetMesh mesh = build_bar(2);
  const std::vector<double> masses = build_lumped_masses(mesh, 1050.0);
  EXPECT_NEAR(std::accumulate(masses.begin(), masses.end(), 0.0), 4.0 * 1050.0, 1e-9);
  for (const double bad : {0.0, -1.0, std::nan(""), std::numeric_limits<double>::infinity()})
    EXPECT_THROW(build_lumped_masses(mesh, bad), InputError) << bad;
}

TEST(SpringNetwork, TheThesisCentreIsNotTheCentreOfMass) {
  // Half of a cube in one tet layout, the other half cut finer: the mean of barycentres moves to the finer
  // side.
  TetMesh mesh = join_meshes(make_kuhn_block(1, 1, 1), translated(make_kuhn_block(2, 2, 2), {1, 0, 0}));
  for (std::size_t v = 8; v < mesh.points.size(); ++v) {
    mesh.points[v] = {1.0 + 0.5 * (mesh.points[v].x - 1.0), 0.5 * mesh.points[v].y, 0.5 * mesh.points[v].z};
  }
  const Vec3 mass = center_of_mass(mesh);
  EXPECT_NEAR(mass.x, 1.0, 1e-14);
  EXPECT_NEAR(mass.y, 0.5, 1e-14);
  // 6 tets around 0.5 and 48 around 1.5.
  EXPECT_NEAR(geometric_center(mesh).x, (6 * 0.5 + 48 * 1.5) / 54.0, 1e-14);
  const Vec3 center = geometric_center(make_regular_tet());
  const Vec3 same = center_of_mass(make_regular_tet());
  EXPECT_NEAR(length(center - same), 0.0, 1e-15);
}

TEST(SpringNetwork, TetSpringsAreTheEdgesOfTheTet) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 3);
  SpringNetwork network = build_spring_network(mesh, true);
  const auto tet_springs = build_tet_springs(mesh, network);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (std::size_t i = 0; i < 6; ++i) {
      const Index a = mesh.tets[t][kTetEdges[i][0]];
      const Index b = mesh.tets[t][kTetEdges[i][1]];
      EXPECT_EQ(network.springs[tet_springs[t][i]], (Edge{std::min(a, b), std::max(a, b)}));
    }
  }
  network.springs.erase(network.springs.begin());
  EXPECT_THROW(build_tet_springs(mesh, network), ContractError);
}

TEST(SpringNetwork, VertexSpringsAreAllThatTouchIt) {
  const TetMesh mesh = make_kuhn_block(2, 1, 1);
  const SpringNetwork network = build_spring_network(mesh);
  const VertexSprings rows = build_vertex_springs(network, mesh.points.size());
  for (Index v = 0; v < mesh.points.size(); ++v) {
    std::vector<Index> expected;
    for (Index s = 0; s < network.springs.size(); ++s) {
      if (network.springs[s][0] == v || network.springs[s][1] == v) expected.push_back(s);
    }
    EXPECT_EQ(std::vector<Index>(rows.of(v).begin(), rows.of(v).end()), expected);
  }
}

TEST(SpringNetwork, HangingAreVerticesThatSpringsLeaveFreeInSomeDirection) {
  const TetMesh mesh = build_kuhn_cube(3, 0.2, 4);
  constexpr double kModulus = 1000.0;
  SpringNetwork network = build_spring_network(mesh);
  set_van_gelder(mesh, kModulus, network);
  EXPECT_TRUE(find_hanging_vertices(mesh, network, kModulus).empty());
  const VertexSprings springs = build_vertex_springs(network, mesh.points.size());
  constexpr Index kVertex = 21;  // inside
  const std::vector<double> whole = network.stiffness_n_per_m;
  const auto hanging_with = [&](std::size_t left) {
    network.stiffness_n_per_m = whole;
    for (std::size_t i = left; i < springs.of(kVertex).size(); ++i)
      network.stiffness_n_per_m[springs.of(kVertex)[i]] = 0.0;
    return find_hanging_vertices(mesh, network, kModulus);
  };
  const std::vector<Index> alone{kVertex};
  EXPECT_EQ(hanging_with(0), alone);  // without any spring
  EXPECT_EQ(hanging_with(2), alone);  // two springs leave their normal free
  EXPECT_TRUE(hanging_with(3).empty());
  // A softer solid has softer springs: what counts is their share of the solid's.
  hanging_with(springs.of(kVertex).size());
  for (double& k : network.stiffness_n_per_m) k *= 1e-12;
  EXPECT_TRUE(find_hanging_vertices(mesh, network, 1e-12 * kModulus).empty());
  EXPECT_EQ(find_hanging_vertices(mesh, network, kModulus).size(), mesh.points.size());
}

TEST(SpringNetwork, DegenerateAreVerticesOfOneTetAndFlatFans) {
  EXPECT_EQ(find_degenerate_vertices(make_corner_tet(), build_spring_network(make_corner_tet())),
            (std::vector<Index>{0, 1, 2, 3}));
  const TetMesh two = make_two_tets();
  EXPECT_EQ(find_degenerate_vertices(two, build_spring_network(two)).size(), 2U);
  // A wheel of six tets around the axis 0-1, flattened until it is a disc.
  TetMesh wheel;
  wheel.points = {{0, 0, 0}, {0, 0, 1}};
  for (int i = 0; i < 6; ++i)
    wheel.points.push_back(
        {std::cos((i + 0.5) * std::numbers::pi / 3), std::sin((i + 0.5) * std::numbers::pi / 3), 0.4});
  for (Index i = 0; i < 6; ++i) wheel.tets.push_back({0, 2 + i, 2 + (i + 1) % 6, 1});
  EXPECT_EQ(find_degenerate_vertices(wheel, build_spring_network(wheel)), std::vector<Index>{});
  for (Vec3& point : wheel.points) point.x *= 0.01;
  EXPECT_EQ(find_degenerate_vertices(wheel, build_spring_network(wheel)).size(), 8U);
}

}  // namespace
}  // namespace palpate::springs
