#include "core/dynamics/elasticity/volume_force.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "core/mesh/geometry.h"

namespace palpate::dynamics {
namespace {

struct State {
  std::vector<Vec3> points;
  Vec3 center;
  double volume_change = 0.0;
};

State find_state(const VolumeForce& volume_force, std::span<const Vec3> rest,
                 std::span<const Vec3> displacement) {
  require(rest.size() == displacement.size() && rest.size() == volume_force.center_weights.size(),
          "one point, displacement and weight a vertex");
  State state{std::vector<Vec3>(rest.size()), {}, 0.0};
  for (std::size_t v = 0; v < rest.size(); ++v) {
    state.points[v] = rest[v] + displacement[v];
    state.center = state.center + volume_force.center_weights[v] * state.points[v];
  }
  double volume = 0.0;
  for (const Tet& t : volume_force.tets)
    volume += signed_volume(state.points[t[0]], state.points[t[1]], state.points[t[2]], state.points[t[3]]);
  state.volume_change = volume - volume_force.rest_volume_m3;
  return state;
}

}  // namespace

VolumeForce build_volume_force(const TetMesh& mesh, double mean_spring_stiffness_n_per_m,
                               double stiffness_ratio) {
  if (!(stiffness_ratio >= 0.0) || !std::isfinite(stiffness_ratio))
    throw InputError("volume_force_ratio", 0, "a finite number >= 0", std::to_string(stiffness_ratio));
  const double half = 0.5 * longest_side(bounding_box(mesh.points));
  VolumeForce out{stiffness_ratio * mean_spring_stiffness_n_per_m / (half * half), 0.0, mesh.tets,
                  std::vector<double>(mesh.points.size())};
  const double share = 0.25 / static_cast<double>(mesh.tets.size());
  for (const Tet& t : mesh.tets) {
    for (const Index v : t) out.center_weights[v] += share;
    out.rest_volume_m3 +=
        signed_volume(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]);
  }
  return out;
}

void add_volume_force(const VolumeForce& volume_force, std::span<const Vec3> rest,
                      std::span<const Vec3> displacement, std::span<Vec3> force) {
  const State state = find_state(volume_force, rest, displacement);
  const double size = volume_force.stiffness_n_per_m3 * state.volume_change;
  for (std::size_t v = 0; v < rest.size(); ++v) {
    const Vec3 arm = state.center - state.points[v];
    const double distance = length(arm);
    if (distance > 0.0) force[v] = force[v] + (size / distance) * arm;
  }
}

VolumeForceTangent differentiate_volume_force(const VolumeForce& volume_force, std::span<const Vec3> rest,
                                              std::span<const Vec3> displacement) {
  const State state = find_state(volume_force, rest, displacement);
  const double size = volume_force.stiffness_n_per_m3 * state.volume_change;
  VolumeForceTangent out;
  out.direction.resize(rest.size());
  out.volume_gradient.resize(rest.size());
  out.turning.resize(rest.size());
  for (std::size_t v = 0; v < rest.size(); ++v) {
    const Vec3 arm = state.center - state.points[v];
    const double distance = length(arm);
    if (!(distance > 0.0)) continue;
    const Vec3 d = (1.0 / distance) * arm;
    const double turn = size / distance;
    out.direction[v] = d;
    out.turning[v] = {turn * (1.0 - d.x * d.x), -turn * d.x * d.y, -turn * d.x * d.z,
                      turn * (1.0 - d.y * d.y), -turn * d.y * d.z, turn * (1.0 - d.z * d.z)};
  }
  for (const Tet& t : volume_force.tets) {
    for (std::size_t k = 0; k < 4; ++k) {
      const auto corner = [&](int i) { return state.points[t[static_cast<std::size_t>(i)]]; };
      const auto& face = kTetFaces[k];
      // Volume grows by a third of the inward area of the opposite face for each unit that the vertex moves.
      const Vec3 inward =
          (-1.0 / 6.0) * cross(corner(face[1]) - corner(face[0]), corner(face[2]) - corner(face[0]));
      out.volume_gradient[t[k]] = out.volume_gradient[t[k]] + inward;
    }
  }
  return out;
}

}  // namespace palpate::dynamics
