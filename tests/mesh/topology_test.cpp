#include "core/mesh/topology.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <string>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/mesh/shapes/shapes.h"

namespace palpate {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

TetMesh unit_tet() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {{0, 1, 2, 3}}};
}

/// Tets of four different random vertices: not a mesh of anything, full of non-manifold faces.
TetMesh random_soup(std::uint64_t seed, Index vertices, std::size_t tets) {
  SplitMix64 random(seed);
  TetMesh soup;
  soup.points.resize(vertices);
  while (soup.tets.size() < tets) {
    std::set<Index> chosen;
    while (chosen.size() < 4) chosen.insert(static_cast<Index>(random.below(vertices)));
    Tet tet;
    std::copy(chosen.begin(), chosen.end(), tet.begin());
    shuffle(std::span<Index>(tet), random);
    soup.tets.push_back(tet);
  }
  return soup;
}

struct Named {
  std::string name;
  TetMesh mesh;
};

std::vector<Named> named_shapes() {
  std::vector<Named> all;
  all.push_back({"one tet", unit_tet()});
  for (const int n : {1, 2, 5}) all.push_back({"cube " + std::to_string(n), build_kuhn_cube(n, 0.0, 0)});
  all.push_back({"jittered cube", build_kuhn_cube(6, 0.4, 3)});
  for (const int n : {1, 3}) all.push_back({"bar " + std::to_string(n), build_bar(n)});
  for (const int n : {1, 2, 3}) all.push_back({"BCC bar " + std::to_string(n), build_bcc_bar(n)});
  return all;
}

Triangle sorted(Triangle t) {
  std::sort(t.begin(), t.end());
  return t;
}

/// The tets at each face, by brute force over all triples of vertices of each tet.
std::map<Triangle, std::vector<Index>> faces_by_map(const TetMesh& mesh) {
  std::map<Triangle, std::vector<Index>> faces;
  for (Index t = 0; t < mesh.tets.size(); ++t) {
    for (int skipped = 0; skipped < 4; ++skipped) {
      Triangle face{};
      for (int i = 0, n = 0; i < 4; ++i) {
        if (i != skipped) face[n++] = mesh.tets[t][i];
      }
      faces[sorted(face)].push_back(t);
    }
  }
  return faces;
}

void expect_stars_as_by_brute_force(const TetMesh& mesh) {
  const VertexStars stars = build_vertex_stars(mesh);
  ASSERT_EQ(stars.offsets.size(), mesh.points.size() + 1);
  std::vector<std::vector<Index>> expected(mesh.points.size());
  for (Index t = 0; t < mesh.tets.size(); ++t) {
    for (const Index v : mesh.tets[t]) expected[v].push_back(t);
  }
  for (Index v = 0; v < mesh.points.size(); ++v) {
    const auto star = stars.of(v);
    ASSERT_EQ(std::vector<Index>(star.begin(), star.end()), expected[v]) << "vertex " << v;
  }
}

void expect_edges_as_by_brute_force(const TetMesh& mesh) {
  std::set<Edge> expected;
  for (const Tet& tet : mesh.tets) {
    for (const Index a : tet) {
      for (const Index b : tet) {
        if (a < b) expected.insert({a, b});
      }
    }
  }
  EXPECT_EQ(build_edges(mesh), std::vector<Edge>(expected.begin(), expected.end()));
}

TEST(Topology, StarsAndEdgesAgreeWithBruteForce) {
  for (const Named& shape : named_shapes()) {
    SCOPED_TRACE(shape.name);
    expect_stars_as_by_brute_force(shape.mesh);
    expect_edges_as_by_brute_force(shape.mesh);
  }
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE("soup, seed " + std::to_string(seed));
    const TetMesh soup = random_soup(seed, static_cast<Index>(4 + seed % 40), 1 + seed);
    expect_stars_as_by_brute_force(soup);
    expect_edges_as_by_brute_force(soup);
  }
}

TEST(Topology, FacesAgreeWithBruteForce) {
  for (const Named& shape : named_shapes()) {
    SCOPED_TRACE(shape.name);
    const auto expected = faces_by_map(shape.mesh);
    const std::vector<Face> faces = build_faces(shape.mesh);
    ASSERT_EQ(faces.size(), expected.size());
    auto it = expected.begin();
    for (const Face& face : faces) {
      ASSERT_EQ(face.vertices, it->first);
      ASSERT_EQ(face.tets[0], it->second[0]);
      ASSERT_EQ(face.tets[1], it->second.size() == 2 ? it->second[1] : kNoIndex);
      ++it;
    }
  }
}

TEST(Topology, BoundaryAgreesWithBruteForceAndPointsOutward) {
  for (const Named& shape : named_shapes()) {
    SCOPED_TRACE(shape.name);
    std::map<Triangle, Index> expected;
    for (const auto& [face, tets] : faces_by_map(shape.mesh)) {
      if (tets.size() == 1) expected[face] = tets[0];
    }
    const std::vector<Triangle> boundary = build_boundary(shape.mesh);
    ASSERT_EQ(boundary.size(), expected.size());
    Index former = 0;
    const auto& p = shape.mesh.points;
    for (const Triangle& face : boundary) {
      const auto found = expected.find(sorted(face));
      ASSERT_NE(found, expected.end());
      EXPECT_GE(found->second, former);  // in the order of the tets
      former = found->second;
      const Tet& tet = shape.mesh.tets[found->second];
      const Vec3 centroid = 0.25 * (p[tet[0]] + p[tet[1]] + p[tet[2]] + p[tet[3]]);
      const Vec3 normal = cross(p[face[1]] - p[face[0]], p[face[2]] - p[face[0]]);
      EXPECT_GT(dot(normal, p[face[0]] - centroid), 0.0);
    }
    EXPECT_EQ(build_unpaired_faces(shape.mesh), boundary);
  }
}

TEST(Topology, BoundaryOfAShapeIsAClosedSphere) {
  for (const Named& shape : named_shapes()) {
    SCOPED_TRACE(shape.name);
    std::map<Edge, int> balance;
    std::set<Edge> edges;
    std::set<Index> vertices;
    const std::vector<Triangle> boundary = build_boundary(shape.mesh);
    for (const Triangle& face : boundary) {
      for (std::size_t s = 0; s < 3; ++s) {
        const Index a = face[s];
        const Index b = face[(s + 1) % 3];
        balance[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
        edges.insert({std::min(a, b), std::max(a, b)});
        vertices.insert(a);
      }
    }
    for (const auto& [edge, sum] : balance) EXPECT_EQ(sum, 0) << edge[0] << " " << edge[1];
    EXPECT_EQ(vertices.size() + boundary.size() - edges.size(), 2U);
    const std::vector<std::uint8_t> flags = build_boundary_vertex_flags(shape.mesh);
    ASSERT_EQ(flags.size(), shape.mesh.points.size());
    for (Index v = 0; v < flags.size(); ++v) EXPECT_EQ(flags[v], vertices.count(v));
  }
}

TEST(Topology, EulerCharacteristicOfABallIsOne) {
  for (const Named& shape : named_shapes()) {
    const std::size_t plus = shape.mesh.points.size() + build_faces(shape.mesh).size();
    const std::size_t minus = build_edges(shape.mesh).size() + shape.mesh.tets.size();
    EXPECT_EQ(plus - minus, 1U) << shape.name;
  }
}

TEST(Topology, UnpairedFacesOfAnySoupAgreeWithBruteForce) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const TetMesh soup = random_soup(seed, static_cast<Index>(4 + seed % 20), 1 + seed);
    std::set<Triangle> expected;
    bool is_manifold = true;
    for (const auto& [face, tets] : faces_by_map(soup)) {
      if (tets.size() == 1) expected.insert(face);
      is_manifold = is_manifold && tets.size() <= 2;
    }
    std::set<Triangle> found;
    for (const Triangle& face : build_unpaired_faces(soup)) EXPECT_TRUE(found.insert(sorted(face)).second);
    EXPECT_EQ(found, expected);
    if (is_manifold) {
      EXPECT_EQ(build_faces(soup).size(), faces_by_map(soup).size());
    } else {
      EXPECT_THROW(build_faces(soup), InputError);
      EXPECT_THROW(build_boundary(soup), InputError);
    }
  }
}

template <typename Build>
std::string message_of(const Build& build, const TetMesh& mesh) {
  try {
    build(mesh);
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

TEST(Topology, NamesAFaceWithThreeTets) {
  const TetMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, -1}, {1, 1, 1}},
                     {{0, 1, 2, 3}, {0, 2, 1, 4}, {0, 1, 2, 5}}};
  const std::string expected = "face (1, 2, 3): expected one or two tetrahedra, found 3 (non-manifold)";
  EXPECT_EQ(message_of(build_faces, mesh), expected);
  EXPECT_EQ(message_of([](const TetMesh& m) { build_boundary(m); }, mesh), expected);
  EXPECT_EQ(message_of([](const TetMesh& m) { build_boundary_vertex_flags(m); }, mesh), expected);
  EXPECT_EQ(build_unpaired_faces(mesh).size(), 9U);
}

TEST(Topology, NamesTwoTetsOnTheSameSideOfAFace) {
  const TetMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 2}}, {{0, 1, 2, 3}, {1, 2, 0, 4}}};
  EXPECT_THAT(message_of([](const TetMesh& m) { build_boundary(m); }, mesh),
              AllOf(HasSubstr("face (1, 2, 3)"), HasSubstr("tetrahedra 1 and 2 on the same side")));
  EXPECT_EQ(build_unpaired_faces(mesh).size(), 6U);
  TetMesh duplicate = unit_tet();
  duplicate.tets.push_back(duplicate.tets[0]);
  EXPECT_THAT(message_of([](const TetMesh& m) { build_boundary(m); }, duplicate),
              HasSubstr("on the same side"));
  EXPECT_TRUE(build_unpaired_faces(duplicate).empty());
}

TEST(Topology, AnEmptyMeshHasNothing) {
  const TetMesh empty;
  EXPECT_TRUE(build_edges(empty).empty());
  EXPECT_TRUE(build_faces(empty).empty());
  EXPECT_TRUE(build_boundary(empty).empty());
  EXPECT_EQ(build_vertex_stars(empty).offsets, std::vector<Index>{0});
}

TEST(Topology, RemovesIsolatedVerticesAndKeepsTheOrder) {
  const TetMesh original = build_kuhn_cube(3, 0.2, 1);
  SplitMix64 random(4);
  TetMesh mesh;
  std::vector<Index> moved_to;
  std::size_t added = 0;
  for (const Vec3& p : original.points) {
    for (; random.below(3) == 0; ++added) mesh.points.push_back({9, 9, 9});
    moved_to.push_back(static_cast<Index>(mesh.points.size()));
    mesh.points.push_back(p);
  }
  mesh.points.push_back({9, 9, 9});
  ++added;
  for (Tet tet : original.tets) {
    for (Index& v : tet) v = moved_to[v];
    mesh.tets.push_back(tet);
  }
  EXPECT_EQ(remove_isolated_vertices(mesh), added);
  EXPECT_EQ(mesh, original);
  EXPECT_EQ(remove_isolated_vertices(mesh), 0U);
  EXPECT_EQ(mesh, original);
}

TEST(Topology, ThreadsDoNotShow) {
  const TetMesh mesh = build_kuhn_cube(18, 0.3, 7);  // 35,000 tets and 6,859 vertices
  const VertexStars stars = build_vertex_stars(mesh);
  const std::vector<Triangle> boundary = build_boundary(mesh);
  for (const int threads : {2, 3, 8}) {
    const VertexStars same = build_vertex_stars(mesh, threads);
    EXPECT_EQ(same.offsets, stars.offsets);
    EXPECT_EQ(same.tets, stars.tets);
    EXPECT_EQ(build_boundary(mesh, threads), boundary);
    EXPECT_EQ(build_boundary_vertex_flags(mesh, threads), build_boundary_vertex_flags(mesh));
  }
  TetMesh broken = mesh;
  broken.tets.push_back(broken.tets[20'000]);
  for (const int threads : {1, 2, 3}) EXPECT_THROW(build_boundary(broken, threads), InputError);
}

}  // namespace
}  // namespace palpate
