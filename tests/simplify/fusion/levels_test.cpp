#include "core/simplify/fusion/levels.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/mesh/shapes/shapes.h"
#include "tests/support/small_meshes.h"

namespace palpate::simplify {
namespace {

/// The definition, by all pairs.
std::vector<std::uint16_t> levels_by_definition(const TetMesh& mesh, int least_shared) {
  const auto on_boundary = build_boundary_vertex_flags(mesh);
  std::vector<std::uint16_t> level(mesh.tets.size(), kNoLevel);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (const Index v : mesh.tets[t]) {
      if (on_boundary[v] != 0) level[t] = 0;
    }
  }
  bool changed = true;
  for (std::uint16_t n = 0; changed; ++n) {
    changed = false;
    for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
      if (level[t] != kNoLevel) continue;
      for (std::size_t o = 0; o < mesh.tets.size(); ++o) {
        if (level[o] == n && testing_support::count_shared(mesh.tets[t], mesh.tets[o]) >= least_shared)
          level[t] = n + 1;
      }
      changed = changed || level[t] != kNoLevel;
    }
  }
  return level;
}

TEST(Levels, FollowTheDefinitionForEachAdjacency) {
  for (const TetMesh& mesh : {build_kuhn_cube(6, 0.2, 1), build_bcc_bar(3)}) {
    const auto on_boundary = build_boundary_vertex_flags(mesh);
    const FusionMesh work = build_fusion_mesh(TetMesh(mesh), StorageOrder::kInput);
    EXPECT_EQ(build_levels(work, on_boundary, LevelAdjacency::kVertex), levels_by_definition(mesh, 1));
    EXPECT_EQ(build_levels(work, on_boundary, LevelAdjacency::kEdge), levels_by_definition(mesh, 2));
    EXPECT_EQ(build_levels(work, on_boundary, LevelAdjacency::kFace), levels_by_definition(mesh, 3));
  }
}

TEST(Levels, SpatialStorageHasTheSameLevels) {
  const TetMesh mesh = build_kuhn_cube(7, 0.3, 1);
  const auto on_boundary = build_boundary_vertex_flags(mesh);
  const FusionMesh plain = build_fusion_mesh(TetMesh(mesh), StorageOrder::kInput);
  const FusionMesh spatial = build_fusion_mesh(TetMesh(mesh), StorageOrder::kSpatial);
  const auto expected = build_levels(plain, on_boundary, LevelAdjacency::kVertex);
  const auto found = build_levels(spatial, on_boundary, LevelAdjacency::kVertex);
  for (Index t = 0; t < mesh.tets.size(); ++t) EXPECT_EQ(found[t], expected[spatial.origin_of_tet(t)]);
}

TEST(Levels, WithVertexAdjacencyLevelOneIsTheBoundaryNeighbourhood) {
  // So check 2 of the thesis is the same as starting from level 2 (docs/errata.md).
  const TetMesh mesh = build_kuhn_cube(7, 0.2, 1);
  const auto on_boundary = build_boundary_vertex_flags(mesh);
  const FusionMesh work = build_fusion_mesh(TetMesh(mesh), StorageOrder::kInput);
  const auto level = build_levels(work, on_boundary, LevelAdjacency::kVertex);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    bool touches_boundary_tet = false;
    for (std::size_t o = 0; o < mesh.tets.size(); ++o) {
      touches_boundary_tet = touches_boundary_tet ||
                             (level[o] == 0 && testing_support::count_shared(mesh.tets[t], mesh.tets[o]) > 0);
    }
    EXPECT_EQ(touches_boundary_tet, level[t] <= 1);
  }
}

TEST(Levels, CountsAddUp) {
  const std::vector<std::uint16_t> level{0, 2, 1, 0, kNoLevel, 2};
  EXPECT_EQ(count_levels(level), (std::vector<std::uint64_t>{2, 1, 2}));
}

}  // namespace
}  // namespace palpate::simplify
