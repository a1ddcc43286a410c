#include <gtest/gtest.h>

#include "core/judge/mesh/judge.h"
#include "core/mesh/topology.h"
#include "tests/support/small_meshes.h"

namespace palpate::judge {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

void expect_euler(const TetMesh& mesh, std::int64_t euler, std::uint64_t components,
                  std::uint64_t boundary_components) {
  const Counts counts = count_elements(mesh);
  EXPECT_EQ(counts.euler, euler);
  EXPECT_EQ(counts.boundary_euler, 2 * euler);
  EXPECT_TRUE(counts.euler_consistent);
  EXPECT_EQ(counts.components, components);
  EXPECT_EQ(counts.boundary_components, boundary_components);
}

TEST(Counts, OneTet) {
  const Counts c = count_elements(make_corner_tet());
  EXPECT_EQ(c.vertices, 4U);
  EXPECT_EQ(c.edges, 6U);
  EXPECT_EQ(c.faces, 4U);
  EXPECT_EQ(c.tets, 1U);
  EXPECT_EQ(c.boundary_vertices, 4U);
  EXPECT_EQ(c.boundary_edges, 6U);
  EXPECT_EQ(c.boundary_faces, 4U);
  EXPECT_TRUE(c.formula_a1 && c.formula_a2 && c.formula_a3);
}

TEST(Counts, KuhnBlocksByClosedForm) {
  for (const auto& [nx, ny, nz] : {Cell{1, 1, 1}, Cell{2, 3, 4}, Cell{5, 5, 5}, Cell{7, 1, 2}}) {
    const auto n = [](int k) { return static_cast<std::uint64_t>(k); };
    const Counts c = count_elements(make_kuhn_block(nx, ny, nz));
    const std::uint64_t cells = n(nx) * n(ny) * n(nz);
    const std::uint64_t squares = n(nx) * n(ny) + n(ny) * n(nz) + n(nz) * n(nx);
    // Edges: along the axes, one diagonal a grid square, one a cell.
    const std::uint64_t axis_edges =
        n(nx) * n(ny + 1) * n(nz + 1) + n(nx + 1) * n(ny) * n(nz + 1) + n(nx + 1) * n(ny + 1) * n(nz);
    const std::uint64_t grid_squares =
        n(nx) * n(ny) * n(nz + 1) + n(nx) * n(ny + 1) * n(nz) + n(nx + 1) * n(ny) * n(nz);
    EXPECT_EQ(c.vertices, n(nx + 1) * n(ny + 1) * n(nz + 1));
    EXPECT_EQ(c.edges, axis_edges + grid_squares + cells);
    EXPECT_EQ(c.tets, 6 * cells);
    EXPECT_EQ(c.boundary_faces, 4 * squares);
    EXPECT_EQ(c.faces, (4 * c.tets + c.boundary_faces) / 2);
    EXPECT_EQ(c.boundary_edges, c.boundary_faces / 2 * 3);
    EXPECT_EQ(c.boundary_vertices, c.boundary_faces / 2 + 2);
    EXPECT_EQ(c.components, 1U);
    EXPECT_EQ(c.boundary_components, 1U);
    EXPECT_TRUE(c.formula_a1 && c.formula_a2 && c.formula_a3 && c.euler_consistent);
  }
}

TEST(Counts, AgreeWithTheTopologyOfTheMeshFloor) {
  const TetMesh mesh = make_kuhn_block(4, 3, 5);
  const Counts c = count_elements(mesh);
  EXPECT_EQ(c.edges, build_edges(mesh).size());
  EXPECT_EQ(c.faces, build_faces(mesh).size());
  EXPECT_EQ(c.boundary_faces, build_boundary(mesh).size());
}

TEST(Counts, AHandleTakesOneFromEuler) {
  expect_euler(make_cube_ring(), 0, 1, 1);
  const Counts c = count_elements(make_cube_ring());
  EXPECT_FALSE(c.formula_a1);
  EXPECT_FALSE(c.formula_a2);
}

TEST(Counts, ACavityAddsOneToEuler) {
  expect_euler(make_hollow_cube(), 2, 1, 2);
  const Counts c = count_elements(make_hollow_cube());
  EXPECT_FALSE(c.formula_a1);
  EXPECT_FALSE(c.formula_a2);
}

TEST(Counts, ComponentsAddUp) {
  const TetMesh two = join_meshes(make_kuhn_block(2, 2, 2), translated(make_corner_tet(), {9, 0, 0}));
  expect_euler(two, 2, 2, 2);
  EXPECT_FALSE(count_elements(two).formula_a1);
  expect_euler(join_meshes(two, translated(make_cube_ring(), {0, 9, 0})), 2, 3, 3);
}

TEST(Counts, AHandleAndACavityDoNotPassForABall) {
  // A ring with a cavity in it has the Euler characteristics of a ball; only the components tell.
  std::vector<Cell> cells;
  for (int i = 0; i < 5 * 5 * 3; ++i) {
    const Cell cell{i % 5, i / 5 % 5, i / 25};
    const bool hole = cell[0] == 2 && cell[1] == 3;
    const bool cavity = cell[0] == 1 && cell[1] == 1 && cell[2] == 1;
    if (!hole && !cavity) cells.push_back(cell);
  }
  const TetMesh mesh = make_kuhn_cells(cells);
  expect_euler(mesh, 1, 1, 2);
  EXPECT_FALSE(count_elements(mesh).formula_a1);
  EXPECT_TRUE(count_elements(mesh).formula_a2);
}

TEST(Counts, MissingTetInsideChangesEuler) {
  TetMesh mesh = make_kuhn_block(3, 3, 3);
  mesh.tets.erase(mesh.tets.begin() +
                  78);  // the first in cell 13, the middle one: it leaves a pinched cavity
  const Counts c = count_elements(mesh);
  EXPECT_NE(c.boundary_euler, 2);
  EXPECT_FALSE(c.formula_a1);
}

TEST(Counts, TooFewAndTooManyTetsBreakFormulaA3) {
  // V - 3 <= T fails for separate tets; the upper bound fails for a tet and its copy.
  const TetMesh two = join_meshes(make_corner_tet(), translated(make_corner_tet(), {2, 2, 2}));
  EXPECT_FALSE(count_elements(two).formula_a3);
  TetMesh copies = make_corner_tet();
  copies.tets.push_back(copies.tets[0]);
  EXPECT_FALSE(count_elements(copies).formula_a3);
}

TEST(Counts, NonManifoldMeshesAreNotConsistent) {
  const TetMesh edge_only{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}, {0, 0, -1}},
                          {{0, 1, 2, 3}, {0, 1, 4, 5}}};
  const Counts c = count_elements(edge_only);
  EXPECT_EQ(c.components, 2U);
  EXPECT_EQ(c.boundary_components, 1U);
  EXPECT_EQ(c.edges, 11U);
  EXPECT_EQ(c.euler, 1);
  EXPECT_EQ(c.boundary_euler, 6 - 11 + 8);
  EXPECT_FALSE(c.euler_consistent);
}

TEST(Counts, InvalidTetsAreLeftOut) {
  TetMesh mesh = make_corner_tet();
  mesh.points.push_back({7, 7, 7});
  mesh.tets.push_back({0, 1, 2, 50});
  mesh.tets.push_back({3, 3, 4, 1});
  const Counts c = count_elements(mesh);
  EXPECT_EQ(c.vertices, 4U);
  EXPECT_EQ(c.tets, 1U);
  EXPECT_EQ(c.components, 1U);
  EXPECT_EQ(count_elements({}).vertices, 0U);
  EXPECT_FALSE(count_elements({}).formula_a2);
}

}  // namespace
}  // namespace palpate::judge
