#include "core/dynamics/motion/motion_model.h"

#include <cmath>
#include <cstring>
#include <string>

#include "core/base/component.h"
#include "core/base/error.h"
#include "core/dynamics/linear_algebra/vertex_field.h"
#include "core/mesh/geometry.h"

namespace palpate::dynamics {
namespace {

void check_sizes(const MotionModel& model) {
  const std::size_t n = model.elastic.rest.size();
  require(model.mass_kg.size() == n, "one mass a vertex");
  require(model.spring_damping_n_s_per_m.empty() ||
              model.spring_damping_n_s_per_m.size() == model.elastic.springs.springs.size(),
          "one damping a spring");
  require(model.environment_damping_n_s_per_m.empty() || model.environment_damping_n_s_per_m.size() == n,
          "one damping a vertex");
  for (const TimedLoads& group : model.loads)
    require(
        group.loads.force_n.size() == n && group.loads.held.size() == n && group.loads.held_by_m.size() == n,
        "one force and one flag a vertex");
}

void check_not_negative(const std::vector<double>& values, const char* where) {
  for (const double value : values) {
    if (!(value >= 0.0) || !std::isfinite(value))
      throw InputError(where, 0, "finite numbers >= 0", std::to_string(value));
  }
}

}  // namespace

void validate(const MotionModel& model) {
  check_sizes(model);
  for (std::size_t v = 0; v < model.mass_kg.size(); ++v) {
    if (!(model.mass_kg[v] > 0.0) || !std::isfinite(model.mass_kg[v]))
      throw InputError("mass", 0, "finite masses above zero",
                       std::to_string(model.mass_kg[v]) + " kg at vertex " + std::to_string(v));
  }
  check_not_negative(model.spring_damping_n_s_per_m, "spring damping");
  check_not_negative(model.environment_damping_n_s_per_m, "environment damping");
  check_not_negative({model.strain_damping_s}, "strain damping");
  for (const TimedLoads& group : model.loads) validate(group.profile);
  const std::vector<HeldComponent> held = find_held(model);
  for (std::size_t k = 1; k < held.size(); ++k) {
    if (held[k].vertex == held[k - 1].vertex && held[k].axis == held[k - 1].axis)
      throw InputError("held", 0, "one prescribed motion for vertex " + std::to_string(held[k].vertex),
                       "two");
  }
}

std::vector<double> build_lumped_masses(const TetMesh& mesh, double density_kg_m3) {
  if (!(density_kg_m3 > 0.0) || !std::isfinite(density_kg_m3))
    throw InputError("density_kg_m3", 0, "a finite number above zero", std::to_string(density_kg_m3));
  std::vector<double> mass(mesh.points.size());
  for (const Tet& t : mesh.tets) {
    const double volume =
        signed_volume(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]);
    for (const Index v : t) mass[v] += 0.25 * density_kg_m3 * volume;
  }
  for (std::size_t v = 0; v < mass.size(); ++v) {
    if (!(mass[v] > 0.0)) throw InputError("mesh", 0, "tets around vertex " + std::to_string(v), "no volume");
  }
  return mass;
}

std::vector<HeldComponent> find_held(const MotionModel& model) {
  std::vector<HeldComponent> held;
  for (std::size_t v = 0; v < model.elastic.rest.size(); ++v) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      for (std::size_t g = 0; g < model.loads.size(); ++g) {
        const Loads& loads = model.loads[g].loads;
        if (((static_cast<unsigned>(loads.held[v]) >> axis) & 1U) == 0) continue;
        held.push_back({static_cast<Index>(v), static_cast<std::uint8_t>(axis), static_cast<std::uint32_t>(g),
                        component(loads.held_by_m[v], axis)});
      }
    }
  }
  return held;
}

MotionState start_at_rest(const MotionModel& model) {
  const std::size_t n = model.elastic.rest.size();
  MotionState state{0.0, std::vector<Vec3>(n), std::vector<Vec3>(n)};
  for (const HeldComponent& held : find_held(model)) {
    const ProfileValue profile = value_at(model.loads[held.group].profile, 0.0);
    component(state.displacement_m[held.vertex], held.axis) = profile.share * held.by_m;
    component(state.velocity_m_s[held.vertex], held.axis) = profile.rate_per_s * held.by_m;
  }
  return state;
}

MotionEnergy measure_energy(const MotionModel& model, const MotionState& state) {
  MotionEnergy energy;
  for (std::size_t v = 0; v < state.velocity_m_s.size(); ++v)
    energy.kinetic_j += 0.5 * model.mass_kg[v] * length_sq(state.velocity_m_s[v]);
  energy.elastic_j = elastic_energy(model.elastic, state.displacement_m);
  for (const TimedLoads& group : model.loads)
    energy.load_j +=
        load_energy(group.loads, state.displacement_m, value_at(group.profile, state.time_s).share);
  return energy;
}

Vec3 measure_momentum(const MotionModel& model, const MotionState& state) {
  Vec3 sum;
  for (std::size_t v = 0; v < state.velocity_m_s.size(); ++v)
    sum = sum + model.mass_kg[v] * state.velocity_m_s[v];
  return sum;
}

VolumeCount count_volume(const MotionModel& model, const MotionState& state) {
  VolumeCount count;
  const auto at = [&](Index v) { return model.elastic.rest[v] + state.displacement_m[v]; };
  for (std::size_t t = 0; t < model.tets.size(); ++t) {
    const auto [a, b, c, d] = model.tets[t];
    const double volume = signed_volume(at(a), at(b), at(c), at(d));
    count.volume_m3 += volume;
    if (volume > 0.0) continue;
    if (count.inverted == 0) count.first_inverted = static_cast<Index>(t);
    ++count.inverted;
  }
  return count;
}

std::uint64_t hash_state(const MotionState& state) {
  std::uint64_t hash = 14695981039346656037ULL;
  const auto add = [&hash](double value) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);  // std::bit_cast is not in every library that this is built with
    for (int byte = 0; byte < 8; ++byte, bits >>= 8U) hash = (hash ^ (bits & 0xffU)) * 1099511628211ULL;
  };
  add(state.time_s);
  for (const std::vector<Vec3>* field : {&state.displacement_m, &state.velocity_m_s}) {
    for (const Vec3& each : *field) {
      add(each.x);
      add(each.y);
      add(each.z);
    }
  }
  return hash;
}

}  // namespace palpate::dynamics
