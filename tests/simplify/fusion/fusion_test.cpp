#include "core/simplify/fusion/fusion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "core/base/random.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/small_meshes.h"

namespace palpate::simplify {
namespace {

TEST(Fusion, PlanFindsMovedAndDeadTets) {
  const TetMesh mesh = build_kuhn_cube(6, 0.2, 1);
  const FusionMesh work = build_fusion_mesh(TetMesh(mesh), StorageOrder::kInput);
  FusionPlan plan;
  std::size_t moved_without_dead_face = 0;
  std::size_t moved_in_all = 0;
  for (Index t = 0; t < mesh.tets.size(); ++t) {
    plan_fusion(work, t, plan);
    std::set<Index> dead;
    std::set<Index> moved;
    for (Index o = 0; o < mesh.tets.size(); ++o) {
      const int shared = testing_support::count_shared(mesh.tets[o], mesh.tets[t]);
      if (shared >= 2) dead.insert(o);
      if (shared == 1) moved.insert(o);
    }
    EXPECT_EQ(std::set<Index>(plan.dead.begin(), plan.dead.end()), dead);
    EXPECT_EQ(plan.dead.size(), dead.size()) << "each once";
    EXPECT_EQ(plan.moved.size(), moved.size()) << "each once";
    for (const MovedTet& m : plan.moved) {
      EXPECT_EQ(moved.count(m.tet), 1U);
      EXPECT_EQ(std::count(mesh.tets[t].begin(), mesh.tets[t].end(), mesh.tets[m.tet][m.corner]), 1);
      ++moved_in_all;
      const bool has_dead_face = std::any_of(dead.begin(), dead.end(), [&](Index d) {
        return testing_support::count_shared(mesh.tets[d], mesh.tets[m.tet]) == 3;
      });
      moved_without_dead_face += static_cast<std::size_t>(!has_dead_face);
    }
  }
  // A walk over face neighbours of the dead tets, as 4.2.3.5 describes it, would miss these (docs/errata.md).
  EXPECT_GT(moved_without_dead_face, moved_in_all / 4);
}

TEST(Fusion, StarsStayExactThroughManyFusions) {
  for (const StorageOrder order : {StorageOrder::kInput, StorageOrder::kSpatial}) {
    const TetMesh mesh = build_kuhn_cube(10, 0.2, 1);
    const auto on_boundary = build_boundary_vertex_flags(mesh);
    FusionMesh work = build_fusion_mesh(TetMesh(mesh), order);
    SplitMix64 random(3);
    FusionPlan plan;
    int fusions = 0;
    for (int attempt = 0; attempt < 20000 && fusions < 150; ++attempt) {
      const Index t = static_cast<Index>(random.below(work.tets.size()));
      if (!work.is_alive(t)) continue;
      const Tet& tet = work.tets[t];
      const bool is_inside = std::none_of(
          tet.begin(), tet.end(), [&](Index v) { return on_boundary[work.origin_of_vertex(v)] != 0; });
      if (!is_inside) continue;
      plan_fusion(work, t, plan);
      apply_fusion(work, plan);
      ++fusions;
    }
    ASSERT_EQ(fusions, 150);
    std::vector<std::set<Index>> stars(work.points.size());
    std::size_t alive = 0;
    for (Index t = 0; t < work.tets.size(); ++t) {
      if (!work.is_alive(t)) continue;
      ++alive;
      for (const Index v : work.tets[t]) stars[v].insert(t);
    }
    EXPECT_EQ(work.alive, alive);
    for (Index v = 0; v < work.points.size(); ++v) {
      const auto row = work.star(v);
      EXPECT_EQ(std::set<Index>(row.begin(), row.end()), stars[v]);
      EXPECT_EQ(row.size(), stars[v].size());
    }
  }
}

TEST(Fusion, RoundTripWithoutFusionKeepsTheMesh) {
  const TetMesh mesh = build_kuhn_cube(5, 0.3, 1);
  for (const StorageOrder order : {StorageOrder::kInput, StorageOrder::kSpatial}) {
    EXPECT_EQ(extract_mesh(build_fusion_mesh(TetMesh(mesh), order)), mesh);
  }
}

TEST(Fusion, SurvivorIsTheSmallestNumberAtTheBarycenter) {
  const TetMesh mesh = build_kuhn_cube(6, 0.1, 1);
  const auto on_boundary = build_boundary_vertex_flags(mesh);
  for (Index t = 0; t < mesh.tets.size(); ++t) {
    const Tet& tet = mesh.tets[t];
    if (std::any_of(tet.begin(), tet.end(), [&](Index v) { return on_boundary[v] != 0; })) continue;
    FusionMesh work = build_fusion_mesh(TetMesh(mesh), StorageOrder::kInput);
    FusionPlan plan;
    plan_fusion(work, t, plan);
    apply_fusion(work, plan);
    const Index survivor = *std::min_element(tet.begin(), tet.end());
    EXPECT_EQ(work.points[survivor], plan.barycenter);
    const TetMesh out = extract_mesh(std::move(work));
    EXPECT_EQ(out.points.size() + 3, mesh.points.size());  // four vertices become one
    break;
  }
}

TEST(Fusion, MeanVolumeIsTotalOverCount) {
  const TetMesh mesh = build_kuhn_cube(3, 0.0, 0);
  EXPECT_NEAR(mean_tet_volume(mesh), 1.0 / 162.0, 1e-16);
  EXPECT_EQ(mean_tet_volume({}), 0.0);
}

}  // namespace
}  // namespace palpate::simplify
