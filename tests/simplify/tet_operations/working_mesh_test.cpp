#include "core/simplify/tet_operations/working_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/mesh/orientation.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"
#include "core/simplify/fusion/fusion.h"
#include "tests/support/refined_checks.h"
#include "tests/support/small_meshes.h"

namespace palpate::simplify {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

std::multiset<std::multiset<Index>> vertex_sets(const std::vector<Tet>& tets) {
  std::multiset<std::multiset<Index>> sets;
  for (const Tet& t : tets) sets.emplace(t.begin(), t.end());
  return sets;
}

WorkingMesh make_working(const TetMesh& mesh, const SizingField& field = {}) {
  TetMesh copy = mesh;
  return build_working_mesh(std::move(copy), field);
}

TEST(WorkingMesh, GivesTheSameMeshBack) {
  for (const TetMesh& mesh : {build_kuhn_cube(4, 0.3, 1), build_bcc_bar(3), make_cube_ring(),
                              make_hollow_cube(), make_corner_tet()}) {
    const WorkingMesh working = make_working(mesh);
    expect_consistent(working);
    const TetMesh back = copy_of(working);
    EXPECT_EQ(back.points, mesh.points);
    EXPECT_EQ(vertex_sets(back.tets), vertex_sets(mesh.tets));
    expect_valid_with_boundary_of(back, mesh);
  }
}

TEST(WorkingMesh, FlagsTheBoundaryAsTopologyDoes) {
  for (const TetMesh& mesh : {build_kuhn_cube(5, 0.4, 2), make_hollow_cube(), make_two_tets()}) {
    const WorkingMesh working = make_working(mesh);
    const std::vector<std::uint8_t> flags = build_boundary_vertex_flags(mesh);
    for (Index v = 0; v < working.points.size(); ++v) {
      EXPECT_EQ(working.is_on_boundary(v), flags[working.vertex_origin[v]] != 0);
    }
  }
}

TEST(WorkingMesh, RefusesFacesWithThreeTetsOrTwoOnOneSide) {
  TetMesh three = make_two_tets();
  const Tet first = three.tets[0];
  three.points.push_back({0.3, 0.3, 5.0});
  Tet third = first;  // the apex replaced by another on the same side
  for (Index& v : third) {
    const auto& other = three.tets[1];
    if (std::find(other.begin(), other.end(), v) == other.end()) v = 5;
  }
  three.tets.push_back(third);
  EXPECT_THROW(make_working(three), InputError);
  three.tets.erase(three.tets.begin() + 1);  // the first and the third: two on one side
  remove_isolated_vertices(three);
  EXPECT_THROW(make_working(three), InputError);
}

TEST(WorkingMesh, BoundaryFacesOfEachVertex) {
  const TetMesh mesh = build_kuhn_cube(3, 0.2, 7);
  const WorkingMesh working = make_working(mesh);
  std::set<Triangle> expected;
  for (Triangle f : build_boundary(copy_of(working))) {
    std::rotate(f.begin(), std::min_element(f.begin(), f.end()), f.end());
    expected.insert(f);
  }
  std::set<Triangle> found;
  std::vector<Triangle> faces;
  for (Index v = 0; v < working.points.size(); ++v) {
    collect_boundary_faces(working, v, faces);
    EXPECT_EQ(faces.empty(), !working.is_on_boundary(v));
    for (Triangle f : faces) {
      EXPECT_EQ(f[0], v);
      for (Index& w : f) w = working.vertex_origin[w];
      std::rotate(f.begin(), std::min_element(f.begin(), f.end()), f.end());
      found.insert(f);
    }
  }
  EXPECT_EQ(found, expected);
}

TEST(WorkingMesh, EdgeStarsAndNeighboursAsInTheTets) {
  const WorkingMesh working = make_working(build_kuhn_cube(3, 0.3, 5));
  std::vector<Index> star;
  for (Index t = 0; t < working.tets.size(); ++t) {
    const Tet& tet = working.tets[t];
    collect_edge_star(working, tet[0], tet[2], star);
    std::set<Index> expected;
    std::set<Index> across;
    for (Index s = 0; s < working.tets.size(); ++s) {
      const unsigned a = corners_that_are(working.tets[s], tet[0]);
      const unsigned c = corners_that_are(working.tets[s], tet[2]);
      if (a != 0 && c != 0) expected.insert(s);
      if (s != t && a != 0 && c != 0 && corners_that_are(working.tets[s], tet[3]) != 0) across.insert(s);
    }
    EXPECT_EQ(std::set<Index>(star.begin(), star.end()), expected);
    const Index other = neighbour_across(working, t, tet[0], tet[2], tet[3]);
    EXPECT_EQ(across, other == kNoIndex ? std::set<Index>{} : std::set<Index>{other});
  }
}

/// Whether all tets around `gone`, without those that have `kept`, stay positive with it at `kept`.
bool stays_positive(const WorkingMesh& mesh, Index gone, Index kept) {
  const auto star = mesh.star(gone);
  return std::all_of(star.begin(), star.end(), [&](Index t) {
    Tet tet = mesh.tets[t];
    if (corners_that_are(tet, kept) != 0U) return true;
    *std::find(tet.begin(), tet.end(), gone) = kept;
    return orientation(mesh.points[tet[0]], mesh.points[tet[1]], mesh.points[tet[2]], mesh.points[tet[3]]) >
           0;
  });
}

TEST(WorkingMesh, ValidAfterEachOfManyCollapses) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    SCOPED_TRACE(seed);
    const TetMesh input = build_kuhn_cube(6, 0.35, seed);
    WorkingMesh mesh = make_working(input);
    SplitMix64 random(seed);
    VertexMarks marks;
    std::size_t collapses = 0;
    for (int i = 0; i < 3000; ++i) {
      const auto t = static_cast<Index>(random.below(mesh.tets.size()));
      if (!mesh.is_alive(t)) continue;
      const Index gone = mesh.tets[t][random.below(4)];
      const Index kept = mesh.tets[t][random.below(4)];
      if (gone == kept || !mesh.is_free(gone) || !stays_positive(mesh, gone, kept) ||
          !meets_link_condition(mesh, gone, kept, marks)) {
        continue;
      }
      const std::size_t before = mesh.alive;
      const std::size_t died = apply_collapse(mesh, gone, kept, mesh.points[kept]);
      EXPECT_EQ(mesh.alive + died, before);
      EXPECT_FALSE(mesh.is_vertex_alive(gone));
      ++collapses;
      expect_valid_with_boundary_of(copy_of(mesh), input);
    }
    EXPECT_GT(collapses, 60U);
    expect_consistent(mesh);
  }
}

/// The working vertex with a number in the input.
Index vertex_of(const WorkingMesh& mesh, Index origin) {
  const auto at = std::find(mesh.vertex_origin.begin(), mesh.vertex_origin.end(), origin);
  return static_cast<Index>(at - mesh.vertex_origin.begin());
}

bool allows_collapse(const TetMesh& mesh, Index gone, Index kept) {
  const WorkingMesh working = make_working(mesh);
  VertexMarks marks;
  return meets_link_condition(working, vertex_of(working, gone), vertex_of(working, kept), marks);
}

TEST(WorkingMesh, LinkConditionRefusesACommonNeighbourThatNoTetJoins) {
  // Three tets around edge (0, 1), ring 2 3 4: vertex 4 is next to 2 and to 3, but (2, 3, 4) is no face.
  TetMesh mesh;
  mesh.points = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {-0.5, 0.8, 0}, {-0.5, -0.8, 0}};
  mesh.tets = {{0, 1, 3, 2}, {0, 1, 4, 3}, {0, 1, 2, 4}};
  EXPECT_FALSE(allows_collapse(mesh, 2, 3));
  EXPECT_TRUE(allows_collapse(mesh, 0, 1));
  mesh.tets.pop_back();
  EXPECT_TRUE(allows_collapse(mesh, 3, 2));
}

TEST(WorkingMesh, LinkConditionRefusesACommonEdgeThatNoTetJoins) {
  // Four tets around edge (0, 1), ring 2 3 4 5. Edge (2, 4) lies in the link of 0 by tet (0, 2, 4, 6) and in
  // that of 1 by tet (1, 4, 2, 7). Only how the tets hang together matters here.
  TetMesh mesh;
  mesh.points = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}, {0, 3, 3}, {0, 3, -3}};
  mesh.tets = {{0, 1, 3, 2}, {0, 1, 4, 3}, {0, 1, 5, 4}, {0, 1, 2, 5}, {0, 2, 4, 6}};
  EXPECT_TRUE(allows_collapse(mesh, 0, 1));
  EXPECT_TRUE(allows_collapse(mesh, 1, 0));
  mesh.tets.push_back({1, 4, 2, 7});
  EXPECT_FALSE(allows_collapse(mesh, 0, 1));
  EXPECT_FALSE(allows_collapse(mesh, 1, 0));
}

TEST(WorkingMesh, SlotsOfTetsAndVerticesAreUsedAgain) {
  const TetMesh input = build_kuhn_cube(4, 0.0, 0);
  WorkingMesh mesh = make_working(input);
  const std::size_t slots = mesh.tets.size();
  std::vector<Index> added;
  Index slot = 0;
  for (int i = 0; i < 5; ++i) {
    const Tet old = mesh.tets[slot];
    const std::array<Index, 1> gone{slot};
    const Vec3 middle =
        0.25 * (mesh.points[old[0]] + mesh.points[old[1]] + mesh.points[old[2]] + mesh.points[old[3]]);
    const Index v = add_vertex(mesh, middle);
    const std::array<Tet, 4> fresh{Tet{v, old[1], old[2], old[3]}, Tet{old[0], v, old[2], old[3]},
                                   Tet{old[0], old[1], v, old[3]}, Tet{old[0], old[1], old[2], v}};
    apply_flip(mesh, gone, fresh, added);
    expect_valid_with_boundary_of(copy_of(mesh), input);
    EXPECT_EQ(copy_of(mesh).points.back(), middle);
    const std::vector<Index> four = added;
    const std::array<Tet, 1> again{old};
    apply_flip(mesh, four, again, added);
    remove_vertex(mesh, v);
    ASSERT_EQ(vertex_sets(copy_of(mesh).tets), vertex_sets(input.tets));
    slot = added[0];
  }
  EXPECT_LE(mesh.tets.size(), slots + 3);
  EXPECT_EQ(mesh.points.size(), input.points.size() + 1);
  expect_consistent(mesh);
}

TEST(WorkingMesh, KeptTetsAreFlaggedAndNeverDie) {
  const TetMesh input = build_kuhn_cube(5, 0.2, 4);
  SizingOptions options;
  options.keep.push_back({.kind = KeptRegion::Kind::kSphere, .center = {0.5, 0.5, 0.5}, .radius = 0.2});
  const SizingField field(options, input);
  WorkingMesh mesh = make_working(input, field);
  const std::vector<std::uint8_t> kept = build_kept_tets(field, input);
  EXPECT_EQ(std::count(mesh.kept_tets.begin(), mesh.kept_tets.end(), 1),
            std::count(kept.begin(), kept.end(), 1));
  std::vector<Index> added;
  for (Index t = 0; t < mesh.tets.size(); ++t) {
    if (!mesh.is_kept(t)) continue;
    for (const Index v : mesh.tets[t]) EXPECT_FALSE(mesh.is_free(v));
    const std::array<Index, 1> old{t};
    const std::array<Tet, 1> fresh{mesh.tets[t]};
    EXPECT_THROW(apply_flip(mesh, old, fresh, added), ContractError);
    break;
  }
}

}  // namespace
}  // namespace palpate::simplify
