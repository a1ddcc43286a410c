#include "core/dynamics/elasticity/elastic_model.h"

#include <cmath>

#include "core/base/error.h"

namespace palpate::dynamics {
namespace {

void check_sizes(const ElasticModel& model, std::size_t displacements) {
  require(model.rest.size() == displacements, "one displacement a vertex");
  require(model.springs.springs.size() == model.springs.stiffness_n_per_m.size() &&
              model.springs.springs.size() == model.springs.rest_length_m.size(),
          "one length and one stiffness a spring");
}

struct SpringState {
  Vec3 rest_edge;
  Vec3 change;
};

SpringState spring_state(const ElasticModel& model, std::span<const Vec3> u, std::size_t s) {
  const auto [a, b] = model.springs.springs[s];
  return {model.rest[b] - model.rest[a], u[b] - u[a]};
}

}  // namespace

double spring_elongation(const Vec3& rest_edge, const Vec3& change, double rest_length) {
  const double now = length(rest_edge + change);
  // An own rest length that is the mesh's to rounding must not leave a difference of rounding errors behind.
  const double mesh_length = length(rest_edge);
  const double preload = (mesh_length - rest_length) * (mesh_length + rest_length);
  const double both = now + rest_length;
  return both > 0.0 ? (2.0 * dot(rest_edge, change) + length_sq(change) + preload) / both : 0.0;
}

double elastic_energy(const ElasticModel& model, std::span<const Vec3> displacement) {
  check_sizes(model, displacement.size());
  double energy = 0.0;
  for (std::size_t s = 0; s < model.springs.springs.size(); ++s) {
    const SpringState state = spring_state(model, displacement, s);
    const double elongation =
        model.springs_are_linear
            ? dot(state.rest_edge, state.change) / length(state.rest_edge)
            : spring_elongation(state.rest_edge, state.change, model.springs.rest_length_m[s]);
    energy += 0.5 * model.springs.stiffness_n_per_m[s] * elongation * elongation;
  }
  for (const StrainTerm& term : model.strain_terms) {
    for (std::size_t s = 0; s < term.op.domains(); ++s)
      energy += term.op.volume_m3[s] *
                energy_density(term.law, term.moduli, displacement_gradient(term.op, s, displacement));
  }
  return energy;
}

std::size_t add_elastic_forces(const ElasticModel& model, std::span<const Vec3> displacement,
                               std::span<Vec3> force) {
  check_sizes(model, displacement.size());
  require(force.size() == displacement.size(), "one force a vertex");
  std::size_t zero_length = 0;
  for (std::size_t s = 0; s < model.springs.springs.size(); ++s) {
    const SpringState state = spring_state(model, displacement, s);
    const Vec3 edge = model.springs_are_linear ? state.rest_edge : state.rest_edge + state.change;
    const double size = length(edge);
    if (!(size > 0.0)) {
      ++zero_length;
      continue;
    }
    const double elongation = model.springs_are_linear ? dot(state.rest_edge, state.change) / size
                                                       : spring_elongation(state.rest_edge, state.change,
                                                                           model.springs.rest_length_m[s]);
    const Vec3 pull = (model.springs.stiffness_n_per_m[s] * elongation / size) * edge;
    const auto [a, b] = model.springs.springs[s];
    force[a] = force[a] + pull;
    force[b] = force[b] - pull;
  }
  for (const StrainTerm& term : model.strain_terms) {
    for (std::size_t s = 0; s < term.op.domains(); ++s) {
      const Mat3 p = (-term.op.volume_m3[s]) *
                     stress(term.law, term.moduli, displacement_gradient(term.op, s, displacement));
      const std::span<const Index> vertices = term.op.vertices_of(s);
      const std::span<const Vec3> gradients = term.op.gradients_of(s);
      for (std::size_t k = 0; k < vertices.size(); ++k)
        force[vertices[k]] = force[vertices[k]] + p * gradients[k];
    }
  }
  if (model.volume_force) add_volume_force(*model.volume_force, model.rest, displacement, force);
  return zero_length;
}

}  // namespace palpate::dynamics
