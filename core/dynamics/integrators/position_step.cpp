#include "core/dynamics/integrators/position_step.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/processor.h"
#include "core/dynamics/integrators/neo_hookean_constraints.h"
#include "core/dynamics/linear_algebra/vertex_field.h"
#include "core/dynamics/motion/vertex_incidence.h"
#include "core/dynamics/position_kernel/constraint_colours.h"
#include "core/dynamics/position_kernel/spring_sweep.h"
#include "core/dynamics/position_kernel/strain_columns.h"
#include "core/dynamics/position_kernel/strain_sweep.h"

namespace palpate::dynamics {
namespace {

/// Domains of a strain term, one at a time, with their multipliers and what corrects them.
struct ConstrainedTerm {
  const StrainTerm* term = nullptr;
  std::vector<Index> domains;
  std::vector<Matrix6> correction;     ///< (1 + (h^2 + h b) K G)^-1, for inverse masses alike along all axes
  std::vector<std::uint8_t> is_mixed;  ///< a vertex is held along some axes alone: `correction` does not hold
  std::vector<Vector6> multiplier;
};

bool is_partly_held(std::uint8_t bits) {
  return bits != 0 && bits != 7;
}

/// Constraints by how they are solved.
struct Order {
  std::vector<Index> chosen;                ///< for lanes
  std::vector<std::vector<Index>> colours;  ///< of places in `chosen`
  std::vector<Index> single;                ///< in the order of a sweep
};

/// `all` by colour; one at a time where a vertex is held along some axes alone, or if all are to be.
Order order_constraints(const ConstraintVertices& all, const std::vector<std::uint8_t>& held,
                        PositionKernel kernel) {
  Order out;
  ConstraintVertices chosen;
  std::vector<Index> partly_held;
  for (std::size_t c = 0; c < all.size(); ++c) {
    const auto vertices = all.of(c);
    if (std::any_of(vertices.begin(), vertices.end(), [&](Index v) { return is_partly_held(held[v]); })) {
      partly_held.push_back(static_cast<Index>(c));
      continue;
    }
    out.chosen.push_back(static_cast<Index>(c));
    chosen.add(vertices);
  }
  out.colours = build_colours(chosen, held.size());
  validate_colours(chosen, held.size(), out.colours);
  if (kernel == PositionKernel::kSingle) {
    for (const std::vector<Index>& colour : out.colours) {
      for (const Index place : colour) out.single.push_back(out.chosen[place]);
    }
    out.chosen.clear();
    out.colours.clear();
  }
  out.single.insert(out.single.end(), partly_held.begin(), partly_held.end());
  return out;
}

ConstraintVertices list_ends(const SpringNetwork& springs) {
  ConstraintVertices out;
  for (const auto& [a, b] : springs.springs) out.add(std::array{a, b});
  return out;
}

ConstraintVertices list_vertices(const StrainOperator& op) {
  ConstraintVertices out;
  for (std::size_t s = 0; s < op.domains(); ++s) out.add(op.vertices_of(s));
  return out;
}

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
  Work(const MotionForces& forces, const StepSolverOptions& given, PositionKernel kernel)
      : sweeper(forces, given),
        model(&forces.model()),
        held(&forces.held_bits()),
        most_sweeps(given.iterations),
        with_avx2(kernel == PositionKernel::kBest && has_avx2()) {
    const std::size_t n = held->size();
    supports = list_supports(*model);
    const Order springs = order_constraints(list_ends(model->elastic.springs), *held, kernel);
    single_springs = springs.single;
    spring_lanes =
        SpringSweep(model->elastic, model->spring_damping_n_s_per_m, springs.chosen, springs.colours);
    for (const StrainTerm& term : model->elastic.strain_terms) {
      const Order domains = order_constraints(list_vertices(term.op), *held,
                                              can_sweep_in_lanes(term) ? kernel : PositionKernel::kSingle);
      if (!domains.chosen.empty()) strain_lanes.emplace_back(term, n, domains.chosen, domains.colours);
      if (term.law == StrainLaw::kStableNeoHookean) {
        neo_hookean.emplace_back(term, domains.single);
        continue;
      }
      ConstrainedTerm& state = terms.emplace_back();
      state.term = &term;
      state.domains = domains.single;
      state.is_mixed.reserve(state.domains.size());
      for (const Index s : state.domains) {
        const auto vertices = term.op.vertices_of(s);
        state.is_mixed.push_back(std::any_of(vertices.begin(), vertices.end(),
                                             [&](Index v) { return is_partly_held((*held)[v]); }));
      }
    }
    for (std::vector<Vec3>* field : {&inverse_mass, &dead_load}) field->resize(n);
    for (PositionRows* rows : {&now, &before}) *rows = make_rows(n);
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
    for (std::size_t v = 0; v < inverse_mass.size(); ++v) now[kRowNumbers * v + 3] = inverse_mass[v].x;
    spring_lanes.prepare(h);
    for (StrainSweep& lanes : strain_lanes) lanes.prepare(h, model->strain_damping_s, now);
    const double factor = h * h + h * model->strain_damping_s;
    for (ConstrainedTerm& state : terms) {
      state.correction.resize(state.domains.size());
      for (std::size_t k = 0; k < state.domains.size(); ++k)
        state.correction[k] = correct(state, k, kIdentity, factor);
    }
  }

  Matrix6 correct(const ConstrainedTerm& state, std::size_t k, const Mat3& r, double factor) const {
    return strain_correction(state.term->op, state.domains[k], state.term->moduli, r, inverse_mass, factor);
  }

  void start(const MotionState& state, std::span<const Vec3> u) {
    shares.clear();
    std::fill_n(now.end() - kRowNumbers, kRowNumbers, 0.0);
    std::fill(dead_load.begin(), dead_load.end(), Vec3{});
    for (const TimedLoads& group : model->loads) {
      shares.push_back(value_at(group.profile, state.time_s + step_s).share);
      add_scaled(dead_load, shares.back(), group.loads.force_n);
    }
    for (std::size_t v = 0; v < u.size(); ++v) {
      // From u + h v to u + h W (m v + h f), which leaves held components where they are.
      const double drag =
          model->environment_damping_n_s_per_m.empty() ? 0.0 : model->environment_damping_n_s_per_m[v];
      set_row(now, v,
              u[v] + step_s * scaled(inverse_mass[v],
                                     step_s * dead_load[v] - (step_s * drag) * state.velocity_m_s[v]));
      set_row(before, v, state.displacement_m[v]);
    }
    spring_multiplier.assign(single_springs.size(), 0.0);
    support_multiplier.assign(supports.size(), {});
    for (ConstrainedTerm& term : terms) term.multiplier.assign(term.domains.size(), Vector6::Zero());
    for (NeoHookeanConstraints& each : neo_hookean)
      each.start(step_s, model->strain_damping_s, state.displacement_m, inverse_mass);
  }

  void solve_spring(std::size_t k) {
    const ElasticModel& elastic = model->elastic;
    const Index s = single_springs[k];
    const auto [a, b] = elastic.springs.springs[s];
    const Vec3 rest_edge = elastic.rest[b] - elastic.rest[a];
    const Vec3 moved = row_of(now, b) - row_of(now, a);
    const Vec3 edge = elastic.springs_are_linear ? rest_edge : rest_edge + moved;
    const double size = length(edge);
    if (!(size > 0.0)) return;
    const Vec3 n = (1.0 / size) * edge;
    const double elongation = elastic.springs_are_linear
                                  ? dot(n, moved)
                                  : spring_elongation(rest_edge, moved, elastic.springs.rest_length_m[s]);
    const double since = dot(n, moved - (row_of(before, b) - row_of(before, a)));
    const double stiffness = step_s * step_s * elastic.springs.stiffness_n_per_m[s];
    const double damping = step_s * spring_damping(*model, s);
    const Vec3 pull_a = scaled(inverse_mass[a], n);
    const Vec3 pull_b = scaled(inverse_mass[b], n);
    const double change = -(spring_multiplier[k] + stiffness * elongation + damping * since) /
                          (1.0 + (stiffness + damping) * dot(n, pull_a + pull_b));
    spring_multiplier[k] += change;
    set_row(now, a, row_of(now, a) - change * pull_a);
    set_row(now, b, row_of(now, b) + change * pull_b);
  }

  void solve_domain(ConstrainedTerm& term, std::size_t k) {
    const StrainOperator& op = term.term->op;
    const Index s = term.domains[k];
    const double b = model->strain_damping_s;
    const Mat3 h = gradient_of_rows(op, s, now);
    const bool is_linear = term.term->law == StrainLaw::kLinear;
    const Mat3 r = is_linear ? kIdentity : nearest_rotation(kIdentity + h);
    const Mat3 strain = is_linear ? h : multiply_transposed(r, kIdentity + h - r);
    Vector6 wanted = (step_s * step_s) * strains_of(strain);
    if (b != 0.0) {
      const Mat3 since = h - gradient_of_rows(op, s, before);
      wanted += (step_s * b) * strains_of(multiply_transposed(r, since));
    }
    const Vector6 off = term.multiplier[k] + strain_stiffness(term.term->moduli, op.volume_m3[s]) * wanted;
    const Vector6 change =
        -((term.is_mixed[k] != 0 ? correct(term, k, r, step_s * step_s + step_s * b) : term.correction[k]) *
          off);
    term.multiplier[k] += change;
    const Mat3 pull = multiply(r, stress_of(change));
    for (Index i = op.offsets[s]; i < op.offsets[s + 1]; ++i) {
      const Index v = op.vertices[i];
      set_row(now, v, row_of(now, v) + scaled(inverse_mass[v], pull * op.gradients[i]));
    }
  }

  void solve_support(std::size_t at) {
    const TimedSupport& support = supports[at];
    const Triangle& face = support.face.face;
    const Vec3 place = shares[support.group] * support.face.by_m;
    std::array<Vec3, 3> u;
    for (std::size_t i = 0; i < 3; ++i) u[i] = row_of(now, face[i]);
    for (std::size_t mode = 0; mode < 3; ++mode) {
      const std::array<double, 3>& e = kFaceModes.at(mode);
      const double stiffness = step_s * step_s * kFaceWeights.at(mode) * support.face.coefficient_n_per_m;
      Vec3 moved;
      Vec3 inverse;
      for (std::size_t i = 0; i < 3; ++i) {
        moved = moved + e.at(i) * (u[i] - place);
        inverse = inverse + (e.at(i) * e.at(i)) * inverse_mass[face[i]];
      }
      Vec3& multiplier = support_multiplier[at].at(mode);
      const Vec3 off = multiplier + stiffness * moved;
      const Vec3 change{-off.x / (1.0 + stiffness * inverse.x), -off.y / (1.0 + stiffness * inverse.y),
                        -off.z / (1.0 + stiffness * inverse.z)};
      multiplier = multiplier + change;
      for (std::size_t i = 0; i < 3; ++i) u[i] = u[i] + e.at(i) * scaled(inverse_mass[face[i]], change);
    }
    for (std::size_t i = 0; i < 3; ++i) set_row(now, face[i], u[i]);
  }

  void sweep(const SweepOrder& order) {
    const bool is_backward = order.is_backward;
    const SweptRows rows{now.data(), before.data()};
    const auto each = [&](std::size_t count, const auto& solve_one) {
      for (std::size_t k = 0; k < count; ++k) solve_one(is_backward ? count - 1 - k : k);
    };
    const auto springs = [&] {
      if (!is_backward) spring_lanes.sweep(rows, order, with_avx2);
      each(single_springs.size(), [&](std::size_t k) { solve_spring(k); });
      if (is_backward) spring_lanes.sweep(rows, order, with_avx2);
    };
    const auto domains = [&] {
      const auto in_lanes = [&] {
        each(strain_lanes.size(), [&](std::size_t t) { strain_lanes[t].sweep(rows, order, with_avx2); });
      };
      if (!is_backward) in_lanes();
      each(terms.size(), [&](std::size_t t) {
        each(terms[t].domains.size(), [&](std::size_t k) { solve_domain(terms[t], k); });
      });
      each(neo_hookean.size(), [&](std::size_t t) {
        each(neo_hookean[t].size(), [&](std::size_t k) { neo_hookean[t].solve(k, now); });
      });
      if (is_backward) in_lanes();
    };
    const auto faces = [&] { each(supports.size(), [&](std::size_t at) { solve_support(at); }); };
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

  void finish(std::span<Vec3> u) const {
    for (std::size_t v = 0; v < u.size(); ++v) u[v] = row_of(now, v);
  }

  Sweeper sweeper;
  const MotionModel* model;
  const std::vector<std::uint8_t>* held;
  std::size_t most_sweeps;
  bool with_avx2;
  std::vector<TimedSupport> supports;
  SpringSweep spring_lanes;
  std::vector<Index> single_springs;
  std::vector<StrainSweep> strain_lanes;
  std::vector<ConstrainedTerm> terms;
  std::vector<NeoHookeanConstraints> neo_hookean;  ///< terms of that law
  std::vector<double> spring_multiplier;
  std::vector<std::array<Vec3, 3>> support_multiplier;
  double step_s = 0.0;
  std::vector<double> shares;      ///< of each group of loads, at the end of the step
  std::vector<Vec3> inverse_mass;  ///< along each axis, in 1/kg
  std::vector<Vec3> dead_load;     ///< at the end of the step
  PositionRows now;
  PositionRows before;  ///< at the start of the step
};

PositionStep::PositionStep(const MotionForces& forces, const StepSolverOptions& options,
                           PositionKernel kernel) {
  require_takes(forces.model());
  work_ = std::make_unique<Work>(forces, options, kernel);
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
    work.sweep({sweep == 0, sweep % 2 == 1, sweep + 1 == work.most_sweeps});
    work.finish(u);
  });
}

}  // namespace palpate::dynamics
