#include "experiments/judging/patch_carrier.h"

#include <algorithm>
#include <cmath>

#include "core/mesh/geometry.h"
#include "core/mesh/topology.h"

namespace palpate::experiments {
namespace {

constexpr double kLeastWeight = 1e-6;  // a face with less is left out

std::vector<judge::Corners> corners_of(const TetMesh& mesh, const std::vector<Triangle>& faces) {
  std::vector<judge::Corners> corners;
  corners.reserve(faces.size());
  for (const Triangle& t : faces)
    corners.push_back({mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]});
  return corners;
}

/// A box around a face, wider by its longest side: farther than that its nearest place is not.
judge::Box box_around(const Vec3& a, const Vec3& b, const Vec3& c) {
  judge::Box box;
  box.add({a, b, c});
  const double side = std::sqrt(std::max({length_sq(b - a), length_sq(c - b), length_sq(a - c)}));
  const Vec3 margin{side, side, side};
  box.low = box.low - margin;
  box.high = box.high + margin;
  return box;
}

}  // namespace

PatchCarrier::Places PatchCarrier::places_of(const TetMesh& mesh, const Triangle& face) {
  Places places{};
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3& p = mesh.points[face[k]];
    places[k] = {p.x, p.y, p.z};
  }
  std::sort(places.begin(), places.end());
  return places;
}

PatchCarrier::PatchCarrier(const TetMesh& whole)
    : whole_(whole), skin_(build_boundary(whole)), tree_(corners_of(whole, skin_)) {
  for (std::size_t f = 0; f < skin_.size(); ++f) number_.emplace(places_of(whole, skin_[f]), f);
}

FaceCover PatchCarrier::cover_of(const TetMesh& mesh, const Triangle& face,
                                 const std::vector<double>& density, const judge::Box& patch_box,
                                 Index& hint) const {
  const Vec3& a = mesh.points[face[0]];
  const Vec3& b = mesh.points[face[1]];
  const Vec3& c = mesh.points[face[2]];
  FaceCover cover{face, 0.5 * length(cross(b - a, c - a)), 0.0, {}};
  const auto same = number_.find(places_of(mesh, face));
  if (same != number_.end()) {
    cover.share = density[same->second];
    cover.corners.fill(cover.share / 3.0);
    return cover;
  }
  if (!box_around(a, b, c).meets(patch_box)) return cover;
  double least = 1.0;
  double most = 0.0;
  for_each_part([&](double u, double v) {
    hint = tree_.nearest(a + u * (b - a) + v * (c - a), hint).triangle;
    const double here = density[hint] / kPartsOfFace;
    least = std::min(least, density[hint]);
    most = std::max(most, density[hint]);
    cover.share += here;
    cover.corners[1] += u * here;
    cover.corners[2] += v * here;
  });
  cover.corners[0] = cover.share - cover.corners[1] - cover.corners[2];
  if (least == most) {
    cover.share = most;
    cover.corners.fill(most / 3.0);
  }
  return cover;
}

FacePatch PatchCarrier::carry(const std::function<double(const Triangle&)>& share, const TetMesh& mesh,
                              std::span<const Triangle> boundary, double& scale) const {
  std::vector<double> density;
  judge::Box patch_box;
  for (const Triangle& t : skin_) {
    density.push_back(share(t));
    if (density.back() > 0.0) patch_box.add({whole_.points[t[0]], whole_.points[t[1]], whole_.points[t[2]]});
  }
  std::vector<FaceCover> covers;
  Index hint = kNoIndex;
  for (const Triangle& face : boundary) {
    const FaceCover cover = cover_of(mesh, face, density, patch_box, hint);
    if (cover.share > 0.0) covers.push_back(cover);
  }
  const std::vector<double> weights = match_moments(covers);
  scale = 1.0;
  for (const double weight : weights) scale = std::max(scale, weight);
  FacePatch patch;
  for (std::size_t f = 0; f < covers.size(); ++f) {
    if (weights[f] <= kLeastWeight) continue;
    patch.faces.push_back(covers[f].face);
    patch.weight.push_back(std::min(1.0, weights[f] / scale));
  }
  return patch;
}

}  // namespace palpate::experiments
