#include "core/simplify/skin_guard/skin_faces.h"

#include <algorithm>

#include "core/base/error.h"

namespace palpate::simplify {
namespace {

TriangleCorners corners_of(const WorkingMesh& mesh, const Triangle& t) {
  return {mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]};
}

}  // namespace

void erase_one(std::vector<Index>& items, Index item) {
  const auto found = std::find(items.begin(), items.end(), item);
  require(found != items.end(), "guarded boundary: a face is not where it should be");
  *found = items.back();
  items.pop_back();
}

SkinFaces::SkinFaces(const WorkingMesh& mesh) : of_vertex_(mesh.points.size()) {
  std::vector<Triangle> at_vertex;
  for (Index v = 0; v < mesh.points.size(); ++v) {
    if (!mesh.is_vertex_alive(v) || !mesh.is_on_boundary(v)) continue;
    collect_boundary_faces(mesh, v, at_vertex);
    for (const Triangle& t : at_vertex) {
      if (v < t[1] && v < t[2]) enter(static_cast<Index>(slots()), t, BoxedTriangle(corners_of(mesh, t)));
    }
  }
}

void SkinFaces::make_room(std::size_t vertices) {
  if (of_vertex_.size() < vertices) of_vertex_.resize(vertices);
}

void SkinFaces::renumber(const std::vector<Index>& new_number, std::size_t vertices) {
  of_vertex_.assign(vertices, {});
  for (Index f = 0; f < faces_.size(); ++f) {
    if (!is_alive(f)) continue;
    for (Index& v : faces_[f]) v = new_number[v];
    link(f);
  }
}

void SkinFaces::link(Index f) {
  for (const Index v : faces_[f]) of_vertex_[v].push_back(f);
}

void SkinFaces::remove(Index f) {
  for (const Index v : faces_[f]) erase_one(of_vertex_[v], f);
  faces_[f][0] = kNoIndex;
  --alive_;
}

void SkinFaces::enter(Index f, const Triangle& face, const BoxedTriangle& place) {
  if (f == faces_.size()) {
    faces_.push_back(face);
    places_.push_back(place);
  } else {
    faces_[f] = face;
    places_[f] = place;
  }
  link(f);
  ++alive_;
}

void PlannedChange::plan(const WorkingMesh& mesh, const SkinFaces& faces, const BoundaryChange& change) {
  change_ = &change;
  ++plan_;
  removed_.resize(faces.slots());
  for (std::uint32_t k = 0; k < change.removed.size(); ++k) removed_[change.removed[k]] = {plan_, k};
  fresh_.clear();
  boxed_.clear();
  for (const Triangle& t : change.fresh) {
    PlacedFace face{t, corners_of(mesh, t)};
    for (std::size_t k = 0; k < 3; ++k) {
      if (t[k] == change.moved) face.corner[k] = change.to;
    }
    fresh_.push_back(face);
    boxed_.emplace_back(face.corner);
  }
}

}  // namespace palpate::simplify
