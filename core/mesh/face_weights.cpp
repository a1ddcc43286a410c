#include "core/mesh/face_weights.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace palpate {
namespace {

constexpr double kPull = 0.01;  ///< towards the shares
constexpr int kMostSweeps = 500;
constexpr double kSettled = 1e-10;

bool is_uneven(const FaceCover& cover) {
  return cover.corners[0] != cover.corners[1] || cover.corners[1] != cover.corners[2];
}

/// The faces whose weights are free, and what is missing at their vertices.
struct Border {
  std::vector<std::size_t> faces;
  std::map<Index, double> missing;  ///< R_v less what the weights give, over a third of the mean area
  double mean_area = 0.0;
};

Border find_border(std::span<const FaceCover> covers) {
  Border border;
  for (const FaceCover& cover : covers) {
    if (!is_uneven(cover)) continue;
    for (const Index v : cover.face) border.missing.emplace(v, 0.0);
  }
  for (std::size_t f = 0; f < covers.size(); ++f) {
    const Triangle& t = covers[f].face;
    if (std::none_of(t.begin(), t.end(), [&](Index v) { return border.missing.count(v) != 0; })) continue;
    border.faces.push_back(f);
    border.mean_area += covers[f].area;
  }
  border.mean_area /= static_cast<double>(std::max<std::size_t>(1, border.faces.size()));
  for (const std::size_t f : border.faces) {
    for (std::size_t k = 0; k < 3; ++k) {
      border.missing[covers[f].face[k]] +=
          covers[f].area * (3.0 * covers[f].corners[k] - covers[f].share) / border.mean_area;
    }
  }
  return border;
}

}  // namespace

std::vector<double> match_moments(std::span<const FaceCover> covers) {
  std::vector<double> weight;
  for (const FaceCover& cover : covers) weight.push_back(cover.share);
  Border border = find_border(covers);
  double step = border.faces.empty() ? 0.0 : 1.0;
  for (int sweep = 0; sweep < kMostSweeps && step > kSettled; ++sweep) {
    step = 0.0;
    for (const std::size_t f : border.faces) {
      const double size = covers[f].area / border.mean_area;
      double slope = -kPull * (weight[f] - covers[f].share);
      for (const Index v : covers[f].face) slope += size * border.missing[v];
      const double next = std::max(0.0, weight[f] + slope / (3.0 * size * size + kPull));
      const double change = next - weight[f];
      for (const Index v : covers[f].face) border.missing[v] -= size * change;
      weight[f] = next;
      step = std::max(step, std::fabs(change));
    }
  }
  double wanted = 0.0;
  double given = 0.0;
  for (const std::size_t f : border.faces) {
    wanted += covers[f].area * covers[f].share;
    given += covers[f].area * weight[f];
  }
  if (!(given > 0.0)) return weight;
  for (const std::size_t f : border.faces) weight[f] *= wanted / given;
  return weight;
}

}  // namespace palpate
