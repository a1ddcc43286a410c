#include "experiments/contests/stability/driven_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/judge/mesh/tet_shape.h"
#include "core/mesh/geometry.h"

namespace palpate::experiments {
namespace {

constexpr double kDegrees = 180.0 / std::numbers::pi;

void check(const ExtremeMesh& wanted) {
  const auto check_one = [](const char* what, double value, double least) {
    if (!(value >= least) || !std::isfinite(value))
      throw InputError(what, 0, "a finite number of at least " + std::to_string(least),
                       std::to_string(value));
  };
  check_one("size_m", wanted.size_m, 0.0);
  check_one("size_ratio", wanted.size_ratio, 1.0);
  check_one("sliver_deg", wanted.sliver_deg, 0.0);
  check_one("coordinate_shift_m", wanted.coordinate_shift_m, -1e300);
  if (!(wanted.coordinate_scale > 0.0) || !std::isfinite(wanted.coordinate_scale))
    throw InputError("coordinate_scale", 0, "a finite number above zero",
                     std::to_string(wanted.coordinate_scale));
}

double longest_side(const TetMesh& mesh) {
  const BoundingBox box = bounding_box(mesh.points);
  const Vec3 size = box.high - box.low;
  return std::max({size.x, size.y, size.z});
}

void scale_to(TetMesh& mesh, double size) {
  const BoundingBox box = bounding_box(mesh.points);
  const double factor = size / longest_side(mesh);
  for (Vec3& p : mesh.points) p = factor * (p - box.low);
}

/// Turns the axes, in their cyclic order, so that x is the longest.
void turn_longest_to_x(TetMesh& mesh) {
  const BoundingBox box = bounding_box(mesh.points);
  const Vec3 size = box.high - box.low;
  if (size.x >= size.y && size.x >= size.z) return;
  const bool is_y = size.y >= size.z;
  for (Vec3& p : mesh.points) p = is_y ? Vec3{p.y, p.z, p.x} : Vec3{p.z, p.x, p.y};
}

void grade(TetMesh& mesh, double ratio) {
  const double size = longest_side(mesh);
  const BoundingBox box = bounding_box(mesh.points);
  const Vec3 middle = 0.5 * (box.low + box.high);
  for (Vec3& p : mesh.points) {
    const double here = std::pow(ratio, (p.x - box.low.x) / size);
    const double across = here * std::log(ratio) / size;
    p = {here, across * (p.y - middle.y), across * (p.z - middle.z)};
  }
  scale_to(mesh, size);
}

judge::TetShape shape_of(const TetMesh& mesh, const Tet& t) {
  return judge::measure_tet(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]);
}

/// Moves the tet's vertex `corner` towards the opposite face until its smallest dihedral angle is `wanted`.
/// Puts it back and says false if a tet around does not stay positive.
bool flatten(TetMesh& mesh, const std::vector<Index>& around, const Tet& tet, std::size_t corner,
             double wanted) {
  Vec3& p = mesh.points[tet.at(corner)];
  const Vec3 before = p;
  std::array<Vec3, 3> face;
  for (std::size_t k = 0, at = 0; k < 4; ++k) {
    if (k != corner) face.at(at++) = mesh.points[tet.at(k)];
  }
  const Vec3 normal = cross(face[1] - face[0], face[2] - face[0]);
  const Vec3 drop = (dot(before - face[0], normal) / length_sq(normal)) * normal;
  double low = 0.0;  // share of the height that is left
  double high = 1.0;
  for (int k = 0; k < 80; ++k) {
    const double middle = low > 0.0 ? std::sqrt(low * high) : 0.5 * high;
    p = before - (1.0 - middle) * drop;
    const bool is_flat = shape_of(mesh, tet).min_dihedral < wanted;
    (is_flat ? low : high) = middle;
  }
  p = before - (1.0 - high) * drop;
  const bool is_good = std::all_of(around.begin(), around.end(), [&](Index t) {
    return shape_of(mesh, mesh.tets[t]).min_dihedral >= 0.5 * wanted;
  });
  if (!is_good) p = before;
  return is_good;
}

std::size_t add_slivers(TetMesh& mesh, double wanted, std::uint64_t seed) {
  std::vector<std::vector<Index>> around(mesh.points.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (const Index v : mesh.tets[t]) around[v].push_back(static_cast<Index>(t));
  }
  SplitMix64 random(seed);
  const std::size_t most = std::max<std::size_t>(1, mesh.tets.size() / 20);
  std::vector<bool> is_taken(mesh.points.size(), false);
  std::size_t flattened = 0;
  for (std::size_t tries = 0; tries < 50 * most && flattened < most; ++tries) {
    const Tet& tet = mesh.tets[random.below(mesh.tets.size())];
    const std::size_t corner = random.below(4);
    if (std::any_of(tet.begin(), tet.end(), [&](Index v) { return is_taken[v]; })) continue;
    if (shape_of(mesh, tet).min_dihedral <= wanted) continue;
    if (!flatten(mesh, around[tet.at(corner)], tet, corner, wanted)) continue;
    for (const Index v : tet) is_taken[v] = true;
    ++flattened;
  }
  return flattened;
}

}  // namespace

DrivenMesh drive_mesh(TetMesh mesh, const ExtremeMesh& wanted) {
  check(wanted);
  turn_longest_to_x(mesh);
  if (wanted.size_m > 0.0) scale_to(mesh, wanted.size_m);
  if (wanted.size_ratio > 1.0) grade(mesh, wanted.size_ratio);
  DrivenMesh out;
  if (wanted.sliver_deg > 0.0) out.flattened = add_slivers(mesh, wanted.sliver_deg / kDegrees, wanted.seed);
  const double shift = wanted.coordinate_shift_m;
  for (Vec3& p : mesh.points) p = wanted.coordinate_scale * p + Vec3{shift, shift, shift};
  out.min_dihedral_deg = 180.0;
  for (const Tet& tet : mesh.tets)
    out.min_dihedral_deg = std::min(out.min_dihedral_deg, kDegrees * shape_of(mesh, tet).min_dihedral);
  out.mesh = std::move(mesh);
  return out;
}

}  // namespace palpate::experiments
