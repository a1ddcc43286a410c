#include "reference/tetfusion/sequential.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "core/mesh/orientation.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"

namespace palpate::reference {
namespace {

SequentialOptions published() {
  SequentialOptions options;
  options.common.skip_touched = true;
  return options;
}

std::size_t count_inverted(const TetMesh& mesh) {
  return static_cast<std::size_t>(std::count_if(mesh.tets.begin(), mesh.tets.end(), [&](const Tet& t) {
    return orientation(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]) <= 0;
  }));
}

/// One fusion of the definition, by brute force: the first interior tet, away from the boundary, that flips
/// nothing.
Index find_first_suitable(const TetMesh& mesh, bool from_the_end) {
  const auto on_boundary = build_boundary_vertex_flags(mesh);
  const auto count_shared = [](const Tet& a, const Tet& b) {
    return std::count_if(a.begin(), a.end(), [&](Index v) { return std::count(b.begin(), b.end(), v); });
  };
  const auto is_boundary_tet = [&](const Tet& t) {
    return std::any_of(t.begin(), t.end(), [&](Index v) { return on_boundary[v] != 0; });
  };
  for (Index n = 0; n < mesh.tets.size(); ++n) {
    const Index t = from_the_end ? static_cast<Index>(mesh.tets.size()) - 1 - n : n;
    const Tet& tet = mesh.tets[t];
    const Vec3 center =
        0.25 * (mesh.points[tet[0]] + mesh.points[tet[1]] + mesh.points[tet[2]] + mesh.points[tet[3]]);
    bool suitable = true;
    for (const Tet& other : mesh.tets) {
      const auto shared = count_shared(other, tet);
      if (shared > 0 && is_boundary_tet(other)) suitable = false;
      if (shared != 1) continue;
      std::array<Vec3, 4> p;
      for (std::size_t i = 0; i < 4; ++i) {
        p[i] = std::count(tet.begin(), tet.end(), other[i]) > 0 ? center : mesh.points[other[i]];
      }
      if (orientation(p[0], p[1], p[2], p[3]) <= 0) suitable = false;
    }
    if (suitable) return t;
  }
  return kNoIndex;
}

TEST(TetFusion, FirstFusionIsTheFirstSuitableTetOfTheScan) {
  const TetMesh input = build_kuhn_cube(7, 0.4, 3);
  for (const bool reverse : {false, true}) {
    SequentialOptions options = published();
    options.order = reverse ? ScanOrder::kReverse : ScanOrder::kIndex;
    options.common.drop = 0.0;
    options.common.stop.fusions = 1;
    TetMesh output = input;
    simplify_sequentially(output, options);
    const Index expected = find_first_suitable(input, reverse);
    ASSERT_NE(expected, kNoIndex);
    const Tet& tet = input.tets[expected];
    const Vec3 center =
        0.25 * (input.points[tet[0]] + input.points[tet[1]] + input.points[tet[2]] + input.points[tet[3]]);
    EXPECT_EQ(std::count(output.points.begin(), output.points.end(), center), 1);
    EXPECT_EQ(output.points.size() + 3, input.points.size());
  }
}

TEST(TetFusion, EveryVariantLeavesAValidMeshWithTheSameBoundary) {
  const TetMesh input = build_kuhn_cube(12, 0.4, 5);
  const std::size_t boundary = build_boundary(input).size();
  for (const ScanOrder order : {ScanOrder::kIndex, ScanOrder::kReverse, ScanOrder::kRandom}) {
    for (const bool many : {false, true}) {
      for (const bool skip : {false, true}) {
        SequentialOptions options;
        options.order = order;
        options.seed = 4;
        options.many_passes = many;
        options.common.skip_touched = skip;
        TetMesh output = input;
        const auto report = simplify_sequentially(output, options);
        EXPECT_GT(report.fusions, 20U);
        EXPECT_EQ(count_inverted(output), 0U);
        EXPECT_EQ(build_boundary(output).size(), boundary);
        EXPECT_EQ(report.tets_out, output.tets.size());
        EXPECT_EQ(report.vertices_in - report.vertices_out, 3 * report.fusions);
      }
    }
  }
}

TEST(TetFusion, ManyPassesGoOnUntilNothingFuses) {
  const TetMesh input = build_kuhn_cube(12, 0.3, 5);
  SequentialOptions options = published();
  TetMesh one = input;
  simplify_sequentially(one, options);
  options.many_passes = true;
  TetMesh many = input;
  simplify_sequentially(many, options);
  EXPECT_LT(many.tets.size(), one.tets.size());
}

TEST(TetFusion, TheBanKeepsTouchedTetsOutOfOnePass) {
  const TetMesh input = build_kuhn_cube(12, 0.3, 5);
  TetMesh with_ban = input;
  const auto banned = simplify_sequentially(with_ban, published());
  EXPECT_GT(banned.rejected.touched, 0U);
  TetMesh without = input;
  const auto free = simplify_sequentially(without, {});
  EXPECT_EQ(free.rejected.touched, 0U);
  EXPECT_NE(with_ban, without);
}

TEST(TetFusion, SeedsDecideTheRandomOrderAlone) {
  const TetMesh input = build_kuhn_cube(10, 0.3, 5);
  SequentialOptions options = published();
  options.order = ScanOrder::kRandom;
  options.common.stop.fusions = 60;
  std::set<std::vector<Tet>> different;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    options.seed = seed;
    TetMesh a = input;
    TetMesh b = input;
    simplify_sequentially(a, options);
    options.common.storage = simplify::StorageOrder::kInput;
    simplify_sequentially(b, options);
    EXPECT_EQ(a, b);
    different.insert(a.tets);
  }
  EXPECT_EQ(different.size(), 5U);
}

TEST(TetFusion, WithoutChecksTetsAreInverted) {
  const TetMesh input = build_kuhn_cube(12, 0.4, 5);
  SequentialOptions options = published();
  options.common.checks = {false, false};
  options.common.stop.fusions = 87;
  TetMesh output = input;
  simplify_sequentially(output, options);
  EXPECT_GT(count_inverted(output), 0U);
}

TEST(TetFusion, StopsAtTheSameCountAsAskedFor) {
  const TetMesh input = build_kuhn_cube(12, 0.3, 5);
  SequentialOptions options = published();
  options.common.stop.tets = input.tets.size() - 1000;
  TetMesh output = input;
  const auto report = simplify_sequentially(output, options);
  EXPECT_EQ(report.stop, "tets");
  EXPECT_LE(output.tets.size(), *options.common.stop.tets);
}

}  // namespace
}  // namespace palpate::reference
