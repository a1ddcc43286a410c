#include "core/simplify/tet_operations/smoothing.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace palpate::simplify {
namespace {

/// Steps towards the centroid of the star, the longest first.
constexpr std::array kCentroidSteps{1.0, 0.5, 0.2};

}  // namespace

bool Smoother::try_place(const Vec3& place) {
  const double least = least_of_worst_ * figures_.worst;
  const StarFigures there = star_.evaluate(place, least);
  if (!(there.worst > 0.0) || there.worst < least || !(there.sum > figures_.sum)) return false;
  place_ = place;
  figures_ = there;
  scores_.assign(star_.last_scores().begin(), star_.last_scores().end());
  return true;
}

void Smoother::climb(int steps) {
  const Tet& tet = mesh_.tets[star_tet_];
  const double edge = length(mesh_.points[tet[0]] - mesh_.points[tet[1]]);
  climb_gains(
      star_, edge, steps, place_, figures_, [](const Vec3& gradient) { return gradient; },
      [this](const Vec3& place) { return try_place(place); });
}

double Smoother::smooth(Index v, int steps) {
  const Vec3 before = mesh_.points[v];
  star_.start(rule_.at(before), before);
  add_star(mesh_, v, kNoIndex, star_);
  star_.close();
  star_tet_ = mesh_.star(v)[0];
  place_ = before;
  figures_ = star_.evaluate(before);
  const double sum_before = figures_.sum;
  const Vec3 centroid = star_.volume_centroid(before);
  for (const double step : kCentroidSteps) {
    if (try_place(before + step * (centroid - before))) break;
  }
  climb(steps);
  if (!(figures_.sum > sum_before) || !star_.is_positive(place_)) return 0.0;
  if (floor_ != nullptr && !floor_->admits_star(mesh_, v, place_, scores_)) return 0.0;
  mesh_.points[v] = place_;
  std::size_t i = 0;
  for (const Index t : mesh_.star(v)) mesh_.score[t] = std::max(0.0F, scores_[i++]);
  return figures_.sum - sum_before;
}

std::uint64_t Smoother::sweep(int steps) {
  std::uint64_t moved = 0;
  for (Index v = 0; v < mesh_.points.size(); ++v) {
    if (mesh_.is_vertex_alive(v) && mesh_.is_free(v) && smooth(v, steps) > 0.0) ++moved;
  }
  return moved;
}

}  // namespace palpate::simplify
