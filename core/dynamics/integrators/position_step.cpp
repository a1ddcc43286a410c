#include "core/dynamics/integrators/position_step.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/dynamics/integrators/neo_hookean_constraints.h"
#include "core/dynamics/integrators/strain_columns.h"
#include "core/dynamics/linear_algebra/vertex_field.h"
#include "core/dynamics/motion/vertex_incidence.h"

namespace palpate::dynamics {
namespace {

/// A strain term, and of each of its domains the multipliers and what corrects them.
struct ConstrainedTerm {
  const StrainTerm* term = nullptr;
  std::vector<Matrix6> correction;     ///< (1 + (h^2 + h b) K G)^-1, for inverse masses alike along all axes
  std::vector<std::uint8_t> is_mixed;  ///< a vertex is held along some axes alone: `correction` does not hold
  std::vector<Vector6> multiplier;
};

double spring_damping(const MotionModel& model, std::size_t s) {
  return model.spring_damping_n_s_per_m.empty() ? 0.0 : model.spring_damping_n_s_per_m[s];
}

Vec3 scaled(const Vec3& a, const Vec3& b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}

void require_takes(const MotionModel& model) {
  const auto refuse = [](const char* what) {
    throw InputError("integrator", 0, "a model of springs and strain energies of strains for xpbd", what);
  };
  if (model.elastic.volume_force) refuse("the thesis's volume force");
  if (!model.spring_damping_n_s_per_m.empty() && model.spring_damping == SpringDamping::kIsotropic)
    refuse("isotropic damping");
  for (const StrainTerm& term : model.elastic.strain_terms) {
    if (term.law == StrainLaw::kNeoHookean) refuse("the law neo_hookean");
  }
}

/// The modes of a face's mass (1 + delta_ij): (1, 1, 1) with 4, and two across with 1.
constexpr double kThird = 0.57735026918962576;
constexpr double kHalf = 0.70710678118654752;
constexpr double kSixth = 0.40824829046386302;
constexpr std::array<std::array<double, 3>, 3> kFaceModes{
    {{kThird, kThird, kThird}, {kHalf, -kHalf, 0.0}, {kSixth, kSixth, -2.0 * kSixth}}};
constexpr std::array<double, 3> kFaceWeights{4.0, 1.0, 1.0};

}  // namespace

struct PositionStep::Work {
  Work(const MotionForces& forces, const StepSolverOptions& given)
      : sweeper(forces, given), model(&forces.model()), held(&forces.held_bits()) {
    const std::size_t n = held->size();
    supports = list_supports(*model);
    for (const StrainTerm& term : model->elastic.strain_terms) {
      if (term.law == StrainLaw::kStableNeoHookean) {
        neo_hookean.emplace_back(term);
        continue;
      }
      ConstrainedTerm& state = terms.emplace_back();
      state.term = &term;
      for (std::size_t s = 0; s < term.op.domains(); ++s) {
        const auto vertices = term.op.vertices_of(s);
        state.is_mixed.push_back(std::any_of(vertices.begin(), vertices.end(),
                                             [&](Index v) { return (*held)[v] != 0 && (*held)[v] != 7; }));
      }
    }
    for (std::vector<Vec3>* field : {&inverse_mass, &dead_load}) field->resize(n);
  }

  /// What depends on the step alone.
  void prepare(double h) {
    if (h == step_s) return;
    step_s = h;
    for (std::size_t v = 0; v < inverse_mass.size(); ++v) {
      const double drag =
          model->environment_damping_n_s_per_m.empty() ? 0.0 : model->environment_damping_n_s_per_m[v];
      const double w = 1.0 / (model->mass_kg[v] + h * drag);
      inverse_mass[v] = {w, w, w};
    }
    clear_held(*held, inverse_mass);
    const double factor = h * h + h * model->strain_damping_s;
    for (ConstrainedTerm& state : terms) {
      const StrainOperator& op = state.term->op;
      state.correction.resize(op.domains());
      for (std::size_t s = 0; s < op.domains(); ++s)
        state.correction[s] = correct(state, s, kIdentity, factor);
    }
  }

  Matrix6 correct(const ConstrainedTerm& state, std::size_t s, const Mat3& r, double factor) const {
    return strain_correction(state.term->op, s, state.term->moduli, r, inverse_mass, factor);
  }

  void start(const MotionState& state, std::span<Vec3> u) {
    shares.clear();
    std::fill(dead_load.begin(), dead_load.end(), Vec3{});
    for (const TimedLoads& group : model->loads) {
      shares.push_back(value_at(group.profile, state.time_s + step_s).share);
      add_scaled(dead_load, shares.back(), group.loads.force_n);
    }
    for (std::size_t v = 0; v < u.size(); ++v) {
      // From u + h v to u + h W (m v + h f), which leaves held components where they are.
      const double drag =
          model->environment_damping_n_s_per_m.empty() ? 0.0 : model->environment_damping_n_s_per_m[v];
      u[v] = u[v] + step_s * scaled(inverse_mass[v],
                                    step_s * dead_load[v] - (step_s * drag) * state.velocity_m_s[v]);
    }
    spring_multiplier.assign(model->elastic.springs.springs.size(), 0.0);
    support_multiplier.assign(supports.size(), {});
    for (ConstrainedTerm& term : terms) term.multiplier.assign(term.term->op.domains(), Vector6::Zero());
    for (NeoHookeanConstraints& each : neo_hookean)
      each.start(step_s, model->strain_damping_s, state.displacement_m, inverse_mass);
  }

  void solve_spring(const MotionState& state, std::span<Vec3> u, std::size_t s) {
    const ElasticModel& elastic = model->elastic;
    const auto [a, b] = elastic.springs.springs[s];
    const Vec3 rest_edge = elastic.rest[b] - elastic.rest[a];
    const Vec3 moved = u[b] - u[a];
    const Vec3 edge = elastic.springs_are_linear ? rest_edge : rest_edge + moved;
    const double size = length(edge);
    if (!(size > 0.0)) return;
    const Vec3 n = (1.0 / size) * edge;
    const double elongation = elastic.springs_are_linear
                                  ? dot(n, moved)
                                  : spring_elongation(rest_edge, moved, elastic.springs.rest_length_m[s]);
    const double since = dot(n, moved - (state.displacement_m[b] - state.displacement_m[a]));
    const double stiffness = step_s * step_s * elastic.springs.stiffness_n_per_m[s];
    const double damping = step_s * spring_damping(*model, s);
    const Vec3 pull_a = scaled(inverse_mass[a], n);
    const Vec3 pull_b = scaled(inverse_mass[b], n);
    const double change = -(spring_multiplier[s] + stiffness * elongation + damping * since) /
                          (1.0 + (stiffness + damping) * dot(n, pull_a + pull_b));
    spring_multiplier[s] += change;
    u[a] = u[a] - change * pull_a;
    u[b] = u[b] + change * pull_b;
  }

  void solve_domain(const MotionState& state, std::span<Vec3> u, ConstrainedTerm& term, std::size_t s) {
    const StrainOperator& op = term.term->op;
    const double b = model->strain_damping_s;
    const Mat3 h = displacement_gradient(op, s, u);
    const bool is_linear = term.term->law == StrainLaw::kLinear;
    const Mat3 r = is_linear ? kIdentity : nearest_rotation(kIdentity + h);
    const Mat3 strain = is_linear ? h : multiply_transposed(r, kIdentity + h - r);
    Vector6 wanted = (step_s * step_s) * strains_of(strain);
    if (b != 0.0) {
      const Mat3 since = h - displacement_gradient(op, s, state.displacement_m);
      wanted += (step_s * b) * strains_of(multiply_transposed(r, since));
    }
    const Vector6 off = term.multiplier[s] + strain_stiffness(term.term->moduli, op.volume_m3[s]) * wanted;
    const Vector6 change =
        -((term.is_mixed[s] != 0 ? correct(term, s, r, step_s * step_s + step_s * b) : term.correction[s]) *
          off);
    term.multiplier[s] += change;
    const Mat3 pull = multiply(r, stress_of(change));
    for (Index k = op.offsets[s]; k < op.offsets[s + 1]; ++k) {
      const Index v = op.vertices[k];
      u[v] = u[v] + scaled(inverse_mass[v], pull * op.gradients[k]);
    }
  }

  void solve_support(std::span<Vec3> u, std::size_t at) {
    const TimedSupport& support = supports[at];
    const Triangle& face = support.face.face;
    const Vec3 place = shares[support.group] * support.face.by_m;
    for (std::size_t mode = 0; mode < 3; ++mode) {
      const std::array<double, 3>& e = kFaceModes.at(mode);
      const double stiffness = step_s * step_s * kFaceWeights.at(mode) * support.face.coefficient_n_per_m;
      Vec3 moved;
      Vec3 inverse;
      for (std::size_t i = 0; i < 3; ++i) {
        moved = moved + e.at(i) * (u[face[i]] - place);
        inverse = inverse + (e.at(i) * e.at(i)) * inverse_mass[face[i]];
      }
      Vec3& multiplier = support_multiplier[at].at(mode);
      const Vec3 off = multiplier + stiffness * moved;
      const Vec3 change{-off.x / (1.0 + stiffness * inverse.x), -off.y / (1.0 + stiffness * inverse.y),
                        -off.z / (1.0 + stiffness * inverse.z)};
      multiplier = multiplier + change;
      for (std::size_t i = 0; i < 3; ++i)
        u[face[i]] = u[face[i]] + e.at(i) * scaled(inverse_mass[face[i]], change);
    }
  }

  void sweep(const MotionState& state, std::span<Vec3> u, bool is_backward) {
    const auto each = [&](std::size_t count, const auto& solve_one) {
      for (std::size_t k = 0; k < count; ++k) solve_one(is_backward ? count - 1 - k : k);
    };
    const auto springs = [&] {
      each(spring_multiplier.size(), [&](std::size_t s) { solve_spring(state, u, s); });
    };
    const auto domains = [&] {
      each(terms.size(), [&](std::size_t t) {
        each(terms[t].term->op.domains(), [&](std::size_t s) { solve_domain(state, u, terms[t], s); });
      });
      each(neo_hookean.size(), [&](std::size_t t) {
        each(neo_hookean[t].size(), [&](std::size_t s) { neo_hookean[t].solve(s, u); });
      });
    };
    const auto faces = [&] { each(supports.size(), [&](std::size_t at) { solve_support(u, at); }); };
    if (is_backward) {
      faces();
      domains();
      springs();
    } else {
      springs();
      domains();
      faces();
    }
  }

  Sweeper sweeper;
  const MotionModel* model;
  const std::vector<std::uint8_t>* held;
  std::vector<TimedSupport> supports;
  std::vector<ConstrainedTerm> terms;
  std::vector<NeoHookeanConstraints> neo_hookean;  ///< terms of that law
  std::vector<double> spring_multiplier;
  std::vector<std::array<Vec3, 3>> support_multiplier;
  double step_s = 0.0;
  std::vector<double> shares;      ///< of each group of loads, at the end of the step
  std::vector<Vec3> inverse_mass;  ///< along each axis, in 1/kg
  std::vector<Vec3> dead_load;     ///< at the end of the step
};

PositionStep::PositionStep(const MotionForces& forces, const StepSolverOptions& options) {
  require_takes(forces.model());
  work_ = std::make_unique<Work>(forces, options);
}

PositionStep::~PositionStep() = default;
PositionStep::PositionStep(PositionStep&&) noexcept = default;
PositionStep& PositionStep::operator=(PositionStep&&) noexcept = default;

ImplicitResult PositionStep::find_displacement(MotionForces& forces, const MotionState& state, double step_s,
                                               std::span<Vec3> u) {
  Work& work = *work_;
  work.prepare(step_s);
  return work.sweeper.solve(forces, state, step_s, u, [&](std::size_t sweep) {
    if (sweep == 0) work.start(state, u);
    work.sweep(state, u, sweep % 2 == 1);
  });
}

}  // namespace palpate::dynamics
