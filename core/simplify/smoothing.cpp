#include "core/simplify/smoothing.h"

#include <algorithm>
#include <array>
#include <bit>

#include "core/simplify/fusion.h"

namespace palpate::simplify {

void add_star_to_cone(const WorkingMesh& mesh, Index v, Cone& cone) {
  for (const Index t : mesh.star(v)) {
    const Tet& tet = mesh.tets[t];
    const auto& face = kTetFaces[static_cast<std::size_t>(std::countr_zero(corners_that_are(tet, v)))];
    cone.add(mesh.points[tet[static_cast<std::size_t>(face[0])]],
             mesh.points[tet[static_cast<std::size_t>(face[1])]],
             mesh.points[tet[static_cast<std::size_t>(face[2])]]);
  }
}

bool Smoother::is_better(const ConeFigures& now, const ConeFigures& then) const {
  return then.worst > 0.0 && then.sum > now.sum && then.worst >= 0.5 * now.worst;
}

bool Smoother::smooth(Index v, int steps) {
  cone_.clear();
  add_star_to_cone(mesh_, v, cone_);
  Vec3 p = mesh_.points[v];
  ConeFigures now = cone_.evaluate(scale_, p, -1e300);
  bool moved = false;
  const Vec3 center = cone_.volume_centroid(p);
  const auto try_at = [&](const Vec3& q) {
    const ConeFigures then = cone_.evaluate(scale_, q, 0.5 * now.worst);
    if (!is_better(now, then)) return false;
    if (then.worst < kSafeScore && !cone_.is_positive_exactly(q)) return false;
    p = q;
    now = then;
    moved = true;
    return true;
  };
  for (const double step : {1.0, 0.5, 0.2}) {
    if (try_at(p + step * (center - p))) break;
  }
  double h = 0.15 * length(mesh_.points[mesh_.tets[mesh_.star(v)[0]][0]] -
                           mesh_.points[mesh_.tets[mesh_.star(v)[0]][1]]);
  for (int i = 0; i < steps; ++i) {
    // forward differences of the sum, then steps along the gradient
    const double d = 0.01 * h;
    const double gx = cone_.evaluate(scale_, {p.x + d, p.y, p.z}, -1e300).sum - now.sum;
    const double gy = cone_.evaluate(scale_, {p.x, p.y + d, p.z}, -1e300).sum - now.sum;
    const double gz = cone_.evaluate(scale_, {p.x, p.y, p.z + d}, -1e300).sum - now.sum;
    const Vec3 g{gx, gy, gz};
    const double norm = length(g);
    if (!(norm > 0.0)) break;
    bool better = false;
    for (int k = 0; k < 3 && !better; ++k) {
      better = try_at(p + (h / norm) * g);
      if (!better) h *= 0.4;
    }
    if (!better) break;
  }
  cone_.scores(scale_, p, scores_);
  mesh_.points[v] = p;
  std::size_t i = 0;
  for (const Index t : mesh_.star(v)) mesh_.score[t] = scores_[i++];
  return moved;
}

std::uint64_t Smoother::sweep(int steps) {
  std::uint64_t moved = 0;
  for (Index v = 0; v < mesh_.points.size(); ++v) {
    if (mesh_.is_vertex_alive(v) && mesh_.is_free(v) && smooth(v, steps)) ++moved;
  }
  return moved;
}

}  // namespace palpate::simplify
