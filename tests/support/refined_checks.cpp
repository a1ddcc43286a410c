#include "tests/support/refined_checks.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/base/random.h"
#include "core/judge/mesh/judge.h"
#include "core/mesh/orientation.h"
#include "core/mesh/shapes/shapes.h"
#include "core/mesh/topology.h"

namespace palpate::testing_support {

TetMesh copy_of(const simplify::WorkingMesh& mesh) {
  simplify::WorkingMesh copy = mesh;
  return simplify::extract_mesh(std::move(copy));
}

void expect_consistent(const simplify::WorkingMesh& mesh) {
  std::size_t alive = 0;
  std::vector<std::size_t> degree(mesh.points.size(), 0);
  for (Index t = 0; t < mesh.tets.size(); ++t) {
    if (!mesh.is_alive(t)) continue;
    ++alive;
    for (const Index v : mesh.tets[t]) {
      ++degree[v];
      const auto star = mesh.star(v);
      ASSERT_EQ(std::count(star.begin(), star.end(), t), 1) << "tet " << t << " vertex " << v;
    }
  }
  EXPECT_EQ(mesh.alive, alive);
  for (Index v = 0; v < mesh.points.size(); ++v) {
    ASSERT_EQ(mesh.star(v).size(), degree[v]) << v;
    ASSERT_LE(mesh.star_begin[v] + mesh.star_capacity[v], mesh.rows_of(v).size()) << v;
  }
}

void expect_valid_with_boundary_of(const TetMesh& mesh, const TetMesh& input) {
  const judge::Validity validity = judge::check_validity(mesh);
  EXPECT_TRUE(validity.is_valid()) << (validity.findings.empty() ? "" : validity.findings.front());
  const judge::Comparison comparison = judge::compare_with_input(mesh, input);
  EXPECT_EQ(comparison.boundary_changed_faces, 0U);
  EXPECT_TRUE(comparison.euler_unchanged);
  EXPECT_TRUE(comparison.components_unchanged);
}

TetMesh make_sliver_cube(int cells, std::uint64_t seed) {
  TetMesh mesh = build_kuhn_cube(cells, 0.3, seed);
  const VertexStars stars = build_vertex_stars(mesh);
  const std::vector<std::uint8_t> on_boundary = build_boundary_vertex_flags(mesh);
  SplitMix64 random(seed);
  for (Index v = 0; v < mesh.points.size(); ++v) {
    if (on_boundary[v] != 0 || random.uniform() < 0.5) continue;
    const Tet& near = mesh.tets[stars.of(v)[random.below(stars.of(v).size())]];
    const Vec3 from = mesh.points[v];
    const Vec3 to = mesh.points[near[random.below(4)]];
    const auto all_positive = [&] {
      const auto star = stars.of(v);
      return std::all_of(star.begin(), star.end(), [&](Index t) {
        const Tet& x = mesh.tets[t];
        return orientation(mesh.points[x[0]], mesh.points[x[1]], mesh.points[x[2]], mesh.points[x[3]]) > 0;
      });
    };
    double share = 0.999;
    for (int trial = 0; trial < 40; ++trial, share *= 0.9) {
      mesh.points[v] = from + share * (to - from);
      if (all_positive()) break;
      mesh.points[v] = from;
    }
  }
  return mesh;
}

}  // namespace palpate::testing_support
