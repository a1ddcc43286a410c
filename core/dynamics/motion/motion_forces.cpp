#include "core/dynamics/motion/motion_forces.h"

#include <algorithm>
#include <array>
#include <atomic>

#include "core/base/component.h"
#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/dynamics/linear_algebra/vertex_field.h"

namespace palpate::dynamics {
namespace {

/// The force on the first end of a spring.
Vec3 spring_pull(const MotionModel& model, std::span<const Vec3> u, std::span<const Vec3> v, std::size_t s,
                 bool& is_zero) {
  const ElasticModel& elastic = model.elastic;
  const auto [a, b] = elastic.springs.springs[s];
  const Vec3 rest_edge = elastic.rest[b] - elastic.rest[a];
  const Vec3 change = u[b] - u[a];
  const Vec3 edge = elastic.springs_are_linear ? rest_edge : rest_edge + change;
  const double size = length(edge);
  is_zero = !(size > 0.0);
  if (is_zero) return {};
  const double elongation = elastic.springs_are_linear
                                ? dot(rest_edge, change) / size
                                : spring_elongation(rest_edge, change, elastic.springs.rest_length_m[s]);
  double along = elastic.springs.stiffness_n_per_m[s] * elongation / size;
  if (model.spring_damping_n_s_per_m.empty()) return along * edge;
  const Vec3 approach = v[b] - v[a];
  const double damping = model.spring_damping_n_s_per_m[s];
  if (model.spring_damping == SpringDamping::kIsotropic) return along * edge + damping * approach;
  along += damping * dot(approach, edge) / (size * size);
  return along * edge;
}

/// The moduli of a term's damping, in Pa s.
Moduli viscous_moduli(const MotionModel& model, const StrainTerm& term) {
  return {model.strain_damping_s * term.moduli.lambda_pa, model.strain_damping_s * term.moduli.mu_pa};
}

}  // namespace

MotionForces::MotionForces(const MotionModel& model, int threads) : model_(&model), threads_(threads) {
  validate(model);
  const std::size_t n = model.elastic.rest.size();
  held_ = find_held(model);
  held_bits_.resize(n);
  for (const HeldComponent& each : held_)
    held_bits_[each.vertex] = static_cast<std::uint8_t>(held_bits_[each.vertex] | (1U << each.axis));
  spring_ends_ = list_spring_ends(model);
  pull_.resize(model.elastic.springs.springs.size());
  for (const StrainTerm& term : model.elastic.strain_terms) {
    term_entries_.push_back(list_by_vertex(n, term.op.vertices));
    domain_of_entry_.push_back(list_domains(term.op));
    stress_.emplace_back(term.op.domains());
  }
}

std::size_t MotionForces::pull_springs(std::span<const Vec3> u, std::span<const Vec3> v) {
  std::atomic<std::size_t> zero_length{0};
  for_ranges(pull_.size(), threads_, [&](std::size_t first, std::size_t last, std::size_t) {
    std::size_t zero_here = 0;
    for (std::size_t s = first; s < last; ++s) {
      bool is_zero = false;
      pull_[s] = spring_pull(*model_, u, v, s, is_zero);
      zero_here += is_zero ? 1 : 0;
    }
    zero_length += zero_here;
  });
  return zero_length;
}

void MotionForces::stress_domains(std::span<const Vec3> u, std::span<const Vec3> v) {
  const bool is_damped = model_->strain_damping_s != 0.0;
  for (std::size_t k = 0; k < stress_.size(); ++k) {
    const StrainTerm& term = model_->elastic.strain_terms[k];
    const Moduli viscous = viscous_moduli(*model_, term);
    for_ranges(stress_[k].size(), threads_, [&](std::size_t first, std::size_t last, std::size_t) {
      for (std::size_t s = first; s < last; ++s) {
        const Mat3 h = displacement_gradient(term.op, s, u);
        Mat3 p = stress(term.law, term.moduli, h);
        if (is_damped) p += damping_stress(term.law, viscous, h, displacement_gradient(term.op, s, v));
        stress_[k][s] = (-term.op.volume_m3[s]) * p;
      }
    });
  }
}

void MotionForces::gather(std::span<const Vec3> v, std::span<Vec3> force) const {
  const std::vector<double>& drag = model_->environment_damping_n_s_per_m;
  for_ranges(force.size(), threads_, [&](std::size_t first, std::size_t last, std::size_t) {
    for (std::size_t i = first; i < last; ++i) {
      Vec3 sum;
      for (const Index end : spring_ends_.of(i)) {
        sum = end % 2 == 0 ? sum + pull_[end / 2] : sum - pull_[end / 2];
      }
      for (std::size_t t = 0; t < term_entries_.size(); ++t) {
        const StrainOperator& op = model_->elastic.strain_terms[t].op;
        for (const Index entry : term_entries_[t].of(i)) {
          sum = sum + stress_[t][domain_of_entry_[t][entry]] * op.gradients[entry];
        }
      }
      if (!drag.empty()) sum = sum - drag[i] * v[i];
      force[i] = sum;
    }
  });
}

std::size_t MotionForces::evaluate(std::span<const Vec3> u, std::span<const Vec3> v, double time_s,
                                   std::span<Vec3> force) {
  const std::size_t n = model_->elastic.rest.size();
  require(u.size() == n && v.size() == n && force.size() == n, "one entry a vertex");
  const std::size_t zero_length = pull_springs(u, v);
  stress_domains(u, v);
  gather(v, force);
  if (model_->elastic.volume_force)
    add_volume_force(*model_->elastic.volume_force, model_->elastic.rest, u, force);
  for (const TimedLoads& group : model_->loads)
    add_load_forces(group.loads, u, value_at(group.profile, time_s).share, force);
  return zero_length;
}

std::vector<Vec3> MotionForces::group_forces(const MotionState& state) {
  std::vector<Vec3> force(state.displacement_m.size());
  evaluate(state.displacement_m, state.velocity_m_s, state.time_s, force);
  std::vector<Vec3> out(model_->loads.size());
  for (const HeldComponent& each : held_) {
    const ProfileValue profile = value_at(model_->loads[each.group].profile, state.time_s);
    const double inertia = model_->mass_kg[each.vertex] * profile.acceleration_per_s2 * each.by_m;
    component(out[each.group], each.axis) += inertia - component(force[each.vertex], each.axis);
  }
  for (std::size_t g = 0; g < out.size(); ++g) {
    std::fill(force.begin(), force.end(), Vec3{});
    const TimedLoads& group = model_->loads[g];
    add_load_forces(group.loads, state.displacement_m, value_at(group.profile, state.time_s).share, force);
    for (const Vec3& f : force) out[g] = out[g] + f;
  }
  return out;
}

void MotionForces::impose(double time_s, std::span<Vec3> u, std::span<Vec3> v) const {
  if (held_.empty()) return;
  std::vector<ProfileValue> profiles;
  profiles.reserve(model_->loads.size());
  for (const TimedLoads& group : model_->loads) profiles.push_back(value_at(group.profile, time_s));
  for (const HeldComponent& each : held_) {
    const ProfileValue& profile = profiles[each.group];
    component(u[each.vertex], each.axis) = profile.share * each.by_m;
    component(v[each.vertex], each.axis) = profile.rate_per_s * each.by_m;
  }
}

BlockMatrix build_motion_pattern(const MotionModel& model) {
  std::vector<Triangle> faces;
  for (const TimedSupport& support : list_supports(model)) faces.push_back(support.face.face);
  return build_tangent_pattern(model.elastic, faces);
}

void add_motion_stiffness(const MotionModel& model, std::span<const Vec3> u, TangentKind kind,
                          BlockMatrix& matrix) {
  add_tangent(model.elastic, u, kind, matrix);
  for (const TimedLoads& group : model.loads) add_support_tangent(group.loads, matrix);
}

namespace {

void add_spring_damping(const MotionModel& model, std::span<const Vec3> u, double scale,
                        BlockMatrix& matrix) {
  const ElasticModel& elastic = model.elastic;
  for (std::size_t s = 0; s < model.spring_damping_n_s_per_m.size(); ++s) {
    const auto [a, b] = elastic.springs.springs[s];
    Vec3 edge = elastic.rest[b] - elastic.rest[a];
    if (!elastic.springs_are_linear) edge = edge + (u[b] - u[a]);
    const double size = length(edge);
    if (!(size > 0.0)) continue;
    const Vec3 n = (1.0 / size) * edge;
    const Mat3 block = (scale * model.spring_damping_n_s_per_m[s]) *
                       (model.spring_damping == SpringDamping::kAxial ? outer(n, n) : kIdentity);
    add_block(matrix, a, a, block);
    add_block(matrix, b, b, block);
    add_block(matrix, a, b, (-1.0) * block);
    add_block(matrix, b, a, (-1.0) * block);
  }
}

}  // namespace

void add_changing_damping(const MotionModel& model, std::span<const Vec3> u, BlockMatrix& matrix) {
  add_spring_damping(model, u, 1.0, matrix);
  if (model.strain_damping_s == 0.0) return;
  for (const StrainTerm& term : model.elastic.strain_terms) {
    if (term.law == StrainLaw::kLinear) continue;
    const auto at = [&](std::size_t s) {
      return damping_tangent(term.law, viscous_moduli(model, term), displacement_gradient(term.op, s, u));
    };
    add_domain_tangents(term.op, at, matrix);
  }
}

void add_motion_tangent(const MotionModel& model, std::span<const Vec3> u, TangentKind kind,
                        double rate_per_s, BlockMatrix& matrix) {
  std::function<Tangent9(const StrainTerm&, const Mat3&)> damping;
  if (model.strain_damping_s != 0.0) {
    damping = [&](const StrainTerm& term, const Mat3& h) {
      Tangent9 c = damping_tangent(term.law, viscous_moduli(model, term), h);
      for (double& entry : c) entry *= rate_per_s;
      return c;
    };
  }
  add_tangent(model.elastic, u, kind, matrix, damping);
  for (const TimedLoads& group : model.loads) add_support_tangent(group.loads, matrix);
  add_spring_damping(model, u, rate_per_s, matrix);
}

bool is_linear_body(const MotionModel& model) {
  const ElasticModel& elastic = model.elastic;
  const bool has_linear_springs = elastic.springs.springs.empty() || elastic.springs_are_linear;
  return has_linear_springs && !elastic.volume_force &&
         std::all_of(elastic.strain_terms.begin(), elastic.strain_terms.end(),
                     [](const StrainTerm& term) { return term.law == StrainLaw::kLinear; });
}

void add_constant_damping(const MotionModel& model, BlockMatrix& matrix) {
  for (std::size_t v = 0; v < model.environment_damping_n_s_per_m.size(); ++v)
    add_block(matrix, static_cast<Index>(v), static_cast<Index>(v),
              model.environment_damping_n_s_per_m[v] * kIdentity);
  if (model.strain_damping_s == 0.0) return;
  for (const StrainTerm& term : model.elastic.strain_terms) {
    if (term.law != StrainLaw::kLinear) continue;
    const Tangent9 c = damping_tangent(term.law, viscous_moduli(model, term), {});
    add_domain_tangents(
        term.op, [&c](std::size_t) { return c; }, matrix);
  }
}

}  // namespace palpate::dynamics
