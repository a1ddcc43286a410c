// The floor of the repairs at the end: what is measured in batches, or left out by its score, is what
// single tetrahedra say.
#include "core/simplify/tet_operations/quality_floor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "core/judge/mesh/tet_shape.h"
#include "core/mesh/geometry.h"
#include "core/simplify/quality/batch_quality.h"
#include "core/simplify/quality/quality.h"
#include "core/simplify/refined/repair.h"
#include "core/simplify/tet_operations/flips.h"
#include "core/simplify/tet_operations/star_quality.h"
#include "tests/support/refined_checks.h"

namespace palpate::simplify {
namespace {

using namespace palpate::testing_support;  // NOLINT(google-build-using-namespace)

TEST(QualityFloor, IsWhatTheJudgeMeasuresAndScoresOnlySaveWork) {
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const SizingField no_field;
    const TetMesh input = make_sliver_cube(6, seed);
    TetMesh copy = input;
    WorkingMesh mesh = build_working_mesh(std::move(copy), no_field);
    const double ideal = 1.0 / static_cast<double>(mesh.alive);
    const ScoreRule scores(scale_of_ideal_volume(ideal), no_field);
    Flipper flipper(mesh, scores, {});
    QualityFloor all(ideal);
    all.take(mesh);
    QualityFloor few(ideal);
    for (Index t = 0; t < mesh.tets.size(); ++t) flipper.known_score(t);
    few.take(mesh);
    EXPECT_EQ(few.least_cube(), all.least_cube());
    EXPECT_EQ(few.greatest_cosine(), all.greatest_cosine());
    double least_angle = 4.0;
    double least_cube = 1e300;
    for (const Tet& t : input.tets) {
      const judge::TetShape shape =
          judge::measure_tet(input.points[t[0]], input.points[t[1]], input.points[t[2]], input.points[t[3]]);
      least_angle = std::min(least_angle, shape.min_dihedral);
      const TetFigures figures = measure_tet(kThesisMetric, input.points[t[0]], input.points[t[1]],
                                             input.points[t[2]], input.points[t[3]]);
      const double quality = quality_factor(kThesisMetric, figures, ideal);
      least_cube = std::min(least_cube, quality * quality * quality);
    }
    EXPECT_NEAR(std::acos(all.greatest_cosine()), least_angle, 1e-6);  // acos near 1: root of the rounding
    EXPECT_NEAR(all.least_cube(), least_cube, 1e-12);
  }
}

/// Whether each tet around v, with v at `place`, is above the floor.
bool admits_each(const QualityFloor& floor, const WorkingMesh& mesh, Index v, const Vec3& place) {
  const auto star = mesh.star(v);
  return std::all_of(star.begin(), star.end(), [&](Index t) {
    std::array<Vec3, 4> p;
    for (std::size_t i = 0; i < 4; ++i) {
      const Index w = mesh.tets[t][i];
      p[i] = w == v ? place : mesh.points[w];
    }
    return floor.admits(p[0], p[1], p[2], p[3]);
  });
}

TEST(QualityFloor, AStarIsAdmittedWhereEachOfItsTetsIsWithScoresAndWithout) {
  std::mt19937_64 random(20261130);
  std::uniform_real_distribution<double> uniform(-0.06, 0.06);
  std::size_t admitted = 0;
  std::size_t refused = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    const SizingField no_field;
    WorkingMesh mesh = build_working_mesh(make_sliver_cube(6, seed), no_field);
    const double ideal = 1.0 / static_cast<double>(mesh.alive);
    const ScoreRule rule(scale_of_ideal_volume(ideal, ScoreForm::kMeanRatio), no_field);
    Repairer repairer(mesh, rule, {}, {});
    for (int round = 0; round < 4; ++round) repairer.round(0.1, 0.05, 2);  // else hardly anything is refused
    QualityFloor floor(ideal);
    floor.take(mesh);
    StarQuality star;
    std::vector<float> scores;
    for (Index v = 0; v < mesh.points.size(); ++v) {
      if (!mesh.is_free(v)) continue;
      star.start(rule.far(), mesh.points[v]);
      add_star(mesh, v, kNoIndex, star);
      star.close();
      for (int i = 0; i < 8; ++i) {
        const Vec3 place = mesh.points[v] + Vec3{uniform(random), uniform(random), uniform(random)};
        if (!star.is_positive(place)) continue;
        star.scores(place, scores);
        const bool expected = admits_each(floor, mesh, v, place);
        ++(expected ? admitted : refused);
        EXPECT_EQ(floor.admits_star(mesh, v, place, scores), expected) << v;
        scores.assign(scores.size(), WorkingMesh::kNoScore);
        EXPECT_EQ(floor.admits_star(mesh, v, place, scores), expected) << v;
      }
    }
  }
  EXPECT_GT(admitted, 1000U);
  EXPECT_GT(refused, 1000U);
}

/// A vertex, the last one, with 128 tets around it: an octahedron whose faces are cut in four twice.
TetMesh make_large_star() {
  TetMesh mesh;
  std::vector<std::array<Vec3, 3>> faces;
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      for (const double z : {-1.0, 1.0}) {
        const std::array<Vec3, 3> face{Vec3{x, 0, 0}, Vec3{0, y, 0}, Vec3{0, 0, z}};
        faces.push_back(x * y * z > 0.0 ? face : std::array<Vec3, 3>{face[0], face[2], face[1]});
      }
    }
  }
  const auto middle = [](const Vec3& a, const Vec3& b) {
    const Vec3 sum = a + b;
    return (1.0 / length(sum)) * sum;
  };
  for (int cut = 0; cut < 2; ++cut) {
    std::vector<std::array<Vec3, 3>> finer;
    for (const auto& [a, b, c] : faces) {
      const Vec3 ab = middle(a, b);
      const Vec3 bc = middle(b, c);
      const Vec3 ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    faces = std::move(finer);
  }
  const auto number_of = [&](const Vec3& p) {
    const auto at = std::find_if(mesh.points.begin(), mesh.points.end(),
                                 [&](const Vec3& q) { return length_sq(p - q) < 1e-20; });
    if (at != mesh.points.end()) return static_cast<Index>(at - mesh.points.begin());
    mesh.points.push_back(p);
    return static_cast<Index>(mesh.points.size() - 1);
  };
  for (const auto& [a, b, c] : faces) mesh.tets.push_back({0, number_of(a), number_of(b), number_of(c)});
  mesh.points.push_back({0, 0, 0});
  for (Tet& tet : mesh.tets) tet[0] = static_cast<Index>(mesh.points.size() - 1);
  return mesh;
}

TEST(QualityFloor, AStarLargerThanABatchIsHeldToItsLastTet) {
  const SizingField no_field;
  const WorkingMesh mesh = build_working_mesh(make_large_star(), no_field);
  const auto is_centre = [](const Vec3& p) { return length(p) < 0.5; };
  const auto v = static_cast<Index>(std::find_if(mesh.points.begin(), mesh.points.end(), is_centre) -
                                    mesh.points.begin());
  const auto star = mesh.star(v);
  ASSERT_EQ(star.size(), 128U);
  ASSERT_GT(star.size(), TetBatch::kCapacity);
  QualityFloor floor(1.0);
  floor.take(mesh);
  const std::vector<float> unknown(star.size(), WorkingMesh::kNoScore);
  EXPECT_TRUE(floor.admits_star(mesh, v, mesh.points[v], unknown));
  for (const Index t : star) {
    Vec3 sum{};
    for (const Index w : mesh.tets[t]) {
      if (w != v) sum = sum + mesh.points[w];
    }
    const Vec3 place = 0.01 * sum;  // nearer to this tet's base: lower, and below the floor
    EXPECT_FALSE(admits_each(floor, mesh, v, place));
    EXPECT_FALSE(floor.admits_star(mesh, v, place, unknown));
  }
}

}  // namespace
}  // namespace palpate::simplify
