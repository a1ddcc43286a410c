// A rough body under a guard, for operations on its skin.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/base/random.h"
#include "core/judge/mesh/judge.h"
#include "core/judge/surface/surface.h"
#include "core/mesh/geometry.h"
#include "core/simplify/skin_guard/guarded_boundary.h"
#include "core/simplify/surface/surface_collapse.h"
#include "tests/support/small_meshes.h"

namespace palpate::testing_support {

inline constexpr int kRoughCells = 5;

/// A round block whose vertices, those of the skin too, lie where chance has put them.
inline TetMesh make_rough_block(std::uint64_t seed) {
  TetMesh mesh = make_kuhn_block(kRoughCells, kRoughCells, kRoughCells);
  SplitMix64 random(seed);
  const double half = 0.5 * kRoughCells;
  for (Vec3& p : mesh.points) {
    const Vec3 q = (1.0 / half) * (p - Vec3{half, half, half});
    p = half * (1.0 + 0.15 * (3.0 - length_sq(q))) * q +
        0.15 * Vec3{random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
  }
  return mesh;
}

/// A mesh with the guard over its skin, scored by the mean ratio.
struct GuardedSkin {
  TetMesh input;
  simplify::SizingField field;
  simplify::WorkingMesh mesh;
  simplify::GuardedBoundary boundary;
  simplify::ScoreRule scores;
  simplify::SurfaceReport report;

  GuardedSkin(const TetMesh& given, double bound, double feature_deg = 0.0,
              const simplify::SizingOptions& sizing = {})
      : input(given),
        field(sizing, given),
        mesh(simplify::build_working_mesh(TetMesh(given), field)),
        boundary(mesh, bound, feature_deg),
        scores(simplify::scale_of_ideal_volume(total_volume(given) / static_cast<double>(given.tets.size()),
                                               simplify::ScoreForm::kMeanRatio),
               field) {}

  /// What all tets together are worth, each more than the usual one counting.
  double worth() const {
    double sum = 0.0;
    for (Index t = 0; t < mesh.tets.size(); ++t) {
      if (mesh.is_alive(t)) sum += simplify::worth_of_tet(scores.far(), score(mesh.tets[t]));
    }
    return sum;
  }

  double worst() const {
    double least = 1e300;
    for (Index t = 0; t < mesh.tets.size(); ++t) {
      if (mesh.is_alive(t)) least = std::min(least, score(mesh.tets[t]));
    }
    return least;
  }

  double volume() const { return boundary.volume(mesh); }

  /// Holds the skin against what the guard promises, by the judge's arithmetic, and returns the mesh.
  TetMesh judged(double bound) const {
    TetMesh output = simplify::extract_mesh(simplify::WorkingMesh(mesh));
    EXPECT_TRUE(judge::check_validity(output).is_valid());
    const SurfaceMesh skin = judge::build_boundary(output);
    EXPECT_EQ(judge::count_self_intersections(skin), 0U);
    EXPECT_LE(judge::measure_surface_distance(skin, judge::build_boundary(input)).upper(), bound + 1e-6);
    return output;
  }

 private:
  double score(const Tet& t) const {
    const std::vector<Vec3>& p = mesh.points;
    return double{simplify::score_tet(scores.far(), p[t[0]], p[t[1]], p[t[2]], p[t[3]])};
  }
};

}  // namespace palpate::testing_support
