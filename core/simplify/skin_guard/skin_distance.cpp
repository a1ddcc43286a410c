#include "core/simplify/skin_guard/skin_distance.h"

#include <algorithm>
#include <array>

#include "core/base/error.h"

namespace palpate::simplify {
namespace {

/// Of the input's mean edge. A change shifts the skin by more than a bound below this has left, mostly.
constexpr double kLeastRoom = 0.1;

/// Of the bound. Where all faces are small, and more of it is used up, a shift proves less than it costs.
constexpr double kMostUsed = 0.3;

/// Of the bound. A face whose edges are no longer is cut into few pieces that are near the input's skin, and
/// that is found sooner than the skin is laid as a sheet.
constexpr double kSmallFace = 2.5;

double longest_edge_sq(const TriangleCorners& t) {
  return std::max({length_sq(t[1] - t[0]), length_sq(t[2] - t[1]), length_sq(t[0] - t[2])});
}

}  // namespace

SkinDistance::SkinDistance(const WorkingMesh& mesh, const SkinFaces& faces, double limit)
    : input_(mesh, faces.all()),
      cover_(limit),
      sheet_(limit),
      coverage_(faces.slots()),
      least_room_(kLeastRoom * input_.mean_edge()),
      input_stamp_(faces.slots(), 0),
      point_stamp_(mesh.points.size(), 0) {}

void SkinDistance::raise_limit(double limit) {
  require(limit >= cover_.limit(), "guarded boundary: a bound may only grow");
  cover_ = CoverTest(limit);
  sheet_.set_limit(limit);
}

bool SkinDistance::permits(const SkinFaces& faces, const PlannedChange& plan) {
  faces_ = &faces;
  plan_ = &plan;
  ++stamp_;
  collect_concerned();
  measure_shift();
  take_shifted();
  if (open_inputs_.empty() && open_faces_.empty()) return true;
  collect_around();
  if (!may_stay_near()) return false;
  if (is_seen_) {
    take_small_faces();
    lay_tiles();
  }
  return input_stays_near() && stays_near_input();
}

void SkinDistance::apply(const BoundaryChange& change, std::size_t slots) {
  for (const Index f : change.removed) coverage_.take_away(f);
  for (std::size_t i = 0; i < change.fresh.size(); ++i)
    coverage_.enter(change.number_of_fresh(i, slots), fresh_reach_[i]);
  for (std::size_t k = 0; k < proof_count_; ++k) {
    coverage_.take(proofs_[k], [this](Index f) { return plan_->is_removed(f); });
  }
}

/// The input's triangles that the removed faces cover.
void SkinDistance::collect_concerned() {
  concerned_.clear();
  for (const Index f : change().removed) {
    coverage_.for_each_covered(f, [this](Index i) {
      if (input_stamp_[i] == stamp_) return;
      input_stamp_[i] = stamp_;
      concerned_.push_back(i);
    });
  }
}

/// Faces that stay: those at the outline of the change, and those that cover the rest of what it concerns.
void SkinDistance::collect_around() {
  seen_stamp_.resize(faces_->slots(), 0);
  around_.clear();
  const auto add = [this](Index f) {
    if (seen_stamp_[f] == stamp_ || plan_->is_removed(f)) return;
    seen_stamp_[f] = stamp_;
    around_.push_back(f);
    candidates_.push_back(faces_->place(f));
  };
  for (const Triangle& t : change().fresh) {
    for (const Index v : t) {
      if (v == change().moved) continue;
      for (const Index f : faces_->of_vertex(v)) add(f);
    }
  }
  for (const Index i : concerned_) {
    for (const Index f : coverage_.covering(i)) add(f);
  }
}

/// Sees what would go and what would come along the mean normal of the latter: how far is either from the
/// other?
void SkinDistance::measure_shift() {
  candidates_ = plan_->boxed();
  face_tiles_.clear();
  is_shift_known_ = false;
  Vec3 direction;
  for (const BoxedTriangle& face : candidates_) direction = direction + face.normal;
  is_seen_ = reaches_beyond_limit();
  sheet_.look_against(direction, fresh().empty() ? Vec3{} : fresh().front().corner[0]);
  const double limit = cover_.limit();
  if (limit < least_room_) return;
  double least = limit;
  double most = 0.0;
  for (const Index i : concerned_) {
    least = std::min(least, coverage_.reach_of_input(i));
    most = std::max(most, coverage_.reach_of_input(i));
  }
  if (!is_seen_ && most > kMostUsed * limit) return;
  for (const PlacedFace& face : fresh()) face_tiles_.push_back(sheet_.tile(face.vertices, face.corner));
  gone_tiles_.clear();
  for (const Index f : change().removed)
    gone_tiles_.push_back(sheet_.tile(faces_->face(f), faces_->place(f).corner));
  sheet_.set_limit(limit - least);
  is_shift_known_ = shift_.measure(sheet_, gone_tiles_, face_tiles_);
  sheet_.set_limit(limit);
}

/// Settles all that is within the limit by what was proven before and the shift together.
void SkinDistance::take_shifted() {
  proof_count_ = 0;
  open_inputs_.clear();
  open_faces_.clear();
  fresh_reach_.assign(fresh().size(), 0.0);
  fresh_stamp_.assign(fresh().size(), 0);
  for (std::size_t k = 0; k < concerned_.size(); ++k) {
    if (!is_shift_known_ || !take_shifted_input(concerned_[k])) open_inputs_.push_back(k);
  }
  for (std::size_t k = 0; k < fresh().size(); ++k) {
    if (is_shift_known_) fresh_reach_[k] = reach_over_gone(k);
    if (!is_shift_known_ || !(fresh_reach_[k] <= cover_.limit())) open_faces_.push_back(k);
  }
}

double SkinDistance::reach_over_gone(std::size_t fresh) const {
  const FaceShift& shift = shift_.of_fresh(fresh);
  double reach = 0.0;
  for (const Index k : shift.over) reach = std::max(reach, coverage_.reach_of_face(change().removed[k]));
  return reach + shift.reach;
}

/// A point of the triangle has a point of the gone faces that covered it within its reach, and that one has
/// one of the fresh faces over it within the shift: no other is needed.
bool SkinDistance::take_shifted_input(Index i) {
  double shift = 0.0;
  for (const Index f : coverage_.covering(i)) {
    if (plan_->is_removed(f)) shift = std::max(shift, shift_.of_gone(plan_->place_of(f)).reach);
  }
  const double reach = coverage_.reach_of_input(i) + shift;
  if (!(reach <= cover_.limit())) return false;
  std::vector<Index>& covering = add_proof(i, reach).covering;
  const BoundingBox& box = input_.triangle(i).box;
  for (const Index f : coverage_.covering(i)) {
    if (!plan_->is_removed(f)) {
      covering.push_back(f);
      continue;
    }
    for (const Index k : shift_.of_gone(plan_->place_of(f)).over) {
      if (fresh_stamp_[k] == proof_count_) continue;
      fresh_stamp_[k] = proof_count_;
      if (may_be_within(reach * reach, candidates_[k].box, box))
        covering.push_back(change().number_of_fresh(k, faces_->slots()));
    }
  }
  return true;
}

CoverProof& SkinDistance::add_proof(Index input, double reach) {
  if (proofs_.size() == proof_count_) proofs_.emplace_back();
  CoverProof& proof = proofs_[proof_count_++];
  proof.input = input;
  proof.reach = reach;
  proof.covering.clear();
  return proof;
}

/// What is necessary for both distances, before the proof: most changes that go too far end here.
bool SkinDistance::may_stay_near() {
  for (const std::size_t open : open_inputs_) {
    const Index i = concerned_[open];
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint32_t& seen = point_stamp_[input_.face(i)[k]];
      if (seen == stamp_) continue;
      seen = stamp_;
      if (!cover_.is_near(input_.triangle(i).corner[k], candidates_)) return false;
    }
  }
  return std::all_of(open_faces_.begin(), open_faces_.end(), [&](std::size_t k) {
    const TriangleCorners& t = fresh()[k].corner;
    return cover_.is_near((1.0 / 3.0) * (t[0] + t[1] + t[2]), input_.tree());
  });
}

/// Whether an edge of the fresh faces is longer than the bound. If none is, a triangle near by is within the
/// bound of one face, mostly, and that is found sooner than a sheet is laid.
bool SkinDistance::reaches_beyond_limit() const {
  return std::any_of(fresh().begin(), fresh().end(), [this](const PlacedFace& face) {
    return longest_edge_sq(face.corner) > cover_.limit_sq();
  });
}

/// Sees the rest of both skins along the same direction.
void SkinDistance::lay_tiles() {
  for (std::size_t k = face_tiles_.size(); k < fresh().size(); ++k)
    face_tiles_.push_back(sheet_.tile(fresh()[k].vertices, fresh()[k].corner));
  for (std::size_t k = fresh().size(); k < candidates_.size(); ++k)
    face_tiles_.push_back(sheet_.tile(faces_->face(around_[k - fresh().size()]), candidates_[k].corner));
  lay_input_tiles();
}

Tile SkinDistance::tile_of_input(Index i) const {
  return sheet_.tile(input_.face(i), input_.triangle(i).corner);
}

void SkinDistance::lay_input_tiles() {
  input_tiles_.clear();
  if (open_faces_.empty()) return;
  for (const Index i : concerned_) input_tiles_.push_back(tile_of_input(i));
}

bool SkinDistance::input_stays_near() {
  const bool has_tiles = !input_tiles_.empty();
  const auto is_seen = [&](std::size_t k) {
    return sheet_.is_covered(has_tiles ? input_tiles_[k] : tile_of_input(concerned_[k]), face_tiles_, used_);
  };
  for (const std::size_t k : open_inputs_) {
    const Index i = concerned_[k];
    double reach = 0.0;
    if (is_seen_ && is_seen(k))
      reach = sheet_.reach();
    else if (cover_.is_covered(input_.triangle(i), candidates_, used_))
      reach = cover_.reach();
    else
      return false;
    CoverProof& proof = add_proof(i, reach);
    for (const Index u : used_) {
      proof.covering.push_back(u < fresh().size() ? change().number_of_fresh(u, faces_->slots())
                                                  : around_[u - fresh().size()]);
    }
  }
  return true;
}

/// Whether a fresh face is near the input's skin. Corners of the current faces are, and the only one of
/// another place was looked at.
bool SkinDistance::face_is_near(std::size_t k) {
  if (!cover_.is_inside_covered(fresh()[k].corner, input_.tree())) return false;
  fresh_reach_[k] = cover_.reach();
  return true;
}

/// Settles those of the fresh faces that are small and near the input's skin.
void SkinDistance::take_small_faces() {
  std::erase_if(open_faces_, [this](std::size_t k) {
    return longest_edge_sq(fresh()[k].corner) <= kSmallFace * kSmallFace * cover_.limit_sq() &&
           face_is_near(k);
  });
}

/// Settles those of the fresh faces over which the input's triangles lie like a sheet.
void SkinDistance::take_seen_faces() {
  std::erase_if(open_faces_, [this](std::size_t k) {
    if (!sheet_.is_covered(face_tiles_[k], input_tiles_, used_)) return false;
    fresh_reach_[k] = sheet_.reach();
    return true;
  });
}

bool SkinDistance::stays_near_input() {
  if (is_seen_) take_seen_faces();
  if (is_seen_ && !open_faces_.empty()) {
    widen_concerned();
    take_seen_faces();
  }
  return std::all_of(open_faces_.begin(), open_faces_.end(),
                     [this](std::size_t k) { return face_is_near(k); });
}

/// Adds the triangles beside those that a change concerns, and their tiles.
void SkinDistance::widen_concerned() {
  const std::size_t count = concerned_.size();
  for (std::size_t k = 0; k < count; ++k) {
    for (const Index i : input_.neighbours(concerned_[k])) {
      if (i == kNoIndex || input_stamp_[i] == stamp_) continue;
      input_stamp_[i] = stamp_;
      concerned_.push_back(i);
      input_tiles_.push_back(tile_of_input(i));
    }
  }
}

}  // namespace palpate::simplify
