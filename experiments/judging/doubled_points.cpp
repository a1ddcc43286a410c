#include "experiments/judging/doubled_points.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <tuple>
#include <vector>

namespace palpate::experiments {
namespace {

bool stand_all_alone(const TetMesh& mesh) {
  if (mesh.tets.size() < 2) return false;
  std::vector<bool> used(mesh.points.size(), false);
  for (const Tet& t : mesh.tets) {
    for (const Index v : t) {
      if (v >= used.size() || used[v]) return false;
      used[v] = true;
    }
  }
  return true;
}

}  // namespace

std::string doubled_points_complaint(const TetMesh& mesh) {
  if (!stand_all_alone(mesh)) return "";
  const auto& p = mesh.points;
  std::vector<Index> order(p.size());
  for (Index v = 0; v < order.size(); ++v) order[v] = v;
  std::sort(order.begin(), order.end(), [&](Index a, Index b) {
    return std::tie(p[a].x, p[a].y, p[a].z, a) < std::tie(p[b].x, p[b].y, p[b].z, b);
  });
  std::size_t doubled = 0;
  std::array<Index, 2> first{kNoIndex, kNoIndex};
  for (std::size_t i = 1; i < order.size(); ++i) {
    if (!(p[order[i]] == p[order[i - 1]])) continue;
    ++doubled;
    if (order[i - 1] < first[0]) first = {order[i - 1], order[i]};
  }
  if (doubled == 0) return "";
  std::array<char, 256> text{};
  std::snprintf(
      text.data(), text.size(),
      "%zu that all stand alone: %zu of %zu points are doubled, as vertices %u and %u at (%.6g, %.6g, "
      "%.6g); join them",
      mesh.tets.size(), doubled, p.size(), first[0] + 1, first[1] + 1, p[first[0]].x, p[first[0]].y,
      p[first[0]].z);
  return text.data();
}

}  // namespace palpate::experiments
