#include "core/simplify/refined/cavity.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/mesh/geometry.h"

namespace palpate::simplify {
namespace {

/// Heights above a face of the boundary, over the root of its area: from that of a regular tet's kind down.
constexpr std::array kHeights{0.5, 0.9, 0.3, 0.15};

/// The tet behind a face of tet t.
Index behind(const WorkingMesh& mesh, Index t, const Triangle& face) {
  return neighbour_across(mesh, t, face[0], face[1], face[2]);
}

}  // namespace

bool Cavity::has(Index t) const {
  return std::find(tets_.begin(), tets_.end(), t) != tets_.end();
}

bool Cavity::grow(Index seed, const Vec3& place, const CavityScores& least) {
  tets_.assign(1, seed);
  faces_.clear();
  behind_.clear();
  if (mesh_.is_kept(seed)) return false;
  const ScoreScale scale = scores_.at(place);
  for (std::size_t i = 0; i < tets_.size(); ++i) {
    const Tet tet = mesh_.tets[tets_[i]];
    for (std::size_t corner = 0; corner < tet.size(); ++corner) {
      const Triangle face = face_opposite(tet, corner);
      const Index next = behind(mesh_, tets_[i], face);
      if (next != kNoIndex && has(next)) continue;
      const double score = double{
          score_tet(scale, place, mesh_.points[face[0]], mesh_.points[face[1]], mesh_.points[face[2]])};
      if (score > (next == kNoIndex ? least.on_skin : least.inside)) {
        faces_.push_back(face);
        behind_.push_back(next);
        continue;
      }
      if (next == kNoIndex || mesh_.is_kept(next) || tets_.size() == kMostTets) return false;
      tets_.push_back(next);
    }
  }
  drop_inner_faces();
  return !is_vertex_lost();
}

/// A face that was good enough bounds nothing once the tet behind it has been taken for another face's sake.
void Cavity::drop_inner_faces() {
  std::size_t left = 0;
  for (std::size_t i = 0; i < faces_.size(); ++i) {
    if (behind_[i] == kNoIndex || !has(behind_[i])) faces_[left++] = faces_[i];
  }
  faces_.resize(left);
}

bool Cavity::is_vertex_lost() const {
  const auto is_on_a_face = [&](Index v) {
    return std::any_of(faces_.begin(), faces_.end(), [&](const Triangle& face) {
      return std::find(face.begin(), face.end(), v) != face.end();
    });
  };
  return std::any_of(tets_.begin(), tets_.end(), [&](Index t) {
    const Tet& tet = mesh_.tets[t];
    return !std::all_of(tet.begin(), tet.end(), is_on_a_face);
  });
}

void propose_places(const WorkingMesh& mesh, Index t, std::vector<Vec3>& places) {
  places.clear();
  const Tet& tet = mesh.tets[t];
  for (std::size_t corner = 0; corner < tet.size(); ++corner) {
    const Triangle face = face_opposite(tet, corner);
    const Index next = behind(mesh, t, face);
    if (next != kNoIndex) {
      Vec3 sum;
      for (const Index v : mesh.tets[next]) sum = sum + mesh.points[v];
      places.push_back(0.25 * sum);
      continue;
    }
    const Vec3& a = mesh.points[face[0]];
    const Vec3& b = mesh.points[face[1]];
    const Vec3& c = mesh.points[face[2]];
    const Vec3 outward = cross(b - a, c - a);
    const double twice_area = length(outward);
    if (!(twice_area > 0.0)) continue;
    const Vec3 inward = (-1.0 / twice_area) * outward;
    const Vec3 middle = (1.0 / 3.0) * (a + b + c);
    for (const double height : kHeights)
      places.push_back(middle + (height * std::sqrt(0.5 * twice_area)) * inward);
  }
}

}  // namespace palpate::simplify
