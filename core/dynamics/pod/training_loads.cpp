#include "core/dynamics/pod/training_loads.h"

#include <cmath>
#include <cstring>
#include <numbers>

#include "core/base/error.h"
#include "core/dynamics/linear_algebra/matrix3.h"

namespace palpate::dynamics {
namespace {

/// A rotation by `angle` about an axis (Rodrigues's formula).
Mat3 rotation_about(const Vec3& axis, double angle) {
  const Mat3 spin = cross_matrix(axis);
  return kIdentity + std::sin(angle) * spin + (1.0 - std::cos(angle)) * multiply(spin, spin);
}

Vec3 draw_direction(SplitMix64& random) {
  const double z = 2.0 * random.uniform() - 1.0;
  const double around = 2.0 * std::numbers::pi * random.uniform();
  const double r = std::sqrt(1.0 - z * z);
  return {r * std::cos(around), r * std::sin(around), z};
}

void require_trainable(const BoundaryProblem& problem) {
  const auto refuse = [](const char* found) {
    throw InputError("problem", 0, "pads, tractions, forces on vertices or weight to train on", found);
  };
  if (!problem.body_force_n_m3.empty() || !problem.held_field_m.empty()) refuse("a field that varies");
  for (const HeldFaces& held : problem.held) {
    if (length_sq(held.by_m) > 0.0) refuse("held faces that are moved");
  }
  bool has_load =
      length_sq(problem.gravity_m_s2) > 0.0 || !problem.nodal_forces.empty() || !problem.tractions.empty();
  for (const ElasticSupport& support : problem.supports) has_load = has_load || length_sq(support.by_m) > 0.0;
  if (!has_load) refuse("no load");
}

}  // namespace

BoundaryProblem draw_training_load(const BoundaryProblem& problem, SplitMix64& random) {
  require_trainable(problem);
  const double share = 0.2 + random.uniform();
  const Vec3 axis = draw_direction(random);
  const Mat3 turn = share * rotation_about(axis, 0.25 * std::numbers::pi * random.uniform());
  BoundaryProblem out = problem;
  out.gravity_m_s2 = turn * problem.gravity_m_s2;
  for (ElasticSupport& support : out.supports) support.by_m = turn * support.by_m;
  for (Traction& traction : out.tractions) {
    traction.traction_pa = turn * traction.traction_pa;
    traction.pressure_pa *= share;
  }
  for (NodalForce& force : out.nodal_forces) force.force_n = turn * force.force_n;
  return out;
}

std::uint64_t hash_load_places(const BoundaryProblem& problem) {
  std::uint64_t hash = 1469598103934665603ULL;
  const auto add = [&](std::uint64_t value) {
    for (unsigned shift = 0; shift < 64; shift += 8)
      hash = (hash ^ ((value >> shift) & 0xffU)) * 1099511628211ULL;
  };
  const auto add_number = [&](double value) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, sizeof bits);
    add(bits);
  };
  add(length_sq(problem.gravity_m_s2) > 0.0 ? 1 : 0);
  add(problem.supports.size());
  for (const ElasticSupport& support : problem.supports) add(length_sq(support.by_m) > 0.0 ? 1 : 0);
  add(problem.tractions.size());
  for (const Traction& traction : problem.tractions) {
    add(length_sq(traction.traction_pa) > 0.0 ? 1 : 0);
    add(traction.pressure_pa != 0.0 ? 1 : 0);
    add(traction.patch.faces.size());
    for (const Triangle& face : traction.patch.faces) {
      for (const Index v : face) add(v);
    }
    for (const double weight : traction.patch.weight) add_number(weight);
  }
  add(problem.nodal_forces.size());
  for (const NodalForce& force : problem.nodal_forces) add(force.vertex);
  return hash;
}

}  // namespace palpate::dynamics
