#include "experiments/scene_reader/region.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/mesh/geometry.h"
#include "core/mesh/topology.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace {

constexpr double kFarthest = 1e6;  // m
constexpr double kFarAway = 10.0;  // longest sides of the mesh's box

Vec3 read_direction(const YamlValue& value) {
  const Vec3 direction = read_vector(value);
  const double size = length(direction);
  if (!(size > 1e-100)) value.fail_expected("a direction (not all zero)");
  return (1.0 / size) * direction;
}

double read_positive_up_to(const YamlValue& value, double most) {
  const double number = value.number();
  if (!(number > 0.0) || number > most)
    value.fail_expected("a positive number, at most " + short_number(most));
  return number;
}

void read_sphere(const YamlValue& value, Region& region) {
  region.kind = Region::Kind::kSphere;
  const YamlFields fields = value.fields({"center_m", "surface_point", "radius_m", "radius_relative"});
  const auto center = fields.find("center_m");
  const auto surface = fields.find("surface_point");
  if (center.has_value() == surface.has_value())
    value.fail("a sphere needs one of \"center_m\" and \"surface_point\"");
  if (center) region.center = read_vector(*center);
  if (surface) region.surface_direction = read_direction(surface->fields({"direction"}).need("direction"));
  const auto radius = fields.find("radius_m");
  const auto relative = fields.find("radius_relative");
  if (radius.has_value() == relative.has_value())
    value.fail("a sphere needs one of \"radius_m\" and \"radius_relative\"");
  if (radius) region.radius = read_positive_up_to(*radius, kFarthest);
  if (relative) region.radius_relative = read_positive_up_to(*relative, kFarAway);
}

void read_half_space(const YamlValue& value, Region& region) {
  region.kind = Region::Kind::kHalfSpace;
  const YamlFields fields = value.fields({"normal", "offset_m", "share"});
  region.normal = read_direction(fields.need("normal"));
  const auto offset = fields.find("offset_m");
  const auto share = fields.find("share");
  if (offset.has_value() == share.has_value())
    value.fail("a half_space needs one of \"offset_m\" and \"share\"");
  if (offset) region.offset = offset->number(-kFarthest, kFarthest);
  if (share) region.share = share->number(0.0, 1.0);
}

void read_box(const YamlValue& value, Region& region) {
  region.kind = Region::Kind::kBox;
  const YamlFields fields = value.fields({"low_m", "high_m"});
  region.low = read_vector(fields.need("low_m"));
  region.high = read_vector(fields.need("high_m"));
  const bool ordered =
      region.low.x <= region.high.x && region.low.y <= region.high.y && region.low.z <= region.high.z;
  if (!ordered) value.fail("box: expected low_m below high_m on every axis");
}

Vec3 volume_centroid(const TetMesh& mesh) {
  Vec3 sum;
  double volume = 0.0;
  for (const Tet& t : mesh.tets) {
    const Vec3& a = mesh.points[t[0]];
    const Vec3& b = mesh.points[t[1]];
    const Vec3& c = mesh.points[t[2]];
    const Vec3& d = mesh.points[t[3]];
    const double part = signed_volume(a, b, c, d);
    volume += part;
    sum = sum + 0.25 * part * (a + b + c + d);
  }
  return (1.0 / volume) * sum;
}

/// Where the ray meets the triangle, as a multiple of `direction`; negative if it does not. Its border
/// counts.
double ray_hit(const Vec3& origin, const Vec3& direction, const Vec3& a, const Vec3& b, const Vec3& c) {
  constexpr double kEdge = 1e-12;  // a ray through an edge must not slip between its two faces
  const Vec3 u = b - a;
  const Vec3 v = c - a;
  const Vec3 p = cross(direction, v);
  const double det = dot(u, p);
  if (std::fabs(det) <= 1e-14 * length(u) * length(v)) return -1.0;
  const Vec3 s = origin - a;
  const double first = dot(s, p) / det;
  const Vec3 q = cross(s, u);
  const double second = dot(direction, q) / det;
  if (first < -kEdge || second < -kEdge || first + second > 1.0 + kEdge) return -1.0;
  return dot(v, q) / det;
}

std::string shown(const Vec3& v) {
  std::array<char, 80> text{};
  std::snprintf(text.data(), text.size(), "[%.4g, %.4g, %.4g]", v.x, v.y, v.z);
  return text.data();
}

bool is_in_a_tet(const Vec3& p, const TetMesh& mesh) {
  return std::any_of(mesh.tets.begin(), mesh.tets.end(), [&](const Tet& t) {
    const auto& x = mesh.points;
    return signed_volume(p, x[t[1]], x[t[2]], x[t[3]]) >= 0.0 &&
           signed_volume(x[t[0]], p, x[t[2]], x[t[3]]) >= 0.0 &&
           signed_volume(x[t[0]], x[t[1]], p, x[t[3]]) >= 0.0 &&
           signed_volume(x[t[0]], x[t[1]], x[t[2]], p) >= 0.0;
  });
}

/// Says why a ray met no boundary: the centroid of a bent or hollow body lies outside it.
[[noreturn]] void fail_without_hit(const Region& region, const Vec3& origin, const TetMesh& mesh,
                                   const std::vector<Triangle>& boundary) {
  Vec3 nearest = mesh.points[boundary.front()[0]] - origin;
  for (const Triangle& t : boundary) {
    for (const Index v : t) {
      const Vec3 to = mesh.points[v] - origin;
      if (length_sq(to) < length_sq(nearest)) nearest = to;
    }
  }
  const std::string why =
      is_in_a_tet(origin, mesh)
          ? "no boundary there"
          : "no boundary there: the centroid " + shown(origin) +
                " m lies outside the body, which is bent or hollow, and the ray leads away from "
                "it. The nearest skin is in the direction " +
                shown((1.0 / length(nearest)) * nearest) + "; \"center_m\" needs no direction";
  throw InputError(region.where + ": surface_point", 0,
                   "a direction from the centroid that meets the boundary", why);
}

Vec3 surface_point(const Region& region, const TetMesh& mesh) {
  const Vec3 origin = volume_centroid(mesh);
  const Vec3 direction = *region.surface_direction;
  const std::vector<Triangle> boundary = build_boundary(mesh);
  double last = -1.0;
  for (const Triangle& t : boundary) {
    last =
        std::max(last, ray_hit(origin, direction, mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]));
  }
  if (last < 0.0) fail_without_hit(region, origin, mesh, boundary);
  return origin + last * direction;
}

/// Distance of a point from a box; 0 inside.
double distance_to_box(const BoundingBox& box, const Vec3& p) {
  const auto gap = [](double low, double high, double x) { return std::max({low - x, x - high, 0.0}); };
  return length(
      {gap(box.low.x, box.high.x, p.x), gap(box.low.y, box.high.y, p.y), gap(box.low.z, box.high.z, p.z)});
}

/// Least and greatest n . x over the corners of a box.
std::pair<double, double> extent_along(const BoundingBox& box, const Vec3& n) {
  double least = std::numeric_limits<double>::infinity();
  double greatest = -least;
  for (const double x : {box.low.x, box.high.x}) {
    for (const double y : {box.low.y, box.high.y}) {
      for (const double z : {box.low.z, box.high.z}) {
        least = std::min(least, dot(n, {x, y, z}));
        greatest = std::max(greatest, dot(n, {x, y, z}));
      }
    }
  }
  return {least, greatest};
}

/// Distance of a placed region's border from the mesh's box, 0 where they meet or the region lies inside.
double border_distance(const Region& region, const BoundingBox& box) {
  switch (region.kind) {
    case Region::Kind::kSphere: {
      double farthest = 0.0;
      for (const double x : {box.low.x, box.high.x}) {
        for (const double y : {box.low.y, box.high.y}) {
          for (const double z : {box.low.z, box.high.z})
            farthest = std::max(farthest, length(Vec3{x, y, z} - region.center));
        }
      }
      const double nearest = distance_to_box(box, region.center);
      return std::max({nearest - region.radius, region.radius - farthest, 0.0});
    }
    case Region::Kind::kHalfSpace: {
      const auto [least, greatest] = extent_along(box, region.normal);
      return std::max({least - region.offset, region.offset - greatest, 0.0});
    }
    case Region::Kind::kBox: {
      const auto gap = [](double low_a, double high_a, double low_b, double high_b) {
        return std::max({low_a - high_b, low_b - high_a, 0.0});
      };
      const Vec3 apart{gap(box.low.x, box.high.x, region.low.x, region.high.x),
                       gap(box.low.y, box.high.y, region.low.y, region.high.y),
                       gap(box.low.z, box.high.z, region.low.z, region.high.z)};
      return length(apart);
    }
  }
  throw ContractError("border_distance: unknown kind");
}

}  // namespace

Vec3 read_vector(const YamlValue& value) {
  const auto items = value.items();
  if (items.size() != 3) value.fail_expected("three numbers [x, y, z]");
  return {items[0].number(), items[1].number(), items[2].number()};
}

Region read_region(const YamlFields& fields) {
  Region region;
  std::size_t found = 0;
  const auto read = [&](const char* key, void (*reader)(const YamlValue&, Region&)) {
    const auto value = fields.find(key);
    if (!value) return;
    ++found;
    region.text = key;
    region.where = value->file() + ":" + std::to_string(value->line());
    reader(*value, region);
  };
  read("sphere", read_sphere);
  read("half_space", read_half_space);
  read("box", read_box);
  if (found != 1) fields.self().fail("expected one region: sphere, half_space or box");
  return region;
}

Region place_region(Region region, const TetMesh& mesh) {
  const BoundingBox box = bounding_box(mesh.points);
  if (region.surface_direction) region.center = surface_point(region, mesh);
  if (region.radius_relative) region.radius = *region.radius_relative * longest_side(box);
  if (region.share) {
    double least = std::numeric_limits<double>::infinity();
    double greatest = -least;
    for (const Vec3& p : mesh.points) {
      least = std::min(least, dot(region.normal, p));
      greatest = std::max(greatest, dot(region.normal, p));
    }
    region.offset = least + *region.share * (greatest - least);
  }
  region.surface_direction.reset();
  region.radius_relative.reset();
  region.share.reset();
  return region;
}

bool is_inside(const Region& region, const Vec3& point, double tolerance) {
  switch (region.kind) {
    case Region::Kind::kSphere:
      return length(point - region.center) <= region.radius + tolerance;
    case Region::Kind::kHalfSpace:
      return dot(region.normal, point) <= region.offset + tolerance;
    case Region::Kind::kBox: {
      const Vec3 below = region.low - point;
      const Vec3 above = point - region.high;
      return std::max({below.x, below.y, below.z, above.x, above.y, above.z}) <= tolerance;
    }
  }
  throw ContractError("is_inside: unknown kind");
}

std::string unit_complaint(const Region& region, const TetMesh& mesh) {
  const BoundingBox box = bounding_box(mesh.points);
  const double side = longest_side(box);
  const double distance = border_distance(region, box);
  if (distance <= kFarAway * side) return "";
  return "its border is " + short_number(distance) + " m away from the mesh, which is " + short_number(side) +
         " m long: is it in metres, and is the mesh's unit right?";
}

}  // namespace palpate::experiments
