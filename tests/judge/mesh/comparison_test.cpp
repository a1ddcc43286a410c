#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/random.h"
#include "core/judge/mesh/judge.h"
#include "tests/support/small_meshes.h"

namespace palpate::judge {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

constexpr double kLastBits = 4 * std::numeric_limits<double>::epsilon();

/// The same mesh with its vertices and tets in another order, and its tets turned.
TetMesh renumbered(const TetMesh& mesh, std::uint64_t seed) {
  SplitMix64 random(seed);
  std::vector<Index> new_number(mesh.points.size());
  for (std::size_t i = 0; i < new_number.size(); ++i) new_number[i] = static_cast<Index>(i);
  shuffle(std::span<Index>(new_number), random);
  TetMesh result;
  result.points.resize(mesh.points.size());
  for (std::size_t i = 0; i < mesh.points.size(); ++i) result.points[new_number[i]] = mesh.points[i];
  for (const Tet& t : mesh.tets) {
    result.tets.push_back({new_number[t[1]], new_number[t[2]], new_number[t[0]], new_number[t[3]]});
  }
  shuffle(std::span<Tet>(result.tets), random);
  return result;
}

TEST(Comparison, AMeshIsUnchangedFromItself) {
  const TetMesh mesh = make_kuhn_block(4, 3, 2);
  for (const TetMesh& same : {mesh, renumbered(mesh, 5)}) {
    const Comparison c = compare_with_input(same, mesh);
    EXPECT_EQ(c.boundary_changed_faces, 0U);
    EXPECT_LE(c.volume_drift_relative, kLastBits);
    EXPECT_TRUE(c.euler_unchanged);
    EXPECT_TRUE(c.components_unchanged);
  }
}

TEST(Comparison, MovedInteriorVerticesChangeNothing) {
  const TetMesh input = make_kuhn_block(3, 3, 3);
  TetMesh output = input;
  for (const Index v : interior_vertices_of_block(3, 3, 3)) output.points[v].x += 0.1;
  const Comparison c = compare_with_input(output, input);
  EXPECT_EQ(c.boundary_changed_faces, 0U);
  EXPECT_LE(c.volume_drift_relative, kLastBits);
}

TEST(Comparison, CatchesABoundaryVertexMovedByOneUnitInTheLastPlace) {
  const TetMesh input = make_kuhn_block(3, 3, 3);
  TetMesh output = input;
  Vec3& corner = output.points[block_vertex(3, 3, 3, 3, 3)];
  corner.z = std::nextafter(corner.z, 4.0);
  const Comparison c = compare_with_input(output, input);
  EXPECT_EQ(c.boundary_missing_faces, 6U);  // the ends of the diagonal: two triangles a square
  EXPECT_EQ(c.boundary_new_faces, 6U);
  EXPECT_EQ(c.boundary_changed_faces, 12U);
}

TEST(Comparison, MinusZeroIsNotZero) {
  const TetMesh input = make_corner_tet();
  TetMesh output = input;
  output.points[1].y = -0.0;
  EXPECT_EQ(compare_with_input(output, input).boundary_changed_faces, 6U);
}

TEST(Comparison, CatchesARemovedTet) {
  const TetMesh input = make_kuhn_block(3, 3, 3);
  TetMesh output = input;
  output.tets.erase(output.tets.begin() + 78);  // the first in cell 13, the middle one
  Comparison c = compare_with_input(output, input);
  EXPECT_EQ(c.boundary_missing_faces, 0U);
  EXPECT_EQ(c.boundary_new_faces, 4U);
  EXPECT_NEAR(c.volume_drift_relative, 1.0 / (6 * 27), kLastBits);
  EXPECT_FALSE(c.euler_unchanged);
  output = input;
  output.tets.erase(output.tets.begin());  // at a corner: one skin face goes, three inner ones come out
  c = compare_with_input(output, input);
  EXPECT_EQ(c.boundary_missing_faces, 1U);
  EXPECT_EQ(c.boundary_new_faces, 3U);
}

TEST(Comparison, CatchesAnotherDiagonalAndAFaceTurnedInsideOut) {
  TetMesh input = make_two_tets();
  TetMesh output = input;
  std::swap(output.tets[0][0], output.tets[0][1]);
  const Comparison c = compare_with_input(output, input);
  EXPECT_EQ(c.boundary_missing_faces, 3U);
  EXPECT_EQ(c.boundary_new_faces, 3U);
}

TEST(Comparison, CatchesVolumeDrift) {
  const TetMesh input = make_kuhn_block(2, 2, 2);
  TetMesh output = input;
  for (Vec3& p : output.points) p.z *= 1.0 + 1e-9;
  EXPECT_NEAR(compare_with_input(output, input).volume_drift_relative, 1e-9, 1e-15);
  for (Vec3& p : output.points) p.z = 0.0;
  EXPECT_EQ(compare_with_input(output, input).volume_drift_relative, 1.0);
  EXPECT_EQ(compare_with_input(input, output).volume_drift_relative, 1.0);
  EXPECT_EQ(compare_with_input(output, output).volume_drift_relative, 0.0);
}

TEST(Comparison, CatchesTopologyThatChanged) {
  const TetMesh block = make_kuhn_block(3, 3, 1);
  Comparison c = compare_with_input(make_cube_ring(), block);
  EXPECT_FALSE(c.euler_unchanged);
  EXPECT_TRUE(c.components_unchanged);
  c = compare_with_input(join_meshes(block, translated(make_corner_tet(), {9, 9, 9})), block);
  EXPECT_FALSE(c.euler_unchanged);
  EXPECT_FALSE(c.components_unchanged);
  c = compare_with_input(make_hollow_cube(), make_kuhn_block(3, 3, 3));
  EXPECT_FALSE(c.euler_unchanged);
  EXPECT_FALSE(c.components_unchanged);
}

TEST(Comparison, SurvivesBrokenMeshesAndExtremeCoordinates) {
  TetMesh broken = make_two_tets();
  broken.tets.push_back({0, 1, 2, 77});
  EXPECT_EQ(compare_with_input(broken, make_two_tets()).boundary_changed_faces, 0U);
  broken.points[0].x = std::numeric_limits<double>::quiet_NaN();
  const Comparison c = compare_with_input(broken, make_two_tets());
  EXPECT_GT(c.boundary_changed_faces, 0U);
  EXPECT_EQ(c.volume_drift_relative, 1.0);
  for (const double scale : {1e-300, 1e-9, 1e9, 1e300}) {
    TetMesh input = make_kuhn_block(3, 3, 3);
    for (Vec3& p : input.points) p = scale * p;
    TetMesh output = input;
    output.tets.pop_back();
    EXPECT_NEAR(compare_with_input(output, input).volume_drift_relative, 1.0 / 162.0, kLastBits) << scale;
  }
  EXPECT_EQ(compare_with_input({}, {}).boundary_changed_faces, 0U);
}

}  // namespace
}  // namespace palpate::judge
