#include "core/mesh/subdivision/refinement.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/mesh/geometry.h"
#include "core/mesh/orientation.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"

namespace palpate {
namespace {

std::vector<TetMesh> shapes() {
  const TetMesh one{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}};
  return {one, build_kuhn_cube(3, 0.0, 0), build_kuhn_cube(4, 0.3, 5), build_bar(1), build_bcc_bar(2)};
}

double volume_of(const TetMesh& mesh, std::size_t t) {
  const Tet& v = mesh.tets[t];
  return signed_volume(mesh.points[v[0]], mesh.points[v[1]], mesh.points[v[2]], mesh.points[v[3]]);
}

Vec3 area_vector(const TetMesh& mesh, const Triangle& t) {
  const auto& p = mesh.points;
  return 0.5 * cross(p[t[1]] - p[t[0]], p[t[2]] - p[t[0]]);
}

Vec3 quadratic(const Vec3& x) {
  return {1 + x.x * x.y - 2 * x.z, x.z * x.z + 3 * x.x, x.y * x.y - x.x * x.z + 0.5 * x.y};
}

std::vector<Vec3> at_nodes(const TetMesh& mesh) {
  std::vector<Vec3> field;
  for (const Vec3& point : mesh.points) field.push_back(quadratic(point));
  for (const auto& [a, b] : build_edges(mesh)) {
    field.push_back(quadratic(0.5 * (mesh.points[a] + mesh.points[b])));
  }
  return field;
}

std::set<Triangle> sorted_faces(std::vector<Triangle> faces) {
  for (Triangle& face : faces) std::sort(face.begin(), face.end());
  return {faces.begin(), faces.end()};
}

TEST(Refinement, EdgeNumbersFindEachEdgeAndNothingElse) {
  for (const TetMesh& mesh : shapes()) {
    const EdgeNumbers numbers = build_edge_numbers(mesh);
    ASSERT_EQ(numbers.edges, build_edges(mesh));
    const std::set<Edge> known(numbers.edges.begin(), numbers.edges.end());
    for (Index a = 0; a < mesh.points.size(); ++a) {
      for (Index b = a + 1; b < mesh.points.size(); ++b) {
        const Index found = numbers.of(a, b);
        ASSERT_EQ(found, numbers.of(b, a));
        if (known.count({a, b}) == 0) {
          ASSERT_EQ(found, kNoIndex);
        } else {
          ASSERT_EQ(numbers.edges[found], (Edge{a, b}));
        }
      }
    }
    EXPECT_EQ(numbers.of(0, static_cast<Index>(mesh.points.size())), kNoIndex);
  }
}

TEST(Refinement, EightPositiveChildrenOfEqualVolume) {
  for (const TetMesh& mesh : shapes()) {
    const TetMesh fine = refine_uniformly(mesh);
    ASSERT_EQ(fine.tets.size(), 8 * mesh.tets.size());
    const double largest = length_sq(bounding_box(mesh.points).high);
    for (std::size_t c = 0; c < fine.tets.size(); ++c) {
      const Tet& v = fine.tets[c];
      ASSERT_EQ(orientation(fine.points[v[0]], fine.points[v[1]], fine.points[v[2]], fine.points[v[3]]), 1);
      // Midpoints are rounded by half a unit in the last place of a coordinate.
      ASSERT_NEAR(volume_of(fine, c), volume_of(mesh, c / 8) / 8, 1e-14 * largest);
    }
  }
}

TEST(Refinement, OldVerticesComeFirstThenMidpointsInTheOrderOfEdges) {
  for (const TetMesh& mesh : shapes()) {
    const TetMesh fine = refine_uniformly(mesh);
    const std::vector<Edge> edges = build_edges(mesh);
    ASSERT_EQ(fine.points.size(), mesh.points.size() + edges.size());
    EXPECT_TRUE(std::equal(mesh.points.begin(), mesh.points.end(), fine.points.begin()));
    for (std::size_t i = 0; i < edges.size(); ++i) {
      const Vec3 middle = 0.5 * (mesh.points[edges[i][0]] + mesh.points[edges[i][1]]);
      ASSERT_EQ(fine.points[mesh.points.size() + i], middle);
    }
  }
}

TEST(Refinement, ChildrenFitTogether) {
  for (const TetMesh& mesh : shapes()) {
    const TetMesh fine = refine_uniformly(refine_uniformly(mesh));
    // A ball: build_boundary throws on a face with three tets, and Euler's number is 1 only if neighbours
    // share faces.
    EXPECT_EQ(build_boundary(fine).size(), 16 * build_boundary(mesh).size());
    const std::size_t plus = fine.points.size() + build_faces(fine).size();
    EXPECT_EQ(plus - build_edges(fine).size() - fine.tets.size(), 1U);
  }
}

TEST(Refinement, TakesTheShortestDiagonalAndOfEqualOnesTheFirst) {
  // Stretched along the edge 01: its midpoint to the one of 23 is the shortest way through (points 4 and 9).
  TetMesh mesh{{{-3, 0, 0}, {3, 0, 0}, {0, 1, -1}, {0, 1, 1}}, {{0, 1, 2, 3}}};
  if (volume_of(mesh, 0) < 0) std::swap(mesh.tets[0][2], mesh.tets[0][3]);
  const std::vector<Edge> edges = build_edges(refine_uniformly(mesh));
  EXPECT_TRUE(std::binary_search(edges.begin(), edges.end(), Edge{4, 9}));
  // Three equal diagonals (a regular tet): 4-9 again, whatever the order in which the tet names its vertices.
  Tet order{0, 1, 2, 3};
  const std::vector<Vec3> regular{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
  do {
    const TetMesh turned{regular, {order}};
    const std::vector<Edge> found = build_edges(refine_uniformly(turned));
    EXPECT_TRUE(std::binary_search(found.begin(), found.end(), Edge{4, 9}));
    EXPECT_FALSE(std::binary_search(found.begin(), found.end(), Edge{5, 8}));
    EXPECT_FALSE(std::binary_search(found.begin(), found.end(), Edge{6, 7}));
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST(Refinement, ShapesStayBounded) {
  // Volume over the cube of the longest edge of the worst tet, after each of three refinements.
  TetMesh mesh = build_kuhn_cube(2, 0.3, 9);
  double first = 0.0;
  for (int level = 0; level < 4; ++level) {
    double worst = 1.0;
    for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
      double longest = 0.0;
      for (const auto& [i, j] : kTetEdges) {
        longest = std::max(longest, length(mesh.points[mesh.tets[t][i]] - mesh.points[mesh.tets[t][j]]));
      }
      worst = std::min(worst, volume_of(mesh, t) / (longest * longest * longest));
    }
    if (level == 0) first = worst;
    EXPECT_GT(worst, first / 4) << "level " << level;
    if (level < 3) mesh = refine_uniformly(mesh);
  }
}

TEST(Refinement, TrianglesHandDownTheirAreaAndTheirSide) {
  for (const TetMesh& mesh : shapes()) {
    const TetMesh fine = refine_uniformly(mesh);
    const std::vector<Triangle> boundary = build_boundary(mesh);
    const std::vector<Triangle> children =
        refine_triangles(boundary, build_edge_numbers(mesh), mesh.points.size());
    EXPECT_EQ(sorted_faces(children), sorted_faces(build_boundary(fine)));
    for (std::size_t c = 0; c < children.size(); ++c) {
      const Vec3 gap = 4.0 * area_vector(fine, children[c]) - area_vector(mesh, boundary[c / 4]);
      ASSERT_LT(length(gap), 1e-14);
    }
  }
  const TetMesh mesh = build_kuhn_cube(2, 0.0, 0);
  const std::vector<Triangle> foreign{{0, 1, 26}};
  EXPECT_THROW(refine_triangles(foreign, build_edge_numbers(mesh), mesh.points.size()), ContractError);
}

TEST(Refinement, AQuadraticFieldStaysTheSameFunction) {
  for (const TetMesh& mesh : shapes()) {
    const TetMesh fine = refine_uniformly(mesh);
    const std::vector<Vec3> found = refine_quadratic_field(mesh, fine, at_nodes(mesh));
    const std::vector<Vec3> expected = at_nodes(fine);
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) ASSERT_LT(length(found[i] - expected[i]), 1e-13) << i;
  }
  const TetMesh mesh = build_bar(1);
  const std::vector<Vec3> vertices_only(mesh.points.size());
  EXPECT_THROW(refine_quadratic_field(mesh, refine_uniformly(mesh), vertices_only), ContractError);
}

TEST(Refinement, ARandomFieldOfATetIsQuadraticOnItsChildren) {
  // Not from a polynomial in x, y, z: each tet has one of its own. Twice refined in one go or through the
  // middle.
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 4);
  SplitMix64 random(11);
  std::vector<Vec3> field(mesh.points.size() + build_edges(mesh).size());
  for (Vec3& value : field) value = {random.uniform(), random.uniform(), random.uniform()};
  const TetMesh fine = refine_uniformly(mesh);
  const std::vector<Vec3> once = refine_quadratic_field(mesh, fine, field);
  const EdgeNumbers coarse_edges = build_edge_numbers(mesh);
  const EdgeNumbers fine_edges = build_edge_numbers(fine);
  for (std::size_t e = 0; e < coarse_edges.edges.size(); ++e) {
    const auto& [a, b] = coarse_edges.edges[e];
    const Index middle = static_cast<Index>(mesh.points.size() + e);
    const Vec3 quarter = 0.375 * field[a] + 0.75 * field[middle] + -0.125 * field[b];  // Lagrange at 1/4
    ASSERT_LT(length(once[fine.points.size() + fine_edges.of(a, middle)] - quarter), 1e-14);
  }
}

TEST(Refinement, AProblemIsInherited) {
  const TetMesh mesh = build_kuhn_cube(2, 0.2, 4);
  const std::vector<Triangle> boundary = build_boundary(mesh);
  BoundaryProblem problem;
  problem.material = {10000.0, 0.3, 1000.0};
  problem.gravity_m_s2 = {0, 0, -9.81};
  problem.held.push_back({{boundary[0], boundary[5]}, {true, false, true}, {0.1, 0, 0}});
  problem.supports.push_back({{{boundary[1], boundary[2]}, {0.25, 1.0}}, 5.0, {0, 0, 1}});
  problem.tractions.push_back({{{boundary[3]}, {0.5}}, {1, 2, 3}, 4.0});
  problem.nodal_forces.push_back({7, {1, 1, 1}});
  problem.body_force_n_m3 = at_nodes(mesh);
  const TetMesh fine = refine_uniformly(mesh);
  const BoundaryProblem inherited = refine_problem(problem, mesh, fine);
  const EdgeNumbers edges = build_edge_numbers(mesh);
  EXPECT_EQ(inherited.held[0].faces, refine_triangles(problem.held[0].faces, edges, mesh.points.size()));
  EXPECT_EQ(inherited.held[0].axes, problem.held[0].axes);
  EXPECT_EQ(inherited.held[0].by_m, problem.held[0].by_m);
  EXPECT_EQ(inherited.supports[0].patch.weight, (std::vector<double>{.25, .25, .25, .25, 1, 1, 1, 1}));
  EXPECT_EQ(inherited.supports[0].stiffness_pa_per_m, 5.0);
  EXPECT_EQ(inherited.tractions[0].patch.faces.size(), 4U);
  EXPECT_EQ(inherited.tractions[0].patch.weight, std::vector<double>(4, 0.5));
  EXPECT_EQ(inherited.tractions[0].pressure_pa, 4.0);
  EXPECT_EQ(inherited.nodal_forces[0].vertex, 7U);
  EXPECT_EQ(inherited.body_force_n_m3.size(), fine.points.size() + build_edges(fine).size());
  EXPECT_TRUE(inherited.held_field_m.empty());
  EXPECT_EQ(inherited.material.poisson_ratio, 0.3);
  EXPECT_EQ(inherited.gravity_m_s2, problem.gravity_m_s2);
  problem.supports[0].patch.weight.pop_back();
  EXPECT_THROW(refine_problem(problem, mesh, fine), ContractError);
}

TEST(Refinement, AnEmptyMeshStaysEmpty) {
  EXPECT_EQ(refine_uniformly(TetMesh{}), TetMesh{});
}

}  // namespace
}  // namespace palpate
