#include "core/dynamics/integrators/vertex_descent_step.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/base/component.h"
#include "core/base/error.h"
#include "core/dynamics/elasticity/vertex_stiffness.h"
#include "core/dynamics/linear_algebra/vertex_field.h"
#include "core/dynamics/motion/vertex_incidence.h"

namespace palpate::dynamics {
namespace {

/// x with a x = b of a positive definite matrix, held components zero; false where it is not definite.
bool solve_block(Mat3 a, Vec3 b, std::uint8_t held, Vec3& x) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (((static_cast<unsigned>(held) >> axis) & 1U) == 0) continue;
    for (std::size_t other = 0; other < 3; ++other) a(axis, other) = a(other, axis) = 0.0;
    a(axis, axis) = 1.0;
    component(b, axis) = 0.0;
  }
  const double det = determinant(a);
  const double minor = a(0, 0) * a(1, 1) - a(0, 1) * a(1, 0);
  if (!(a(0, 0) > 0.0 && minor > 0.0 && det > 0.0) || !std::isfinite(det)) return false;
  x = (1.0 / det) * (transpose(cofactors(a)) * b);
  return true;
}

/// The integral of a function over [0, 1] by Simpson's rule, exact for cubics, which is what the damping of
/// kStableNeoHookean does along a straight way.
template <typename Function>
double along_the_way(const Function& at) {
  return (at(0.0) + 4.0 * at(0.5) + at(1.0)) / 6.0;
}

/// Whether the damping of a law has another block than its stiffness.
bool grows_with_strain(StrainLaw law) {
  return law == StrainLaw::kNeoHookean || law == StrainLaw::kStableNeoHookean;
}

/// Whether an inverted domain has no energy, or one with a kink where its rotation changes.
bool minds_inversion(StrainLaw law) {
  return law == StrainLaw::kNeoHookean || law == StrainLaw::kCorotated;
}

/// A strain term with the gradients of its domains, kept as the vertices move.
struct DescentTerm {
  const StrainTerm* term = nullptr;
  VertexLists entries;                ///< entries of the operator at each vertex
  std::vector<Index> domain_of;       ///< of each entry
  std::vector<Mat3> gradient;         ///< H of each domain
  std::vector<Mat3> gradient_before;  ///< at the start of the step
};

}  // namespace

struct VertexDescentStep::Work {
  Work(const MotionForces& forces, const StepSolverOptions& given)
      : sweeper(forces, given), model(&forces.model()), held(&forces.held_bits()) {
    const std::size_t n = held->size();
    spring_ends = list_spring_ends(*model);
    supports = list_supports(*model);
    std::vector<Index> corners;
    for (const TimedSupport& support : supports)
      corners.insert(corners.end(), support.face.face.begin(), support.face.face.end());
    support_corners = list_by_vertex(n, corners);
    for (const StrainTerm& term : model->elastic.strain_terms) {
      minds = minds || minds_inversion(term.law);
      DescentTerm& state = terms.emplace_back();
      state.term = &term;
      state.entries = list_by_vertex(n, term.op.vertices);
      state.domain_of = list_domains(term.op);
    }
    dead_load.resize(n);
    reach_m.assign(n, std::numeric_limits<double>::infinity());
  }

  /// How far a vertex may go without a look at its energy: a tenth of its shortest spring and of its lowest
  /// domain, and less where damping rules.
  void set_reach() {
    constexpr double kShare = 0.1;
    const double b = model->strain_damping_s;
    const double damped = b > step_s ? std::sqrt(step_s / b) : 1.0;
    std::fill(reach_m.begin(), reach_m.end(), std::numeric_limits<double>::infinity());
    const auto bound = [&](Index v, double by) { reach_m[v] = std::min(reach_m[v], kShare * by); };
    const SpringNetwork& net = model->elastic.springs;
    for (std::size_t s = 0; s < net.springs.size() && !model->elastic.springs_are_linear; ++s) {
      for (const Index v : net.springs[s]) bound(v, net.rest_length_m[s]);
    }
    for (const DescentTerm& state : terms) {
      if (state.term->law == StrainLaw::kLinear) continue;
      const StrainOperator& op = state.term->op;
      for (std::size_t k = 0; k < op.vertices.size(); ++k)
        bound(op.vertices[k], damped / length(op.gradients[k]));
    }
  }

  void start(const MotionState& state, double h, std::span<const Vec3> u) {
    if (step_s != h) {
      step_s = h;
      set_reach();
    }
    shares.clear();
    std::fill(dead_load.begin(), dead_load.end(), Vec3{});
    for (const TimedLoads& group : model->loads) {
      shares.push_back(value_at(group.profile, state.time_s + h).share);
      add_scaled(dead_load, shares.back(), group.loads.force_n);
    }
    for (DescentTerm& term : terms) {
      const StrainOperator& op = term.term->op;
      term.gradient.resize(op.domains());
      term.gradient_before.resize(op.domains());
      for (std::size_t s = 0; s < op.domains(); ++s) {
        term.gradient[s] = displacement_gradient(op, s, u);
        term.gradient_before[s] = displacement_gradient(op, s, state.displacement_m);
      }
    }
  }

  void add_springs(const MotionState& state, std::span<const Vec3> u, std::size_t v, Vec3& f,
                   Mat3& block) const {
    const ElasticModel& elastic = model->elastic;
    for (const Index end : spring_ends.of(v)) {
      const std::size_t s = end / 2;
      const Index other = elastic.springs.springs[s][1 - end % 2];
      const Vec3 rest_edge = elastic.rest[other] - elastic.rest[v];
      const Vec3 moved = u[other] - u[v];
      const Vec3 edge = elastic.springs_are_linear ? rest_edge : rest_edge + moved;
      const double size = length(edge);
      if (!(size > 0.0)) continue;
      const Vec3 n = (1.0 / size) * edge;
      const double k = elastic.springs.stiffness_n_per_m[s];
      const double rest_length = elastic.springs.rest_length_m[s];
      const double elongation =
          elastic.springs_are_linear ? dot(n, moved) : spring_elongation(rest_edge, moved, rest_length);
      const double across = elastic.springs_are_linear ? 0.0 : k * std::max(1.0 - rest_length / size, 0.0);
      f = f + (k * elongation) * n;
      block += (k - across) * outer(n, n) + across * kIdentity;
      if (model->spring_damping_n_s_per_m.empty()) continue;
      const double c = model->spring_damping_n_s_per_m[s] / step_s;
      const Vec3 approach = moved - (state.displacement_m[other] - state.displacement_m[v]);
      const bool is_axial = model->spring_damping == SpringDamping::kAxial;
      f = f + (is_axial ? (c * dot(approach, n)) * n : c * approach);
      block += c * (is_axial ? outer(n, n) : kIdentity);
    }
  }

  void add_domains(std::size_t v, Vec3& f, Mat3& block) const {
    const double b = model->strain_damping_s;
    for (const DescentTerm& state : terms) {
      const StrainTerm& term = *state.term;
      const Moduli viscous{b * term.moduli.lambda_pa, b * term.moduli.mu_pa};
      for (const Index entry : state.entries.of(v)) {
        const Index s = state.domain_of[entry];
        const Mat3& h = state.gradient[s];
        const Vec3& g = term.op.gradients[entry];
        Mat3 p = stress(term.law, term.moduli, h);
        if (b != 0.0)
          p += damping_stress(term.law, viscous, h, (1.0 / step_s) * (h - state.gradient_before[s]));
        f = f - term.op.volume_m3[s] * (p * g);
        if (grows_with_strain(term.law) && b != 0.0) {
          block += term.op.volume_m3[s] * vertex_stiffness(term.law, term.moduli, h, g);
          block += (term.op.volume_m3[s] / step_s) *
                   vertex_damping(term.law, viscous, h, state.gradient_before[s], g);
        } else {
          block +=
              (term.op.volume_m3[s] * (1.0 + b / step_s)) * vertex_stiffness(term.law, term.moduli, h, g);
        }
      }
    }
  }

  void add_supports(std::span<const Vec3> u, std::size_t v, Vec3& f, Mat3& block) const {
    for (const Index corner : support_corners.of(v)) {
      const TimedSupport& support = supports[corner / 3];
      const double c = support.face.coefficient_n_per_m;
      const Vec3 place = shares[support.group] * support.face.by_m;
      for (const Index other : support.face.face) f = f - (other == v ? 2.0 * c : c) * (u[other] - place);
      block += (2.0 * c) * kIdentity;
    }
  }

  /// Whether a domain is inverted whose law has no energy for that.
  bool is_inverted() const {
    return std::any_of(terms.begin(), terms.end(), [](const DescentTerm& state) {
      return state.term->law == StrainLaw::kNeoHookean &&
             std::any_of(state.gradient.begin(), state.gradient.end(),
                         [](const Mat3& h) { return !(determinant(kIdentity + h) > 0.0); });
    });
  }

  /// Whether a domain whose law minds it is inverted, or loses half its volume.
  bool turns_out(std::size_t v, const Vec3& change) const {
    for (const DescentTerm& state : terms) {
      if (!minds_inversion(state.term->law)) continue;
      for (const Index entry : state.entries.of(v)) {
        const Mat3 f = kIdentity + state.gradient[state.domain_of[entry]];
        const double volume = determinant(f);
        const Vec3 slope = cofactors(f) * state.term->op.gradients[entry];
        if (!(volume > 0.0 && volume + dot(slope, change) > 0.5 * volume)) return true;
      }
    }
    return false;
  }

  /// What the springs of `v` gain in energy, and dampers take, where it moves by `change`.
  double spring_raise(const MotionState& state, std::span<const Vec3> u, std::size_t v,
                      const Vec3& change) const {
    const ElasticModel& elastic = model->elastic;
    double sum = 0.0;
    for (const Index end : spring_ends.of(v)) {
      const std::size_t s = end / 2;
      const Index other = elastic.springs.springs[s][1 - end % 2];
      const Vec3 rest_edge = elastic.rest[other] - elastic.rest[v];
      const Vec3 moved = u[other] - u[v];
      const double rest_length = elastic.springs.rest_length_m[s];
      const auto elongation = [&](const Vec3& by) {
        if (!elastic.springs_are_linear) return spring_elongation(rest_edge, by, rest_length);
        return dot(rest_edge, by) / length(rest_edge);
      };
      const double before = elongation(moved);
      const double after = elongation(moved - change);
      sum += 0.5 * elastic.springs.stiffness_n_per_m[s] * (after - before) * (after + before);
      if (model->spring_damping_n_s_per_m.empty()) continue;
      const bool is_axial = model->spring_damping == SpringDamping::kAxial;
      const Vec3 start = state.displacement_m[other] - state.displacement_m[v];
      sum += model->spring_damping_n_s_per_m[s] / step_s * along_the_way([&](double share) {
               const Vec3 there = moved - share * change;
               const Vec3 approach = there - start;
               if (!is_axial) return -dot(approach, change);
               const Vec3 edge = elastic.springs_are_linear ? rest_edge : rest_edge + there;
               const double size_sq = length_sq(edge);
               return size_sq > 0.0 ? -dot(approach, edge) * dot(edge, change) / size_sq : 0.0;
             });
    }
    return sum;
  }

  /// The same of the domains of `v`.
  double domain_raise(std::size_t v, const Vec3& change) const {
    const double b = model->strain_damping_s;
    double sum = 0.0;
    for (const DescentTerm& state : terms) {
      const StrainTerm& term = *state.term;
      const Moduli viscous{b * term.moduli.lambda_pa, b * term.moduli.mu_pa};
      for (const Index entry : state.entries.of(v)) {
        const Index s = state.domain_of[entry];
        const Mat3& h = state.gradient[s];
        const Mat3 by = outer(change, term.op.gradients[entry]);
        const double after = energy_density(term.law, term.moduli, h + by);
        if (!std::isfinite(after)) return std::numeric_limits<double>::infinity();
        sum += term.op.volume_m3[s] * (after - energy_density(term.law, term.moduli, h));
        if (b == 0.0) continue;
        sum +=
            term.op.volume_m3[s] / step_s * along_the_way([&](double share) {
              const Mat3 there = h + share * by;
              return contract(damping_stress(term.law, viscous, there, there - state.gradient_before[s]), by);
            });
      }
    }
    return sum;
  }

  /// What the energy of a step gains where vertex `v` moves by `change`, all others where they are: inertia,
  /// springs, domains, supports, less what the loads give, and what dampers take on the way.
  double raise(const MotionState& state, std::span<const Vec3> u, std::size_t v, const Vec3& change) const {
    const double drag =
        model->environment_damping_n_s_per_m.empty() ? 0.0 : model->environment_damping_n_s_per_m[v];
    const double inertia = model->mass_kg[v] / (step_s * step_s);
    const Vec3 moved = u[v] - state.displacement_m[v];
    Vec3 f = dead_load[v] - inertia * (moved - step_s * state.velocity_m_s[v]) - (drag / step_s) * moved;
    Mat3 block = (inertia + drag / step_s) * kIdentity;
    add_supports(u, v, f, block);
    return 0.5 * dot(change, block * change) - dot(f, change) + spring_raise(state, u, v, change) +
           domain_raise(v, change);
  }

  /// A change halved until it raises the energy no more; none if it always does.
  Vec3 shorten(const MotionState& state, std::span<const Vec3> u, std::size_t v, Vec3 change) const {
    constexpr int kMostEnergyHalvings = 40;
    for (int k = 0; k < kMostEnergyHalvings; ++k) {
      if (raise(state, u, v, change) <= 0.0) return change;
      change = 0.5 * change;
    }
    return {};
  }

  void move_vertex(const MotionState& state, std::span<Vec3> u, std::size_t v) {
    const double drag =
        model->environment_damping_n_s_per_m.empty() ? 0.0 : model->environment_damping_n_s_per_m[v];
    const double inertia = model->mass_kg[v] / (step_s * step_s);
    const Vec3 moved = u[v] - state.displacement_m[v];
    Vec3 f = dead_load[v] - inertia * (moved - step_s * state.velocity_m_s[v]) - (drag / step_s) * moved;
    Mat3 block = (inertia + drag / step_s) * kIdentity;
    add_springs(state, u, v, f, block);
    add_domains(v, f, block);
    add_supports(u, v, f, block);
    Vec3 change;
    if (!solve_block(block, f, (*held)[v], change)) return;
    if (length_sq(change) > reach_m[v] * reach_m[v] || (minds && turns_out(v, change)))
      change = shorten(state, u, v, change);
    u[v] = u[v] + change;
    for (DescentTerm& term : terms) {
      for (const Index entry : term.entries.of(v))
        add_outer(term.gradient[term.domain_of[entry]], change, term.term->op.gradients[entry]);
    }
  }

  Sweeper sweeper;
  const MotionModel* model;
  const std::vector<std::uint8_t>* held;
  VertexLists spring_ends;
  std::vector<TimedSupport> supports;
  VertexLists support_corners;
  std::vector<DescentTerm> terms;
  bool minds = false;  ///< whether a term's law minds inversion
  double step_s = 0.0;
  std::vector<double> shares;   ///< of each group of loads, at the end of the step
  std::vector<Vec3> dead_load;  ///< then
  std::vector<double> reach_m;  ///< of each vertex
};

VertexDescentStep::VertexDescentStep(const MotionForces& forces, const StepSolverOptions& options)
    : work_(std::make_unique<Work>(forces, options)) {
  if (forces.model().elastic.volume_force)
    throw InputError("integrator", 0, "a model that has an energy for vbd", "the thesis's volume force");
}

VertexDescentStep::~VertexDescentStep() = default;
VertexDescentStep::VertexDescentStep(VertexDescentStep&&) noexcept = default;
VertexDescentStep& VertexDescentStep::operator=(VertexDescentStep&&) noexcept = default;

ImplicitResult VertexDescentStep::find_displacement(MotionForces& forces, const MotionState& state,
                                                    double step_s, std::span<Vec3> u) {
  Work& work = *work_;
  return work.sweeper.solve(forces, state, step_s, u, [&](std::size_t sweep) {
    if (sweep == 0) {
      work.start(state, step_s, u);
      if (work.is_inverted()) {  // the inertial guess has no energy: begin where the step does
        std::copy(state.displacement_m.begin(), state.displacement_m.end(), u.begin());
        set_held(forces, state.time_s + step_s, u);
        work.start(state, step_s, u);
      }
    }
    const std::size_t n = u.size();
    for (std::size_t k = 0; k < n; ++k) work.move_vertex(state, u, sweep % 2 == 0 ? k : n - 1 - k);
  });
}

}  // namespace palpate::dynamics
