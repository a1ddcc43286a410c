#include "core/simplify/tet_operations/smoothing.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/base/random.h"
#include "core/mesh/geometry.h"
#include "core/mesh/shapes/shapes.h"
#include "tests/support/refined_checks.h"

namespace palpate::simplify {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

ScoreScale scale_of(const TetMesh& mesh) {
  return scale_of_ideal_volume(total_volume(mesh) / static_cast<double>(mesh.tets.size()));
}

/// The tets between the centre of an icosahedron, vertex 0, and its 20 faces.
TetMesh make_icosahedron() {
  const SurfaceMesh sphere = build_geodesic_sphere(1);
  TetMesh mesh;
  mesh.points.push_back({});
  mesh.points.insert(mesh.points.end(), sphere.points.begin(), sphere.points.end());
  for (const Triangle& f : sphere.triangles) mesh.tets.push_back({0, f[0] + 1, f[1] + 1, f[2] + 1});
  return mesh;
}

TEST(Smoother, BringsTheCentreOfAnIcosahedronBack) {
  SplitMix64 random(2);
  for (int trial = 0; trial < 20; ++trial) {
    TetMesh mesh = make_icosahedron();
    const SizingField no_field;
    const ScoreRule rule(scale_of(mesh), no_field);
    const Vec3 away = 0.6 * Vec3{random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
    mesh.points[0] = away;
    WorkingMesh working = build_working_mesh(std::move(mesh), no_field);
    Smoother smoother(working, rule);
    const auto center =
        static_cast<Index>(std::find(working.vertex_origin.begin(), working.vertex_origin.end(), 0U) -
                           working.vertex_origin.begin());
    ASSERT_TRUE(working.is_free(center));
    EXPECT_GT(smoother.smooth(center, 8), 0.0);
    // By symmetry the best place is the middle; the last steps are about 0.15 * 0.4^3 of an edge of 1.
    EXPECT_LT(length(working.points[center]), 0.03) << trial;
  }
}

TEST(Smoother, RaisesTheSumOfGainsAndKeepsTheMeshValid) {
  for (const std::uint64_t seed : {1U, 2U}) {
    const TetMesh input = make_sliver_cube(6, seed);
    const SizingField no_field;
    const ScoreRule rule(scale_of(input), no_field);
    TetMesh copy = input;
    WorkingMesh mesh = build_working_mesh(std::move(copy), no_field);
    const auto total = [&] {
      double sum = 0.0;
      for (const Tet& t : mesh.tets) {
        sum += gain_of_score(rule.far(), score_tet(rule.far(), mesh.points[t[0]], mesh.points[t[1]],
                                                   mesh.points[t[2]], mesh.points[t[3]]));
      }
      return sum;
    };
    Smoother smoother(mesh, rule);
    double before = total();
    for (int sweep = 0; sweep < 3; ++sweep) {
      EXPECT_GT(smoother.sweep(2), 0U);
      EXPECT_GT(total(), before);
      before = total();
      expect_valid_with_boundary_of(copy_of(mesh), input);
    }
    double growth = 0.0;
    for (Index v = 0; v < mesh.points.size(); ++v) {
      if (mesh.is_free(v)) growth += smoother.smooth(v, 2);
    }
    // Single precision: about 1e-6 of each of a few thousand gains of 2 to 10.
    EXPECT_NEAR(total() - before, growth, 0.02);
  }
}

TEST(Smoother, FillsTheScoresOfTheStarThatItMoved) {
  const TetMesh input = build_kuhn_cube(4, 0.4, 3);
  const SizingField no_field;
  const ScoreRule rule(scale_of(input), no_field);
  TetMesh copy = input;
  WorkingMesh mesh = build_working_mesh(std::move(copy), no_field);
  Smoother smoother(mesh, rule);
  std::size_t moved = 0;
  for (Index v = 0; v < mesh.points.size(); ++v) {
    if (!mesh.is_free(v) || !(smoother.smooth(v, 2) > 0.0)) continue;
    ++moved;
    for (const Index t : mesh.star(v)) {
      const Tet& x = mesh.tets[t];
      EXPECT_NEAR(
          mesh.score[t],
          score_tet(rule.far(), mesh.points[x[0]], mesh.points[x[1]], mesh.points[x[2]], mesh.points[x[3]]),
          1e-5);
    }
  }
  EXPECT_GT(moved, 5U);
}

}  // namespace
}  // namespace palpate::simplify
