#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/judge/mesh/judge.h"
#include "tests/support/small_meshes.h"

namespace palpate::judge {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::SizeIs;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

void expect_counts(const TetMesh& mesh, const Validity& expected) {
  const Validity found = check_validity(mesh);
  EXPECT_EQ(found.index_errors, expected.index_errors);
  EXPECT_EQ(found.non_finite_points, expected.non_finite_points);
  EXPECT_EQ(found.inverted_tets, expected.inverted_tets);
  EXPECT_EQ(found.flat_tets, expected.flat_tets);
  EXPECT_EQ(found.duplicate_tets, expected.duplicate_tets);
  EXPECT_EQ(found.nonmanifold_faces, expected.nonmanifold_faces);
  EXPECT_EQ(found.folded_faces, expected.folded_faces);
  EXPECT_EQ(found.nonmanifold_edges, expected.nonmanifold_edges);
  EXPECT_EQ(found.nonmanifold_vertices, expected.nonmanifold_vertices);
  EXPECT_EQ(found.isolated_vertices, expected.isolated_vertices);
  EXPECT_EQ(found.is_valid(), expected.is_valid());
  EXPECT_EQ(found.findings.empty(), found.is_valid());
  for (const std::string& line : found.findings) EXPECT_EQ(line.find('\n'), std::string::npos);
}

TEST(Validity, AcceptsGoodMeshes) {
  expect_counts(make_corner_tet(), {});
  expect_counts(make_regular_tet(), {});
  expect_counts(make_two_tets(), {});
  expect_counts(make_kuhn_block(4, 3, 2), {});
  expect_counts(make_cube_ring(), {});
  expect_counts(make_hollow_cube(), {});
  expect_counts(join_meshes(make_corner_tet(), translated(make_kuhn_block(2, 2, 2), {9, 9, 9})), {});
  expect_counts({}, {});
}

TEST(Validity, CatchesTetsTurnedOverByAMovedVertex) {
  TetMesh mesh = make_kuhn_block(3, 3, 3);
  mesh.points[block_vertex(3, 3, 1, 1, 1)] = {2.5, 2.5, 2.5};
  const Validity found = check_validity(mesh);
  EXPECT_GT(found.inverted_tets, 0U);
  EXPECT_GT(found.folded_faces, 0U);
  EXPECT_EQ(found.nonmanifold_faces + found.nonmanifold_edges + found.nonmanifold_vertices, 0U);
  EXPECT_FALSE(found.is_valid());
}

TEST(Validity, CatchesATetWithItsVerticesInTheWrongOrder) {
  TetMesh mesh = make_kuhn_block(2, 2, 2);
  std::swap(mesh.tets[7][0], mesh.tets[7][1]);
  Validity expected;
  expected.inverted_tets = 1;  // it lies where it did, so nothing is folded
  expect_counts(mesh, expected);
  EXPECT_THAT(check_validity(mesh).findings, Contains(HasSubstr("tetrahedron 8: inverted")));
}

TEST(Validity, CatchesFlatTets) {
  TetMesh mesh = make_corner_tet();
  mesh.points[3] = {0.3, 0.3, 0.0};
  Validity expected;
  expected.flat_tets = 1;
  expect_counts(mesh, expected);
}

TEST(Validity, CatchesDuplicateTets) {
  TetMesh mesh = make_two_tets();
  mesh.tets.push_back({1, 2, 0, 3});
  Validity expected;
  expected.duplicate_tets = 1;
  expected.nonmanifold_faces = 1;     // the shared face now has three tets
  expected.folded_faces = 3;          // the copy lies on the others
  expected.nonmanifold_edges = 3;     // of the shared face
  expected.nonmanifold_vertices = 3;  // of the shared face
  expect_counts(mesh, expected);
  EXPECT_THAT(check_validity(mesh).findings,
              Contains(HasSubstr("tetrahedron 3: the same vertices as tetrahedron 1")));
}

TEST(Validity, CatchesAFaceWithThreeTets) {
  TetMesh mesh = make_two_tets();
  mesh.points.push_back({1, 1, 1});
  mesh.tets.push_back({0, 1, 2, 5});
  Validity expected;
  expected.nonmanifold_faces = 1;
  expected.nonmanifold_edges = 3;
  expected.nonmanifold_vertices = 3;
  expect_counts(mesh, expected);
  EXPECT_THAT(check_validity(mesh).findings, Contains(HasSubstr("face 1 2 3: 3 tetrahedra")));
}

TEST(Validity, CatchesAFoldedFace) {
  TetMesh mesh = make_two_tets();
  mesh.points[4] = {1, 1, 1};
  std::swap(mesh.tets[1][1], mesh.tets[1][2]);  // positive, and on the same side as the other tet
  Validity expected;
  expected.folded_faces = 1;
  expect_counts(mesh, expected);
  EXPECT_THAT(check_validity(mesh).findings, Contains(HasSubstr("face 1 2 3: folded, tetrahedra 1 2")));
}

TEST(Validity, CatchesTwoTetsThatShareOnlyAnEdge) {
  const TetMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, -1, 0}, {0, 0, -1}},
                     {{0, 1, 2, 3}, {0, 1, 4, 5}}};
  Validity expected;
  expected.nonmanifold_edges = 1;
  expected.nonmanifold_vertices = 2;
  expect_counts(mesh, expected);
  EXPECT_THAT(check_validity(mesh).findings, Contains(HasSubstr("edge 1 2:")));
}

TEST(Validity, CatchesTwoTetsThatShareOnlyAVertex) {
  const TetMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}},
                     {{0, 1, 2, 3}, {0, 5, 4, 6}}};
  Validity expected;
  expected.nonmanifold_vertices = 1;
  expect_counts(mesh, expected);
  EXPECT_THAT(check_validity(mesh).findings, Contains(HasSubstr("vertex 1: its link")));
}

TEST(Validity, CatchesIsolatedVertices) {
  TetMesh mesh = make_two_tets();
  mesh.points.push_back({5, 5, 5});
  Validity expected;
  expected.isolated_vertices = 1;
  expect_counts(mesh, expected);
  expect_counts({{{0, 0, 0}}, {}}, expected);
}

TEST(Validity, CatchesIndexErrorsAndChecksTheRest) {
  TetMesh mesh = make_two_tets();
  mesh.tets.push_back({0, 1, 2, 99});
  mesh.tets.push_back({0, 1, 1, 3});
  mesh.tets.push_back({kNoIndex, kNoIndex, kNoIndex, kNoIndex});
  Validity expected;
  expected.index_errors = 3;
  expect_counts(mesh, expected);
  EXPECT_THAT(check_validity(mesh).findings,
              Contains(HasSubstr("tetrahedron 3: vertex 100 does not exist, the mesh has 5")));
  expect_counts({{}, {{0, 1, 2, 3}, {0, 0, 0, 0}, {1, 2, 3, 4}}}, expected);
}

TEST(Validity, CatchesPointsThatAreNotFinite) {
  TetMesh mesh = make_kuhn_block(3, 3, 3);
  mesh.points[block_vertex(3, 3, 1, 1, 1)].y = kNan;
  mesh.points[block_vertex(3, 3, 2, 2, 2)].z = -std::numeric_limits<double>::infinity();
  Validity expected;
  expected.non_finite_points = 2;
  expect_counts(mesh, expected);
}

/// The tets that join each triangle to one more vertex, numbered `apex`. Points lie on a curve in general
/// position; only the topology matters.
TetMesh make_cone(const std::vector<Triangle>& triangles, Index apex) {
  TetMesh mesh;
  for (Index v = 0; v <= apex; ++v) {
    const double t = v + 1.0;
    mesh.points.push_back({t, t * t, t * t * t});
  }
  for (const Triangle& t : triangles) mesh.tets.push_back({t[0], t[1], t[2], apex});
  return mesh;
}

/// The torus of seven vertices (Moebius 1861).
std::vector<Triangle> make_seven_vertex_torus() {
  std::vector<Triangle> torus;
  for (Index i = 0; i < 7; ++i) {
    torus.push_back({i, (i + 1) % 7, (i + 3) % 7});
    torus.push_back({i, (i + 3) % 7, (i + 2) % 7});
  }
  return torus;
}

TEST(Validity, CatchesAVertexWhoseLinkIsASphereAndATorus) {
  // The Euler characteristics add up to a sphere's: only connectedness tells.
  std::vector<Triangle> surfaces = make_seven_vertex_torus();
  for (const Triangle& t : {Triangle{7, 8, 9}, Triangle{7, 10, 8}, Triangle{7, 9, 10}, Triangle{8, 10, 9}}) {
    surfaces.push_back(t);
  }
  const Validity found = check_validity(make_cone(surfaces, 11));
  EXPECT_EQ(found.nonmanifold_edges, 0U);
  EXPECT_EQ(found.nonmanifold_vertices, 1U);
}

TEST(Validity, CatchesAVertexWhoseLinkIsATorus) {
  // Its cone has manifold faces and edges, and a bad apex.
  const std::vector<Triangle> torus = make_seven_vertex_torus();
  const Validity found = check_validity(make_cone(torus, 7));
  EXPECT_EQ(found.nonmanifold_faces, 0U);
  EXPECT_EQ(found.nonmanifold_edges, 0U);
  EXPECT_EQ(found.nonmanifold_vertices, 1U);
  EXPECT_THAT(found.findings, Contains(HasSubstr("vertex 8: its link")));
}

TEST(Validity, CatchesVerticesWhoseLinksAreProjectivePlanesAndMoebiusBands) {
  // Closed with Euler characteristic 1, and open with 0: neither may pass for a disc.
  const std::vector<Triangle> projective_plane{{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 5}, {0, 5, 1},
                                               {1, 2, 4}, {2, 3, 5}, {3, 4, 1}, {4, 5, 2}, {5, 1, 3}};
  EXPECT_EQ(check_validity(make_cone(projective_plane, 6)).nonmanifold_vertices, 1U);
  EXPECT_EQ(check_validity(make_cone(projective_plane, 6)).nonmanifold_edges, 0U);
  std::vector<Triangle> band;
  for (Index i = 0; i < 5; ++i) band.push_back({i, (i + 1) % 5, (i + 2) % 5});
  EXPECT_EQ(check_validity(make_cone(band, 5)).nonmanifold_vertices, 1U);
}

TEST(Validity, CatchesAVertexWhoseLinkIsAnAnnulus) {
  std::vector<Triangle> annulus;
  for (Index i = 0; i < 4; ++i) {
    annulus.push_back({i, (i + 1) % 4, i + 4});
    annulus.push_back({(i + 1) % 4, (i + 1) % 4 + 4, i + 4});
  }
  const Validity found = check_validity(make_cone(annulus, 8));
  EXPECT_EQ(found.nonmanifold_edges, 0U);
  EXPECT_EQ(found.nonmanifold_vertices, 1U);
}

TEST(Validity, AVertexOfManyTetsIsNoTrouble) {
  // A double fan: 20,000 tets around one axis, closed into a ring.
  constexpr Index kSpokes = 10000;
  TetMesh mesh;
  mesh.points = {{0, 0, 1}, {0, 0, -1}};
  for (Index i = 0; i < kSpokes; ++i) {
    const double angle = 2.0 * 3.14159265358979323846 * i / kSpokes;
    mesh.points.push_back({std::cos(angle), std::sin(angle), 0});
  }
  for (Index i = 0; i < kSpokes; ++i) mesh.tets.push_back({0, 1, 2 + (i + 1) % kSpokes, 2 + i});
  expect_counts(mesh, {});
  mesh.tets.pop_back();  // an open fan
  expect_counts(mesh, {});
  mesh.tets.erase(mesh.tets.begin() + kSpokes / 2);  // two fans at one axis
  Validity expected;
  expected.nonmanifold_edges = 1;
  expected.nonmanifold_vertices = 2;
  expect_counts(mesh, expected);
}

TEST(Validity, NamesTheFirstThreeOfAKind) {
  TetMesh mesh = make_kuhn_block(2, 2, 2);
  for (std::size_t i = 10; i < 20; ++i) std::swap(mesh.tets[i][2], mesh.tets[i][3]);
  const Validity found = check_validity(mesh);
  EXPECT_EQ(found.inverted_tets, 10U);
  EXPECT_THAT(found.findings, SizeIs(3));
  EXPECT_THAT(found.findings, Contains(HasSubstr("tetrahedron 11:")));
}

}  // namespace
}  // namespace palpate::judge
