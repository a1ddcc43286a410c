#include "experiments/meshes/skin_jitter.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/random.h"

namespace palpate::experiments {
namespace {

constexpr double kShareOfEdge = 0.1;
constexpr double kLeastCosine = 0.5;

Vec3 area_vector(const std::vector<Vec3>& points, const Triangle& t) {
  return 0.5 * cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]]);
}

/// A vertex's triangles.
std::vector<std::vector<Index>> triangles_around(const SurfaceMesh& skin) {
  std::vector<std::vector<Index>> around(skin.points.size());
  for (Index t = 0; t < skin.triangles.size(); ++t) {
    for (const Index v : skin.triangles[t]) around[v].push_back(t);
  }
  return around;
}

}  // namespace

void jitter_skin(std::uint64_t seed, SurfaceMesh& skin) {
  if (seed == 0) return;
  SplitMix64 random(seed);
  const auto around = triangles_around(skin);
  for (Index v = 0; v < skin.points.size(); ++v) {
    const Vec3 home = skin.points[v];
    Vec3 normal;
    double shortest_sq = HUGE_VAL;
    for (const Index t : around[v]) {
      normal = normal + area_vector(skin.points, skin.triangles[t]);
      for (const Index w : skin.triangles[t]) {
        if (w != v) shortest_sq = std::min(shortest_sq, length_sq(skin.points[w] - home));
      }
    }
    Vec3 move;
    move.x = 2.0 * random.uniform() - 1.0;
    move.y = 2.0 * random.uniform() - 1.0;
    move.z = 2.0 * random.uniform() - 1.0;
    const double size_sq = length_sq(normal);
    if (!(size_sq > 0.0)) continue;
    move = move - (dot(move, normal) / size_sq) * normal;
    move = (kShareOfEdge / std::max(1.0, length(move)) * std::sqrt(shortest_sq)) * move;
    for (const Index t : around[v]) {
      const Vec3 before = area_vector(skin.points, skin.triangles[t]);
      skin.points[v] = home + move;
      const Vec3 after = area_vector(skin.points, skin.triangles[t]);
      skin.points[v] = home;
      if (dot(before, after) < kLeastCosine * length(before) * length(after)) move = {};
    }
    skin.points[v] = home + move;
  }
}

}  // namespace palpate::experiments
