#include "core/dynamics/reduced/rigid_frame.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/mesh/geometry.h"

namespace palpate::dynamics {
namespace {

constexpr std::array<Vec3, 3> kAxes{{{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}}};

std::size_t largest_component(const Vec3& v) {
  const std::array<double, 3> size{std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)};
  return static_cast<std::size_t>(std::max_element(size.begin(), size.end()) - size.begin());
}

/// The vertex for which `value` is largest; the first of equal ones.
template <typename Value>
std::size_t farthest(const TetMesh& mesh, const Value& value) {
  std::size_t best = 0;
  double most = -1.0;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const double here = value(mesh.points[v]);
    if (here > most) {
      most = here;
      best = v;
    }
  }
  return best;
}

}  // namespace

Vec3 RigidFrame::motion(std::size_t k, const Vec3& point) const {
  if (k < 3) return kAxes[k];
  return (1.0 / radius_m) * cross(kAxes[k - 3], point - center_m);
}

Vec3 RigidFrame::at(const std::array<double, 6>& amounts, const Vec3& point) const {
  const Vec3 turn{amounts[3], amounts[4], amounts[5]};
  return Vec3{amounts[0], amounts[1], amounts[2]} + (1.0 / radius_m) * cross(turn, point - center_m);
}

RigidFrame build_rigid_frame(const TetMesh& mesh) {
  RigidFrame frame;
  double volume = 0.0;
  Vec3 moment;
  for (const Tet& t : mesh.tets) {
    const Vec3& a = mesh.points[t[0]];
    const Vec3& b = mesh.points[t[1]];
    const Vec3& c = mesh.points[t[2]];
    const Vec3& d = mesh.points[t[3]];
    const double part = signed_volume(a, b, c, d);
    volume += part;
    moment = moment + (0.25 * part) * (a + b + c + d);
  }
  require(volume > 0.0, "a body of positive volume");
  frame.center_m = (1.0 / volume) * moment;
  frame.radius_m = 0.0;
  for (const Vec3& p : mesh.points) frame.radius_m = std::max(frame.radius_m, length(p - frame.center_m));
  return frame;
}

std::array<double, 6> work_of_weight(const TetMesh& mesh, const RigidFrame& frame, const Vec3& force_n_m3) {
  std::array<double, 6> work{};
  for (const Tet& t : mesh.tets) {
    const Vec3& a = mesh.points[t[0]];
    const Vec3& b = mesh.points[t[1]];
    const Vec3& c = mesh.points[t[2]];
    const Vec3& d = mesh.points[t[3]];
    const double volume = signed_volume(a, b, c, d);
    const Vec3 middle = 0.25 * (a + b + c + d);
    for (std::size_t k = 0; k < 6; ++k) work[k] += volume * dot(force_n_m3, frame.motion(k, middle));
  }
  return work;
}

std::vector<std::uint8_t> pin_statically(const TetMesh& mesh, const RigidFrame& frame) {
  std::vector<std::uint8_t> held(mesh.points.size(), 0);
  const std::size_t first = farthest(mesh, [&](const Vec3& p) { return length_sq(p - frame.center_m); });
  const Vec3 a = mesh.points[first];
  const std::size_t second = farthest(mesh, [&](const Vec3& p) { return length_sq(p - a); });
  const Vec3 along = mesh.points[second] - a;
  const std::size_t third = farthest(mesh, [&](const Vec3& p) { return length_sq(cross(along, p - a)); });
  const Vec3 normal = cross(along, mesh.points[third] - a);
  held[first] = 7;
  held[second] = static_cast<std::uint8_t>(7U & ~(1U << largest_component(along)));
  held[third] = static_cast<std::uint8_t>(1U << largest_component(normal));
  return held;
}

}  // namespace palpate::dynamics
