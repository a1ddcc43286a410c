#include "core/simplify/sizing/sizing.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/mesh/topology.h"

namespace palpate::simplify {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string number_text(double value) {
  std::string text;
  append_number(text, value);
  return text;
}

void check(bool condition, const char* what, const char* expected, double found) {
  if (!condition) throw InputError(what, 0, expected, number_text(found));
}

void check_region(const KeptRegion& r) {
  const bool has_center = r.kind != KeptRegion::Kind::kHalfSpace;
  if (has_center && !is_finite(r.center)) throw InputError("keep", 0, "a finite center", "one that is not");
  if (has_center)
    check(r.radius > 0.0 && std::isfinite(r.radius), "keep", "a radius above 0, finite", r.radius);
  if (r.kind == KeptRegion::Kind::kSurfacePatch)
    check(r.depth >= 0.0 && std::isfinite(r.depth), "keep", "a depth of at least 0, finite", r.depth);
  if (r.kind == KeptRegion::Kind::kHalfSpace) {
    const double size = length(r.normal);
    check(size > 0.0 && std::isfinite(size), "keep", "a normal that is finite and not 0", size);
    check(std::isfinite(r.offset / size), "keep", "a finite offset", r.offset);
  }
}

/// The boundary faces that have a vertex in the ball around the region's center.
std::vector<Triangle> faces_of_patch(const KeptRegion& region, const TetMesh& mesh,
                                     const std::vector<Triangle>& boundary) {
  const auto is_in = [&](Index v) { return length(mesh.points[v] - region.center) <= region.radius; };
  std::vector<Triangle> faces;
  std::copy_if(boundary.begin(), boundary.end(), std::back_inserter(faces),
               [&](const Triangle& f) { return std::any_of(f.begin(), f.end(), is_in); });
  if (!faces.empty()) return faces;
  double nearest = kInfinity;
  for (const Triangle& f : boundary) {
    for (const Index v : f) nearest = std::min(nearest, length(mesh.points[v] - region.center));
  }
  throw InputError("keep patch", 0,
                   "a vertex of the boundary within the radius " + number_text(region.radius),
                   boundary.empty() ? "no boundary" : "the nearest one " + number_text(nearest) + " away");
}

bool is_inside(const Vec3& p, const std::array<Vec3, 4>& tet) {
  return std::all_of(kTetFaces.begin(), kTetFaces.end(), [&](const auto& face) {
    const Vec3& a = tet[face[0]];
    return dot(cross(tet[face[1]] - a, tet[face[2]] - a), p - a) <= 0.0;
  });
}

bool meets_sphere(const std::array<Vec3, 4>& tet, const Vec3& center, double radius) {
  if (is_inside(center, tet)) return true;
  return std::any_of(kTetFaces.begin(), kTetFaces.end(), [&](const auto& face) {
    return distance_sq_to_triangle(center, tet[face[0]], tet[face[1]], tet[face[2]]) <= radius * radius;
  });
}

}  // namespace

SizingField::SizingField(const SizingOptions& options, const TetMesh& mesh) {
  check(options.near_size > 0.0 && options.near_size <= 1.0, "near_size", "a number above 0, at most 1",
        options.near_size);
  check(options.reach >= 0.0 && std::isfinite(options.reach), "reach", "a finite number of at least 0",
        options.reach);
  for (const KeptRegion& region : options.keep) check_region(region);
  sizes_ = options.sizes;
  if (sizes_ != nullptr) near_size_ = sizes_->least();
  if (options.keep.empty()) return;
  std::vector<Triangle> boundary;
  for (const KeptRegion& given : options.keep) {
    Region region{given, 0};
    if (given.kind == KeptRegion::Kind::kHalfSpace) {
      const double size = length(given.normal);
      region.shape.normal = (1.0 / size) * given.normal;
      region.shape.offset = given.offset / size;
    }
    if (given.kind == KeptRegion::Kind::kSurfacePatch) {
      if (boundary.empty()) boundary = build_boundary(mesh);
      region.patch = patches_.size();
      patches_.emplace_back(mesh.points, faces_of_patch(given, mesh, boundary));
    }
    regions_.push_back(region);
  }
  region_size_ = options.near_size;
  near_size_ = std::min(near_size_, region_size_);
  const BoundingBox box = bounding_box(mesh.points);
  reach_ = options.reach > 0.0 ? options.reach : 0.25 * length(box.high - box.low);
}

double SizingField::distance_to(const Region& region, const Vec3& x, double bound) const {
  switch (region.shape.kind) {
    case KeptRegion::Kind::kSphere:
      return std::max(0.0, length(x - region.shape.center) - region.shape.radius);
    case KeptRegion::Kind::kHalfSpace:
      return std::max(0.0, dot(region.shape.normal, x) - region.shape.offset);
    case KeptRegion::Kind::kSurfacePatch:
      return std::max(0.0,
                      patches_[region.patch].distance(x, bound + region.shape.depth) - region.shape.depth);
  }
  throw ContractError("SizingField: a kind of region that is none");
}

double SizingField::distance(const Vec3& x) const {
  double least = kInfinity;
  for (const Region& region : regions_) least = std::min(least, distance_to(region, x, least));
  return least;
}

double SizingField::relative_size(const Vec3& x) const {
  const double wanted = sizes_ != nullptr ? sizes_->at(x) : 1.0;
  double least = reach_;
  for (const Region& region : regions_) least = std::min(least, distance_to(region, x, least));
  if (!(least < reach_)) return wanted;
  const double t = least / reach_;
  return std::min(wanted, region_size_ + (1.0 - region_size_) * t * t * (3.0 - 2.0 * t));
}

bool SizingField::meets(const std::array<Vec3, 4>& tet) const {
  return std::any_of(regions_.begin(), regions_.end(), [&](const Region& region) {
    const KeptRegion& r = region.shape;
    switch (r.kind) {
      case KeptRegion::Kind::kSphere:
        return meets_sphere(tet, r.center, r.radius);
      case KeptRegion::Kind::kHalfSpace:
        return std::any_of(tet.begin(), tet.end(),
                           [&](const Vec3& p) { return dot(r.normal, p) <= r.offset; });
      case KeptRegion::Kind::kSurfacePatch:
        return patches_[region.patch].is_within(tet, r.depth);
    }
    throw ContractError("SizingField: a kind of region that is none");
  });
}

void GrowthBound::start_pass(int n) {
  largest_far_ = n < passes() ? std::ldexp(mean_volume_, n) : kInfinity;
}

bool GrowthBound::admits(const std::array<Vec3, 4>& tet) const {
  if (largest_far_ == kInfinity) return true;
  const double volume = signed_volume(tet[0], tet[1], tet[2], tet[3]);
  const auto allowed = [&](double size) { return size * size * size * largest_far_; };
  if (volume >= largest_far_) return false;
  if (volume < allowed(field_->near_size())) return true;
  return volume < allowed(field_->relative_size(0.25 * (tet[0] + tet[1] + tet[2] + tet[3])));
}

double graded_volume(const TetMesh& mesh, const SizingField& field) {
  double sum = 0.0;
  for (const Tet& t : mesh.tets) {
    const std::array<Vec3, 4> p{mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]};
    const double volume = signed_volume(p[0], p[1], p[2], p[3]);
    if (field.is_empty()) {
      sum += volume;
    } else {
      const double size = field.relative_size(0.25 * (p[0] + p[1] + p[2] + p[3]));
      sum += volume / (size * size * size);
    }
  }
  return sum;
}

std::vector<std::uint8_t> build_kept_tets(const SizingField& field, const TetMesh& mesh) {
  if (!field.keeps_any()) return {};
  std::vector<std::uint8_t> kept(mesh.tets.size());
  std::transform(mesh.tets.begin(), mesh.tets.end(), kept.begin(), [&](const Tet& t) {
    return static_cast<std::uint8_t>(
        field.meets({mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]}));
  });
  return kept;
}

std::vector<std::uint8_t> build_kept_vertices(const std::vector<std::uint8_t>& kept_tets,
                                              const TetMesh& mesh) {
  if (kept_tets.empty()) return {};
  require(kept_tets.size() == mesh.tets.size(), "build_kept_vertices: one flag a tet");
  std::vector<std::uint8_t> kept(mesh.points.size(), 0);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    if (kept_tets[t] == 0) continue;
    for (const Index v : mesh.tets[t]) kept[v] = 1;
  }
  return kept;
}

}  // namespace palpate::simplify
