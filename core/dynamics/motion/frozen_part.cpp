#include "core/dynamics/motion/frozen_part.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>

#include "core/base/error.h"

namespace palpate::dynamics {
namespace {

constexpr std::uint8_t kAllAxes = 7;

std::vector<bool> mark_frozen(std::span<const Index> frozen, std::size_t vertices) {
  std::vector<bool> is_frozen(vertices, false);
  for (const Index v : frozen) {
    if (v >= vertices)
      throw InputError("frozen", 0, "vertices below " + std::to_string(vertices), std::to_string(v));
    is_frozen[v] = true;
  }
  return is_frozen;
}

/// Keeps the domains of an operator that some vertex can strain.
std::size_t drop_domains(const std::vector<bool>& is_frozen, StrainOperator& op) {
  StrainOperator left;
  left.offsets.push_back(0);
  for (std::size_t s = 0; s < op.domains(); ++s) {
    const auto vertices = op.vertices_of(s);
    const bool is_still =
        std::all_of(vertices.begin(), vertices.end(), [&](Index v) { return is_frozen[v]; });
    if (is_still) continue;
    const auto gradients = op.gradients_of(s);
    left.volume_m3.push_back(op.volume_m3[s]);
    left.vertices.insert(left.vertices.end(), vertices.begin(), vertices.end());
    left.gradients.insert(left.gradients.end(), gradients.begin(), gradients.end());
    left.offsets.push_back(static_cast<Index>(left.vertices.size()));
  }
  const std::size_t dropped = op.domains() - left.domains();
  op = std::move(left);
  return dropped;
}

std::size_t drop_springs(const std::vector<bool>& is_frozen, SpringNetwork& net) {
  std::size_t kept = 0;
  for (std::size_t s = 0; s < net.springs.size(); ++s) {
    if (is_frozen[net.springs[s][0]] && is_frozen[net.springs[s][1]]) continue;
    net.springs[kept] = net.springs[s];
    net.rest_length_m[kept] = net.rest_length_m[s];
    net.stiffness_n_per_m[kept] = net.stiffness_n_per_m[s];
    ++kept;
  }
  const std::size_t dropped = net.springs.size() - kept;
  net.springs.resize(kept);
  net.rest_length_m.resize(kept);
  net.stiffness_n_per_m.resize(kept);
  return dropped;
}

}  // namespace

void hold_frozen(std::span<const Index> frozen, Loads& loads) {
  mark_frozen(frozen, loads.held.size());
  for (const Index v : frozen) {
    if (length_sq(loads.held_by_m[v]) > 0.0)
      throw InputError("frozen", 0, "vertices that no load moves", "vertex " + std::to_string(v));
    loads.held[v] = kAllAxes;
  }
}

FrozenCount drop_frozen(std::span<const Index> frozen, ElasticModel& model) {
  FrozenCount count;
  if (frozen.empty()) return count;
  if (model.volume_force)
    throw InputError("frozen", 0, "a model without the thesis's volume force", "one with it");
  const std::vector<bool> is_frozen = mark_frozen(frozen, model.rest.size());
  count.springs = drop_springs(is_frozen, model.springs);
  for (StrainTerm& term : model.strain_terms) count.domains += drop_domains(is_frozen, term.op);
  return count;
}

double frozen_force(std::span<const Index> frozen, std::span<const Vec3> force_n) {
  double squares = 0.0;
  for (const Index v : frozen) squares += length_sq(force_n[v]);
  return std::sqrt(squares);
}

}  // namespace palpate::dynamics
