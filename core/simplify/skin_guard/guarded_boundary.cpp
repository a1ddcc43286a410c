#include "core/simplify/skin_guard/guarded_boundary.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/mesh/geometry.h"

namespace palpate::simplify {
namespace {

constexpr double kRounding = 1e-13;

/// Of the bound that is asked for. The rest leaves room for a measurement that brackets the distance.
constexpr double kShareOfBound = 0.998;

/// Cells of the grid, over the mean edge; made wider by so much when faces have grown as much.
constexpr double kCell = 2.2;
constexpr std::size_t kWiden = 2;

double at_least_rounding(double max_error, const WorkingMesh& mesh) {
  double largest = 0.0;
  for (const Vec3& p : mesh.points) {
    largest = std::max({largest, std::fabs(p.x), std::fabs(p.y), std::fabs(p.z)});
  }
  return std::max(kShareOfBound * max_error, kRounding * largest);
}

}  // namespace

GuardedBoundary::GuardedBoundary(const WorkingMesh& mesh, double max_error, double feature_deg)
    : faces_(mesh),
      distance_(mesh, faces_, at_least_rounding(max_error, mesh)),
      faces_in_grid_(faces_.slots()),
      grid_(kCell * distance_.input().mean_edge(), faces_in_grid_) {
  fill_grid();
  if (feature_deg > 0.0)
    lines_ = FeatureLines(mesh, faces_.all(), feature_deg, at_least_rounding(max_error, mesh));
}

void GuardedBoundary::raise_bound(const WorkingMesh& mesh, double max_error) {
  const double limit = at_least_rounding(max_error, mesh);
  distance_.raise_limit(limit);
  if (!lines_.is_empty()) lines_.raise_limit(limit);
}

void GuardedBoundary::renumber(const std::vector<Index>& new_number, std::size_t vertices) {
  faces_.renumber(new_number, vertices);
  lines_.renumber(new_number, vertices);
}

BoundaryVerdict GuardedBoundary::check(const WorkingMesh& mesh, const BoundaryChange& change) {
  if (change.moved != kNoIndex && !distance_.may_hold(change.to)) return BoundaryVerdict::kTooFar;
  faces_.make_room(mesh.points.size());  // some were added
  plan_.plan(mesh, faces_, change);
  if (!distance_.permits(faces_, plan_)) return BoundaryVerdict::kTooFar;
  return touches_others() ? BoundaryVerdict::kContact : BoundaryVerdict::kAllowed;
}

/// Collects the current faces that may touch something in the box.
void GuardedBoundary::collect_near(const BoundingBox& box) {
  near_.clear();
  grid_.for_each_near(box, [&](Index f) {
    if (do_overlap(box, faces_.place(f).box)) near_.push_back(f);
  });
}

/// Whether a fresh face is in contact with another one, or with one that stays.
bool GuardedBoundary::touches_others() {
  const std::vector<PlacedFace>& fresh = plan_.fresh();
  if (fresh.empty()) return true;
  BoundingBox around = plan_.boxed()[0].box;
  for (std::size_t i = 0; i < fresh.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (are_in_contact(fresh[i], fresh[j])) return true;
    }
    extend(around, plan_.boxed()[i].box);
  }
  collect_near(around);
  return std::any_of(near_.begin(), near_.end(), [&](Index f) {
    if (plan_.is_removed(f)) return false;
    const BoundingBox& box = faces_.place(f).box;
    for (std::size_t i = 0; i < fresh.size(); ++i) {
      if (do_overlap(plan_.boxed()[i].box, box) && are_in_contact(fresh[i], faces_.placed(f))) return true;
    }
    return false;
  });
}

double GuardedBoundary::volume(const WorkingMesh& mesh) const {
  SurfaceMesh skin{mesh.points, {}};
  for (Index f = 0; f < faces_.slots(); ++f) {
    if (is_alive(f)) skin.triangles.push_back(face(f));
  }
  return enclosed_volume(skin);
}

std::optional<Vec3> GuardedBoundary::find_contact() {
  for (Index f = 0; f < faces_.slots(); ++f) {
    if (!is_alive(f)) continue;
    const PlacedFace face = faces_.placed(f);
    collect_near(faces_.place(f).box);
    const auto touches = [&](Index g) { return g < f && are_in_contact(face, faces_.placed(g)); };
    if (std::any_of(near_.begin(), near_.end(), touches))
      return (1.0 / 3.0) * (face.corner[0] + face.corner[1] + face.corner[2]);
  }
  return std::nullopt;
}

void GuardedBoundary::apply(const BoundaryChange& change) {
  require(plan_.fresh().size() == change.fresh.size(),
          "guarded boundary: the change is not the one that was checked");
  const std::size_t slots = faces_.slots();
  for (const Index f : change.removed) {
    grid_.leave(f, faces_.place(f).box);
    faces_.remove(f);
  }
  for (std::size_t i = 0; i < change.fresh.size(); ++i) {
    const Index f = change.number_of_fresh(i, slots);
    faces_.enter(f, change.fresh[i], plan_.boxed()[i]);
    grid_.enter(f, faces_.place(f).box);
  }
  distance_.apply(change, slots);
  if (kWiden * kWiden * faces_.alive() < faces_in_grid_) widen_grid();
}

/// Faces have grown, and meet many of the cells.
void GuardedBoundary::widen_grid() {
  faces_in_grid_ = faces_.alive();
  grid_ = FaceGrid(kWiden * grid_.cell(), faces_in_grid_);
  fill_grid();
}

void GuardedBoundary::fill_grid() {
  for (Index f = 0; f < faces_.slots(); ++f) {
    if (is_alive(f)) grid_.enter(f, faces_.place(f).box);
  }
}

FeatureRank hold_on(const WorkingMesh& mesh, const GuardedBoundary& boundary, Index v) {
  return (mesh.vertex_flags[v] & kFrozen) != 0 ? FeatureRank::kCorner : boundary.lines().rank(v);
}

}  // namespace palpate::simplify
