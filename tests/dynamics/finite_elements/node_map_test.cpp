// Nodes that follow others: linear fields, nested stiffness, and which edges are near.
#include "core/dynamics/finite_elements/node_map.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/dynamics/linear_algebra/vertex_field.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/subdivision/refinement.h"
#include "core/mesh/topology.h"

namespace palpate::dynamics {
namespace {

constexpr Mat3 kSlope{{0.7, -0.4, 0.2, 0.1, 0.9, -0.3, -0.6, 0.5, 0.8}};
constexpr Material kMaterial{1e4, 0.3, 1000.0};

std::vector<Vec3> draw_field(std::size_t size, std::uint64_t seed) {
  SplitMix64 random(seed);
  std::vector<Vec3> field(size);
  for (Vec3& v : field) v = {random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
  return field;
}

/// |A x - B x| / |A x| for a field that is drawn.
double product_off(const BlockMatrix& a, const BlockMatrix& b) {
  if (a.rows() != b.rows()) return INFINITY;
  const std::vector<Vec3> x = draw_field(a.rows(), 5);
  std::vector<Vec3> first(x.size());
  std::vector<Vec3> second(x.size());
  multiply(a, x, first);
  multiply(b, x, second);
  add_scaled(second, -1.0, first);
  return norm_of(second) / norm_of(first);
}

class NodeMaps : public testing::Test {
 protected:
  std::vector<std::uint8_t> flags(std::uint8_t value) const {
    return std::vector<std::uint8_t>(space_.edges.edges.size(), value);
  }
  /// Every third edge.
  std::vector<std::uint8_t> some() const {
    std::vector<std::uint8_t> out = flags(0);
    for (std::size_t e = 0; e < out.size(); e += 3) out[e] = 1;
    return out;
  }

  TetMesh mesh_ = build_kuhn_cube(3, 0.3, 7);
  ElementSpace space_ = build_element_space(mesh_, 2);
  BlockMatrix quadratic_ = build_element_matrices(mesh_, space_, kMaterial).stiffness;
  BlockMatrix linear_ = build_element_matrices(mesh_, build_element_space(mesh_, 1), kMaterial).stiffness;
};

TEST_F(NodeMaps, TakeLinearFieldsToLinearFields) {
  const TetMesh finer = refine_uniformly(mesh_);
  const ElementSpace fine = build_element_space(finer, 2);
  const auto check = [](const NodeMap& map, const std::vector<Vec3>& points) {
    std::vector<Vec3> u;
    for (const Index node : map.nodes) u.push_back(kSlope * points[node]);
    const std::vector<Vec3> all = apply_map(map, u);
    ASSERT_EQ(all.size(), points.size());
    for (std::size_t i = 0; i < all.size(); ++i)
      ASSERT_LT(length(all[i] - kSlope * points[i]), 1e-14) << "node " << i;
  };
  check(follow_edges(space_, some()), space_.points);
  check(embed_linear(space_, mesh_.points.size(), {}), space_.points);
  check(embed_linear(fine, mesh_.points.size(), build_edges(mesh_)), fine.points);
}

TEST_F(NodeMaps, TheLimitsAreLinearAndQuadraticElements) {
  EXPECT_LT(product_off(linear_, restrict_matrix(follow_edges(space_, flags(0)), space_, quadratic_)), 1e-13);
  EXPECT_LT(product_off(quadratic_, restrict_matrix(follow_edges(space_, flags(1)), space_, quadratic_)),
            1e-13);
  // What is between is neither, and a matrix that is off is seen.
  const BlockMatrix some_of_it = restrict_matrix(follow_edges(space_, some()), space_, quadratic_);
  EXPECT_GT(some_of_it.rows(), linear_.rows());
  EXPECT_LT(some_of_it.rows(), quadratic_.rows());
  BlockMatrix broken = linear_;
  broken.blocks[3] += 0.1 * kMaterial.young_modulus_pa * kIdentity;
  EXPECT_GT(product_off(linear_, broken), 1e-4);
}

TEST_F(NodeMaps, LinearFunctionsHaveTheirStiffnessOnAFinerMeshToo) {
  const TetMesh finer = refine_uniformly(mesh_);
  const ElementSpace fine = build_element_space(finer, 2);
  const BlockMatrix stiffness = build_element_matrices(finer, fine, kMaterial).stiffness;
  const NodeMap map = embed_linear(fine, mesh_.points.size(), build_edges(mesh_));
  EXPECT_LT(product_off(linear_, restrict_matrix(map, fine, stiffness)), 1e-12);
}

TEST_F(NodeMaps, RestrictedEnergyIsThatOfTheWholeField) {
  const NodeMap map = follow_edges(space_, some());
  const BlockMatrix restricted = restrict_matrix(map, space_, quadratic_);
  const std::vector<Vec3> u = draw_field(map.nodes.size(), 9);
  const std::vector<Vec3> all = apply_map(map, u);
  std::vector<Vec3> small(u.size());
  std::vector<Vec3> large(all.size());
  multiply(restricted, u, small);
  multiply(quadratic_, all, large);
  const double energy = dot_of(all, large);
  EXPECT_NEAR(dot_of(u, small), energy, 1e-12 * energy);
  const std::vector<Vec3> back = apply_transposed(map, large);
  EXPECT_NEAR(dot_of(u, back), energy, 1e-12 * energy);
}

TEST_F(NodeMaps, EdgesNearAreThoseWithBothEndsInReach) {
  std::vector<std::uint8_t> touched(mesh_.points.size(), 0);
  for (std::size_t v = 0; v < touched.size(); ++v) touched[v] = mesh_.points[v].z == 0.0 ? 1 : 0;
  const auto count = [&](int rings) {
    std::size_t sum = 0;
    const std::vector<std::uint8_t> near = find_edges_near(space_.edges, touched, rings);
    for (std::size_t e = 0; e < near.size(); ++e) {
      if (near[e] == 0) continue;
      ++sum;
      if (rings == 0) {
        for (const Index v : space_.edges.edges[e]) EXPECT_EQ(mesh_.points[v].z, 0.0);
      }
    }
    return sum;
  };
  EXPECT_EQ(count(-1), 0U);
  EXPECT_EQ(count(0), 33U);  // 3 x 3 squares: 2 x 12 sides and 9 diagonals
  EXPECT_GT(count(1), count(0));
  EXPECT_LT(count(1), count(2));
  EXPECT_EQ(count(3), space_.edges.edges.size());  // Kuhn's cells are one edge high
}

TEST_F(NodeMaps, TouchedAreFacesAndForces) {
  BoundaryProblem problem;
  problem.held.push_back({{{0, 1, 2}}, {true, true, true}, {}});
  problem.nodal_forces.push_back({5, {1.0, 0.0, 0.0}});
  const std::vector<std::uint8_t> touched = find_touched(7, problem);
  EXPECT_EQ(touched, (std::vector<std::uint8_t>{1, 1, 1, 0, 0, 1, 0}));
}

TEST_F(NodeMaps, RefuseAnotherOrder) {
  EXPECT_THROW(follow_edges(build_element_space(mesh_, 1), {}), ContractError);
  EXPECT_THROW(embed_linear(space_, mesh_.points.size() + 1, {}), ContractError);
}

}  // namespace
}  // namespace palpate::dynamics
