#include "core/simplify/skin_guard/guarded_boundary.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/base/error.h"
#include "core/mesh/geometry.h"

namespace palpate::simplify {
namespace {

constexpr double kRounding = 1e-13;

/// Of the bound that is asked for. The rest leaves room for a measurement that brackets the distance.
constexpr double kShareOfBound = 0.998;

std::vector<Triangle> collect_faces(const WorkingMesh& mesh) {
  std::vector<Triangle> faces;
  std::vector<Triangle> at_vertex;
  for (Index v = 0; v < mesh.points.size(); ++v) {
    if (!mesh.is_vertex_alive(v) || !mesh.is_on_boundary(v)) continue;
    collect_boundary_faces(mesh, v, at_vertex);
    for (const Triangle& t : at_vertex) {
      if (v < t[1] && v < t[2]) faces.push_back(t);
    }
  }
  return faces;
}

TriangleCorners corners_of(const WorkingMesh& mesh, const Triangle& t) {
  return {mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]};
}

double at_least_rounding(double max_error, const WorkingMesh& mesh) {
  double largest = 0.0;
  for (const Vec3& p : mesh.points) {
    largest = std::max({largest, std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
  }
  return std::max(kShareOfBound * max_error, kRounding * largest);
}

void erase_one(std::vector<Index>& items, Index item) {
  const auto found = std::find(items.begin(), items.end(), item);
  require(found != items.end(), "guarded boundary: a face is not where it should be");
  *found = items.back();
  items.pop_back();
}

/// The number that a fresh face of a change gets, where there are numbers below `slots` before it.
Index number_of_fresh(const BoundaryChange& change, std::size_t fresh, std::size_t slots) {
  const std::size_t removed = change.removed.size();
  return fresh < removed ? change.removed[fresh] : static_cast<Index>(slots + fresh - removed);
}

std::uint64_t hash_cell(std::int64_t x, std::int64_t y, std::int64_t z) {
  std::uint64_t h = static_cast<std::uint64_t>(x) * 0x9e3779b97f4a7c15ULL;
  h = (h ^ (h >> 29U)) + static_cast<std::uint64_t>(y) * 0xbf58476d1ce4e5b9ULL;
  h = (h ^ (h >> 31U)) + static_cast<std::uint64_t>(z) * 0x94d049bb133111ebULL;
  return h ^ (h >> 30U);
}

}  // namespace

GuardedBoundary::GuardedBoundary(const WorkingMesh& mesh, double max_error, double feature_deg)
    : faces_(collect_faces(mesh)),
      of_vertex_(mesh.points.size()),
      alive_(faces_.size()),
      input_(mesh, faces_),
      cover_(at_least_rounding(max_error, mesh)),
      sheet_(at_least_rounding(max_error, mesh)),
      covering_(faces_.size()),
      covered_by_(faces_.size()),
      cell_(1.5 * input_.mean_edge()),
      cells_(std::bit_ceil(2 * faces_.size() + 1)),
      removed_stamp_(faces_.size(), 0),
      seen_stamp_(faces_.size(), 0),
      visited_(faces_.size(), 0),
      input_stamp_(faces_.size(), 0),
      point_stamp_(mesh.points.size(), 0) {
  for (Index f = 0; f < faces_.size(); ++f) {
    link(f);
    covering_[f] = {f};
    covered_by_[f] = {f};
    places_.push_back(input_.triangle(f));
    enter_grid(f);
  }
  if (feature_deg > 0.0) lines_ = FeatureLines(mesh, faces_, feature_deg, at_least_rounding(max_error, mesh));
}

void GuardedBoundary::raise_bound(const WorkingMesh& mesh, double max_error) {
  const double limit = at_least_rounding(max_error, mesh);
  const CoverTest raised(limit);
  require(raised.limit_sq() >= cover_.limit_sq(), "guarded boundary: a bound may only grow");
  cover_ = raised;
  sheet_ = SheetCover(limit);
  if (!lines_.is_empty()) lines_.raise_limit(limit);
}

void GuardedBoundary::renumber(const std::vector<Index>& new_number, std::size_t vertices) {
  of_vertex_.assign(vertices, {});
  for (Index f = 0; f < faces_.size(); ++f) {
    if (!is_alive(f)) continue;
    for (Index& v : faces_[f]) v = new_number[v];
    link(f);
  }
  lines_.renumber(new_number, vertices);
}

void GuardedBoundary::link(Index f) {
  for (const Index v : faces_[f]) of_vertex_[v].push_back(f);
}

void GuardedBoundary::unlink(Index f) {
  for (const Index v : faces_[f]) erase_one(of_vertex_[v], f);
}

template <typename Visit>
void GuardedBoundary::for_each_cell(const BoundingBox& box, const Visit& visit) const {
  const auto range = [this](double low, double high) {
    const auto cell = [this](double x) { return static_cast<std::int64_t>(std::floor(x / cell_)); };
    return std::pair{cell(low), cell(high)};
  };
  const auto [x0, x1] = range(box.low.x, box.high.x);
  const auto [y0, y1] = range(box.low.y, box.high.y);
  const auto [z0, z1] = range(box.low.z, box.high.z);
  for (std::int64_t x = x0; x <= x1; ++x) {
    for (std::int64_t y = y0; y <= y1; ++y) {
      for (std::int64_t z = z0; z <= z1; ++z) visit(hash_cell(x, y, z) & (cells_.size() - 1));
    }
  }
}

void GuardedBoundary::enter_grid(Index f) {
  for_each_cell(places_[f].box, [&](std::size_t cell) { cells_[cell].push_back(f); });
}

void GuardedBoundary::leave_grid(Index f) {
  for_each_cell(places_[f].box, [&](std::size_t cell) { erase_one(cells_[cell], f); });
}

void GuardedBoundary::place_fresh(const WorkingMesh& mesh, const BoundaryChange& change) {
  fresh_.clear();
  for (const Triangle& t : change.fresh) {
    PlacedFace face{t, corners_of(mesh, t)};
    for (std::size_t k = 0; k < 3; ++k) {
      if (t[k] == change.moved) face.corner[k] = change.to;
    }
    fresh_.push_back(face);
  }
}

BoundaryVerdict GuardedBoundary::check(const WorkingMesh& mesh, const BoundaryChange& change) {
  ++stamp_;
  if (of_vertex_.size() < mesh.points.size()) of_vertex_.resize(mesh.points.size());  // some were added
  for (const Index f : change.removed) removed_stamp_[f] = stamp_;
  place_fresh(mesh, change);
  if (change.moved != kNoIndex && !cover_.is_near(change.to, input_.tree())) return BoundaryVerdict::kTooFar;
  collect_concerned(change);
  collect_around(change);
  if (!may_stay_near()) return BoundaryVerdict::kTooFar;
  if ((is_seen_ = reaches_beyond_limit())) lay_tiles();
  if (!input_stays_near(change) || !stays_near_input()) return BoundaryVerdict::kTooFar;
  return touches_others() ? BoundaryVerdict::kContact : BoundaryVerdict::kAllowed;
}

bool GuardedBoundary::touches_others() {
  for (std::size_t i = 0; i < fresh_.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (are_in_contact(fresh_[i], fresh_[j])) return true;
    }
  }
  if (fresh_.empty()) return true;
  for (std::size_t k = 0; k < fresh_.size(); ++k) {
    if (touches(k)) return true;
  }
  return false;
}

/// Whether a fresh face is in contact with a face that stays.
bool GuardedBoundary::touches(std::size_t fresh) {
  ++visit_;
  const PlacedFace& face = fresh_[fresh];
  const BoundingBox& box = candidates_[fresh].box;
  bool found = false;
  for_each_cell(box, [&](std::size_t cell) {
    found = found || std::any_of(cells_[cell].begin(), cells_[cell].end(), [&](Index f) {
              if (visited_[f] == visit_) return false;
              visited_[f] = visit_;
              return distance_sq_of_boxes(box, places_[f].box) == 0.0 && !is_removed(f) &&
                     are_in_contact(face, placed(f));
            });
  });
  return found;
}

double GuardedBoundary::volume(const WorkingMesh& mesh) const {
  SurfaceMesh skin{mesh.points, {}};
  for (Index f = 0; f < faces_.size(); ++f) {
    if (is_alive(f)) skin.triangles.push_back(faces_[f]);
  }
  return enclosed_volume(skin);
}

std::optional<Vec3> GuardedBoundary::find_contact() const {
  for (Index f = 0; f < faces_.size(); ++f) {
    if (!is_alive(f)) continue;
    const PlacedFace face = placed(f);
    bool touches = false;
    for_each_cell(places_[f].box, [&](std::size_t cell) {
      touches = touches || std::any_of(cells_[cell].begin(), cells_[cell].end(),
                                       [&](Index g) { return g < f && are_in_contact(face, placed(g)); });
    });
    if (touches) return (1.0 / 3.0) * (face.corner[0] + face.corner[1] + face.corner[2]);
  }
  return std::nullopt;
}

/// The input's triangles that the removed faces cover.
void GuardedBoundary::collect_concerned(const BoundaryChange& change) {
  concerned_.clear();
  for (const Index f : change.removed) {
    for (const Index i : covered_by_[f]) {
      if (input_stamp_[i] == stamp_) continue;
      if (std::find(covering_[i].begin(), covering_[i].end(), f) == covering_[i].end()) continue;
      input_stamp_[i] = stamp_;
      concerned_.push_back(i);
    }
  }
}

/// Faces that stay: those at the outline of the change, and those that cover the rest of what it concerns.
void GuardedBoundary::collect_around(const BoundaryChange& change) {
  around_.clear();
  candidates_.clear();
  for (const PlacedFace& face : fresh_) candidates_.emplace_back(face.corner);
  for (const Triangle& t : change.fresh) {
    for (const Index v : t) {
      if (v == change.moved) continue;
      for (const Index f : of_vertex_[v]) add_around(f);
    }
  }
  for (const Index i : concerned_) {
    for (const Index f : covering_[i]) add_around(f);
  }
}

void GuardedBoundary::add_around(Index f) {
  if (is_removed(f) || seen_stamp_[f] == stamp_) return;
  seen_stamp_[f] = stamp_;
  around_.push_back(f);
  candidates_.push_back(places_[f]);
}

/// What is necessary for both distances, before the proof: most changes that go too far end here.
bool GuardedBoundary::may_stay_near() {
  for (const Index i : concerned_) {
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint32_t& seen = point_stamp_[input_.face(i)[k]];
      if (seen == stamp_) continue;
      seen = stamp_;
      if (!cover_.is_near(input_.triangle(i).corner[k], candidates_)) return false;
    }
  }
  return std::all_of(fresh_.begin(), fresh_.end(), [&](const PlacedFace& face) {
    const TriangleCorners& t = face.corner;
    return cover_.is_near((1.0 / 3.0) * (t[0] + t[1] + t[2]), input_.tree());
  });
}

/// Whether an edge of the fresh faces is longer than the bound. If none is, a triangle near by is within the
/// bound of one face, mostly, and that is found sooner than a sheet is laid.
bool GuardedBoundary::reaches_beyond_limit() const {
  return std::any_of(fresh_.begin(), fresh_.end(), [this](const PlacedFace& face) {
    const TriangleCorners& t = face.corner;
    return std::max({length_sq(t[1] - t[0]), length_sq(t[2] - t[1]), length_sq(t[0] - t[2])}) >
           cover_.limit_sq();
  });
}

/// Sees both skins along the mean normal of what would change, which is that of what would go, too.
void GuardedBoundary::lay_tiles() {
  Vec3 direction;
  for (std::size_t k = 0; k < fresh_.size(); ++k) direction = direction + candidates_[k].normal;
  sheet_.look_against(direction, fresh_.empty() ? Vec3{} : fresh_.front().corner[0]);
  face_tiles_.clear();
  for (std::size_t k = 0; k < candidates_.size(); ++k) {
    const bool is_fresh = k < fresh_.size();
    const Triangle& number = is_fresh ? fresh_[k].vertices : faces_[around_[k - fresh_.size()]];
    face_tiles_.push_back(sheet_.tile(number, candidates_[k].corner));
  }
  lay_input_tiles();
}

void GuardedBoundary::lay_input_tiles() {
  input_tiles_.clear();
  for (const Index i : concerned_)
    input_tiles_.push_back(sheet_.tile(input_.face(i), input_.triangle(i).corner));
}

bool GuardedBoundary::input_stays_near(const BoundaryChange& change) {
  proof_count_ = 0;
  for (std::size_t k = 0; k < concerned_.size(); ++k) {
    const Index i = concerned_[k];
    if (!(is_seen_ && sheet_.is_covered(input_tiles_[k], face_tiles_, used_)) &&
        !cover_.is_covered(input_.triangle(i), candidates_, used_))
      return false;
    if (proofs_.size() == proof_count_) proofs_.emplace_back();
    Proof& proof = proofs_[proof_count_++];
    proof.input = i;
    proof.covering.clear();
    for (const Index u : used_) {
      proof.covering.push_back(u < fresh_.size() ? number_of_fresh(change, u, faces_.size())
                                                 : around_[u - fresh_.size()]);
    }
  }
  return true;
}

/// Corners of the current faces are near the input, and the only one of another place was looked at.
bool GuardedBoundary::stays_near_input() {
  const auto is_near = [this](const PlacedFace& face) {
    return cover_.is_inside_covered(face.corner, input_.tree());
  };
  if (!is_seen_) return std::all_of(fresh_.begin(), fresh_.end(), is_near);
  std::vector<std::size_t>& left = open_faces_;
  left.clear();
  for (std::size_t k = 0; k < fresh_.size(); ++k) {
    if (!sheet_.is_covered(face_tiles_[k], input_tiles_, used_)) left.push_back(k);
  }
  if (left.empty()) return true;
  widen_concerned();
  return std::all_of(left.begin(), left.end(), [&](std::size_t k) {
    const PlacedFace& face = fresh_[k];
    sheet_.look_against(candidates_[k].normal, face.corner[0]);
    lay_input_tiles();
    return sheet_.is_covered(sheet_.tile(face.vertices, face.corner), input_tiles_, used_) || is_near(face);
  });
}

/// Adds the triangles beside those that a change concerns.
void GuardedBoundary::widen_concerned() {
  const std::size_t count = concerned_.size();
  for (std::size_t k = 0; k < count; ++k) {
    for (const Index i : input_.neighbours(concerned_[k])) {
      if (i == kNoIndex || input_stamp_[i] == stamp_) continue;
      input_stamp_[i] = stamp_;
      concerned_.push_back(i);
    }
  }
}

void GuardedBoundary::make_room(std::size_t faces) {
  faces_.resize(faces);
  covered_by_.resize(faces);
  places_.resize(faces, places_.front());
  removed_stamp_.resize(faces, 0);
  seen_stamp_.resize(faces, 0);
  visited_.resize(faces, 0);
}

void GuardedBoundary::apply(const BoundaryChange& change) {
  require(fresh_.size() == change.fresh.size(),
          "guarded boundary: the change is not the one that was checked");
  for (const Index f : change.removed) {
    leave_grid(f);
    unlink(f);
    faces_[f][0] = kNoIndex;
    covered_by_[f].clear();
  }
  const std::size_t slots = faces_.size();
  if (change.fresh.size() > change.removed.size())
    make_room(slots + change.fresh.size() - change.removed.size());
  for (std::size_t i = 0; i < change.fresh.size(); ++i) {
    const Index f = number_of_fresh(change, i, slots);
    faces_[f] = change.fresh[i];
    link(f);
    places_[f] = candidates_[i];
    enter_grid(f);
  }
  alive_ = alive_ + change.fresh.size() - change.removed.size();
  for (std::size_t k = 0; k < proof_count_; ++k) {
    const Proof& proof = proofs_[k];
    for (const Index f : proof.covering) {
      std::vector<Index>& covered = covered_by_[f];
      const std::vector<Index>& before = covering_[proof.input];
      const bool is_known = !is_removed(f) && std::find(before.begin(), before.end(), f) != before.end();
      if (!is_known) covered.push_back(proof.input);
    }
    covering_[proof.input] = proof.covering;
  }
}

FeatureRank hold_on(const WorkingMesh& mesh, const GuardedBoundary& boundary, Index v) {
  return (mesh.vertex_flags[v] & kFrozen) != 0 ? FeatureRank::kCorner : boundary.lines().rank(v);
}

}  // namespace palpate::simplify
