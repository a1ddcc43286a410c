// Room for a vertex: what gives way to it, what stays, and what it helps.
#include "core/simplify/refined/cavity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>

#include "core/base/random.h"
#include "core/judge/mesh/judge.h"
#include "core/mesh/geometry.h"
#include "core/simplify/refined/repair.h"
#include "core/simplify/tet_operations/flips.h"
#include "tests/support/refined_checks.h"
#include "tests/support/small_meshes.h"

namespace palpate::simplify {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

ScoreScale scale_of(const TetMesh& mesh) {
  return scale_of_ideal_volume(total_volume(mesh) / static_cast<double>(mesh.tets.size()),
                               ScoreForm::kMeanRatio);
}

WorkingMesh build(TetMesh mesh, const SizingField& field) {
  return build_working_mesh(std::move(mesh), field);
}

/// A block of n x n x n Kuhn cells with a flat tet on every second square of its top: all its corners lie on
/// the skin, and so do two of its faces, which meet at almost 180 degrees.
TetMesh make_block_with_flat_tets(int n, double lift) {
  TetMesh mesh = make_kuhn_block(n, n, n);
  std::map<std::array<int, 2>, Index> on_top;
  for (Index v = 0; v < mesh.points.size(); ++v) {
    Vec3& p = mesh.points[v];
    if (p.z != static_cast<double>(n)) continue;
    const std::array<int, 2> place{static_cast<int>(p.x), static_cast<int>(p.y)};
    on_top[place] = v;
    if ((place[0] + place[1]) % 2 != 0) p.z += lift;
  }
  for (int i = 0; i < n; ++i) {
    for (int j = i % 2; j < n; j += 2) {
      mesh.tets.push_back(
          {on_top.at({i, j}), on_top.at({i + 1, j}), on_top.at({i + 1, j + 1}), on_top.at({i, j + 1})});
    }
  }
  return mesh;
}

TetMesh sorted(TetMesh mesh) {
  for (Tet& tet : mesh.tets) std::sort(tet.begin(), tet.end());
  std::sort(mesh.tets.begin(), mesh.tets.end());
  return mesh;
}

double volume_of(const WorkingMesh& mesh, const Tet& t) {
  return signed_volume(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]);
}

TEST(Cavity, GivesWayToTetsOfTheSameVolumeAndComesBack) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const TetMesh input = seed == 4 ? make_block_with_flat_tets(4, 0.01) : make_sliver_cube(5, seed);
    const SizingField no_field;
    WorkingMesh mesh = build(input, no_field);
    const ScoreRule scores(scale_of(input), no_field);
    Flipper flipper(mesh, scores, {});
    Cavity cavity(mesh, scores);
    SplitMix64 random(seed);
    std::vector<Vec3> places;
    std::size_t made = 0;
    std::size_t largest = 0;
    for (int i = 0; i < 2000 && made < 200; ++i) {
      const auto t = static_cast<Index>(random.below(mesh.tets.size()));
      if (!mesh.is_alive(t)) continue;
      propose_places(mesh, t, places);
      const Vec3 place = places[random.below(places.size())];
      const double least = std::array{0.005, 1e-4, 0.0}[random.below(3)];
      if (!cavity.grow(t, place, {least, 0.0})) continue;
      double given_up = 0.0;
      for (const Index old : cavity.tets()) given_up += volume_of(mesh, mesh.tets[old]);
      const TetMesh before = copy_of(mesh);
      if (flipper.insert_vertex(cavity.tets(), place, cavity.faces()) == kNoIndex) continue;
      ++made;
      largest = std::max(largest, cavity.tets().size());
      double filled = 0.0;
      for (const Index fresh : flipper.added()) filled += volume_of(mesh, mesh.tets[fresh]);
      EXPECT_NEAR(filled, given_up, 1e-12 * given_up);
      ASSERT_NO_FATAL_FAILURE(expect_valid_with_boundary_of(copy_of(mesh), input));
      if (random.below(2) == 0) continue;
      flipper.undo();
      ASSERT_EQ(sorted(copy_of(mesh)), sorted(before));
    }
    EXPECT_GT(made, 100U) << seed;
    EXPECT_GT(largest, 3U) << seed;
    expect_consistent(mesh);
  }
}

TEST(Cavity, EndsAtTheSkinAtWhatIsKeptAndAtItsLargestSize) {
  const TetMesh input = make_kuhn_block(6, 6, 6);
  const SizingField no_field;
  WorkingMesh mesh = build(input, no_field);
  const ScoreRule scores(scale_of(input), no_field);
  Cavity cavity(mesh, scores);
  const auto middle_of = [&](Index t) {
    Vec3 sum;
    for (const Index v : mesh.tets[t]) sum = sum + mesh.points[v];
    return 0.25 * sum;
  };
  const auto tet_with = [&](bool on_skin) {
    for (Index t = 0; t < mesh.tets.size(); ++t) {
      const Tet& tet = mesh.tets[t];
      const auto count =
          std::count_if(tet.begin(), tet.end(), [&](Index v) { return mesh.is_on_boundary(v); });
      if (on_skin ? count >= 3 : count == 0) return t;
    }
    return kNoIndex;
  };
  const Index inside = tet_with(false);
  ASSERT_NE(inside, kNoIndex);
  EXPECT_TRUE(cavity.grow(inside, middle_of(inside), {0.0, 0.0}));
  EXPECT_EQ(cavity.tets().size(), 1U);
  EXPECT_EQ(cavity.faces().size(), 4U);
  EXPECT_FALSE(cavity.grow(inside, middle_of(inside), {1.0, 0.0})) << "no tet scores 1, so it never ends";
  EXPECT_FALSE(cavity.grow(inside, {100.0, 0.0, 0.0}, {0.0, 0.0})) << "a place outside";
  const Index outside = tet_with(true);
  ASSERT_NE(outside, kNoIndex);
  EXPECT_FALSE(cavity.grow(outside, middle_of(outside), {0.0, 1.0})) << "a face of the skin has to stay";

  SizingOptions sizing;
  sizing.keep.push_back({.kind = KeptRegion::Kind::kSphere, .center = middle_of(inside), .radius = 0.01});
  const SizingField field(sizing, input);
  const WorkingMesh kept = build(input, field);
  const ScoreRule kept_scores(scale_of(input), field);
  Cavity in_kept(kept, kept_scores);
  const Vec3 place = middle_of(inside);
  for (Index t = 0; t < kept.tets.size(); ++t)
    EXPECT_FALSE(in_kept.grow(t, place, {0.0, 0.0}) && kept.is_kept(t));
}

/// The tets whose least dihedral angle is below a degree.
std::uint64_t count_flat(const WorkingMesh& mesh) {
  std::uint64_t flat = 0;
  const TetMesh left = copy_of(mesh);
  for (const Tet& t : left.tets) {
    TetMesh one;
    for (const Index v : t) one.points.push_back(left.points[v]);
    one.tets = {{0, 1, 2, 3}};
    if (judge::measure_quality(one).min_dihedral_deg < 1.0) ++flat;
  }
  return flat;
}

TEST(Repairer, AVertexIsInsertedForAFlatTetOnTheSkinThatNothingElseHelps) {
  const TetMesh input = make_block_with_flat_tets(5, 0.005);
  for (const bool insertions : {false, true}) {
    const SizingField no_field;
    WorkingMesh mesh = build(input, no_field);
    const ScoreRule scores(scale_of(input), no_field);
    RepairTools tools;
    tools.edge_removal = tools.face_removal = tools.edge_splits = tools.compound_moves = false;
    tools.insertions = insertions;
    Repairer repairer(mesh, scores, {}, tools);
    ASSERT_EQ(count_flat(mesh), 13U);  // of 25 squares
    for (int round = 0; round < 3; ++round) repairer.round(0.1, 0.1, 2);
    EXPECT_EQ(count_flat(mesh), insertions ? 0U : 13U);
    EXPECT_EQ(repairer.counts().insertions, insertions ? 13U : 0U);
    expect_valid_with_boundary_of(copy_of(mesh), input);
    expect_consistent(mesh);
  }
}

}  // namespace
}  // namespace palpate::simplify
