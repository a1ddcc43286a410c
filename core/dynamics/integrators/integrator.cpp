#include "core/dynamics/integrators/integrator.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/dynamics/integrators/linearised_step.h"
#include "core/dynamics/integrators/newton_step.h"
#include "core/dynamics/integrators/position_step.h"
#include "core/dynamics/integrators/prefactored_step.h"
#include "core/dynamics/integrators/vertex_descent_step.h"

namespace palpate::dynamics {
namespace {

/// a + s b, entry by entry, into `out`.
void combine(const std::vector<Vec3>& a, double s, const std::vector<Vec3>& b, std::vector<Vec3>& out) {
  for (std::size_t v = 0; v < a.size(); ++v) out[v] = a[v] + s * b[v];
}

std::optional<ImplicitRule> rule_of(IntegratorKind kind) {
  if (kind == IntegratorKind::kBackwardEuler) return ImplicitRule::kBackwardEuler;
  if (kind == IntegratorKind::kBdf2) return ImplicitRule::kBdf2;
  if (kind == IntegratorKind::kTrapezoidal) return ImplicitRule::kTrapezoidal;
  return std::nullopt;
}

}  // namespace

struct Integrator::Work {
  Work(const MotionModel& model, const IntegratorOptions& given)
      : options(given),
        forces(model, given.threads),
        acceleration(model.elastic.rest.size()),
        next(acceleration.size()) {
    if (!(options.speed_limit_m_s >= 0.0))
      throw InputError("speed limit", 0, "a number >= 0", std::to_string(options.speed_limit_m_s));
    if (options.kind == IntegratorKind::kImplicitEuler) linearised.emplace(forces, options.linear);
    if (options.kind == IntegratorKind::kPrefactored) prefactored.emplace(forces, options.solver);
    if (options.kind == IntegratorKind::kXpbd) positions.emplace(forces, options.solver);
    if (options.kind == IntegratorKind::kVbd) descent.emplace(forces, options.solver);
    if (const std::optional<ImplicitRule> rule = rule_of(options.kind))
      newton.emplace(forces, *rule, options.solver, options.linear);
    require(options.substeps > 0, "at least one substep");
  }

  /// a(u, v, t) into `out`.
  void accelerate(const std::vector<Vec3>& u, const std::vector<Vec3>& v, double time_s,
                  std::vector<Vec3>& out, StepReport& report) {
    report.zero_length_springs += forces.evaluate(u, v, time_s, out);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = (1.0 / forces.model().mass_kg[i]) * out[i];
  }

  void cut_speeds(std::vector<Vec3>& velocity, StepReport& report) const {
    const double limit = options.speed_limit_m_s;
    if (limit == 0.0) return;
    for (std::size_t i = 0; i < velocity.size(); ++i) {
      Vec3& v = velocity[i];
      const double speed_sq = length_sq(v);
      if (!(speed_sq > limit * limit) || forces.held_bits()[i] == 7) continue;
      v = (limit / std::sqrt(speed_sq)) * v;
      ++report.speeds_cut;
    }
  }

  /// Ends a step: the time, what is held.
  void finish(MotionState& state, double h) {
    state.time_s += h;
    forces.impose(state.time_s, state.displacement_m, state.velocity_m_s);
  }

  void step_euler(MotionState& state, double h, bool symplectic, StepReport& report) {
    accelerate(state.displacement_m, state.velocity_m_s, state.time_s, acceleration, report);
    if (!symplectic) combine(state.displacement_m, h, state.velocity_m_s, state.displacement_m);
    combine(state.velocity_m_s, h, acceleration, state.velocity_m_s);
    cut_speeds(state.velocity_m_s, report);
    if (symplectic) combine(state.displacement_m, h, state.velocity_m_s, state.displacement_m);
    finish(state, h);
  }

  void step_verlet(MotionState& state, double h, StepReport& report) {
    // The acceleration of the step before is this step's, unless the caller has changed the state.
    if (!has_last || last.time_s != state.time_s || last.displacement_m != state.displacement_m ||
        last.velocity_m_s != state.velocity_m_s)
      accelerate(state.displacement_m, state.velocity_m_s, state.time_s, acceleration, report);
    std::vector<Vec3>& predicted = stage_v;
    predicted.resize(next.size());
    for (std::size_t i = 0; i < next.size(); ++i) {
      state.displacement_m[i] =
          state.displacement_m[i] + h * (state.velocity_m_s[i] + (0.5 * h) * acceleration[i]);
      predicted[i] = state.velocity_m_s[i] + h * acceleration[i];
    }
    forces.impose(state.time_s + h, state.displacement_m, predicted);
    accelerate(state.displacement_m, predicted, state.time_s + h, next, report);
    for (std::size_t i = 0; i < next.size(); ++i)
      state.velocity_m_s[i] = state.velocity_m_s[i] + (0.5 * h) * (acceleration[i] + next[i]);
    cut_speeds(state.velocity_m_s, report);
    finish(state, h);
    acceleration.swap(next);
    last = state;
    has_last = true;
  }

  void step_runge_kutta(MotionState& state, double h, StepReport& report) {
    constexpr std::array<double, 4> kPlace{0.0, 0.5, 0.5, 1.0};
    constexpr std::array<double, 4> kWeight{1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};
    const MotionState start = state;
    stage_u = start.displacement_m;
    stage_v = start.velocity_m_s;
    for (std::size_t k = 0; k < 4; ++k) {
      if (k > 0) {
        combine(start.displacement_m, kPlace[k] * h, stage_v, stage_u);
        combine(start.velocity_m_s, kPlace[k] * h, acceleration, stage_v);
        forces.impose(start.time_s + kPlace[k] * h, stage_u, stage_v);
      }
      accelerate(stage_u, stage_v, start.time_s + kPlace[k] * h, acceleration, report);
      combine(state.displacement_m, kWeight[k] * h, stage_v, state.displacement_m);
      combine(state.velocity_m_s, kWeight[k] * h, acceleration, state.velocity_m_s);
    }
    cut_speeds(state.velocity_m_s, report);
    finish(state, h);
  }

  static void add(const ImplicitResult& result, StepReport& report) {
    report.zero_length_springs += result.zero_length_springs;
    report.iterations += result.iterations;
    report.solved = report.solved && result.solved;
    if (result.residual_relative)
      report.residual_relative = std::max(report.residual_relative.value_or(0.0), *result.residual_relative);
  }

  void step_linearised(MotionState& state, double h, StepReport& report) {
    add(linearised->find_velocity(forces, state, h, next), report);
    state.velocity_m_s.swap(next);
    cut_speeds(state.velocity_m_s, report);
    combine(state.displacement_m, h, state.velocity_m_s, state.displacement_m);
    finish(state, h);
  }

  /// Backward Euler by whoever finds the displacement at its end.
  template <typename Solver>
  void step_to_displacement(Solver& solver, MotionState& state, double h, StepReport& report) {
    add(solver.find_displacement(forces, state, h, next), report);
    for (std::size_t v = 0; v < next.size(); ++v)
      state.velocity_m_s[v] = (1.0 / h) * (next[v] - state.displacement_m[v]);
    const std::size_t cut_before = report.speeds_cut;
    cut_speeds(state.velocity_m_s, report);
    if (report.speeds_cut == cut_before) {
      state.displacement_m = next;
    } else {
      combine(state.displacement_m, h, state.velocity_m_s, state.displacement_m);
    }
    finish(state, h);
  }

  /// With each of `substeps` cut on its own.
  template <typename Solver>
  void step_in_parts(Solver& solver, MotionState& state, double h, StepReport& report) {
    const double end_s = state.time_s + h;
    for (std::size_t k = 0; k < options.substeps; ++k)
      step_to_displacement(solver, state, h / static_cast<double>(options.substeps), report);
    if (options.substeps == 1) return;
    state.time_s = end_s;
    forces.impose(end_s, state.displacement_m, state.velocity_m_s);
  }

  void step_newton(MotionState& state, double h, StepReport& report) {
    add(newton->take(forces, state, h), report);
    cut_speeds(state.velocity_m_s, report);
    finish(state, h);
  }

  IntegratorOptions options;
  MotionForces forces;
  std::optional<LinearisedStep> linearised;
  std::optional<PrefactoredStep> prefactored;
  std::optional<NewtonStep> newton;
  std::optional<PositionStep> positions;
  std::optional<VertexDescentStep> descent;
  std::vector<Vec3> acceleration;
  std::vector<Vec3> next;
  std::vector<Vec3> stage_u;
  std::vector<Vec3> stage_v;
  MotionState last;  ///< kVelocityVerlet: the state that `acceleration` belongs to
  bool has_last = false;
};

Integrator::Integrator(const MotionModel& model, const IntegratorOptions& options)
    : work_(std::make_unique<Work>(model, options)) {}
Integrator::~Integrator() = default;
Integrator::Integrator(Integrator&&) noexcept = default;
Integrator& Integrator::operator=(Integrator&&) noexcept = default;

MotionForces& Integrator::forces() {
  return work_->forces;
}

StepReport Integrator::step(MotionState& state, double step_s) {
  require(step_s > 0.0 && std::isfinite(step_s), "a finite step above zero");
  require(
      state.displacement_m.size() == work_->next.size() && state.velocity_m_s.size() == work_->next.size(),
      "one displacement and one velocity a vertex");
  StepReport report;
  switch (work_->options.kind) {
    case IntegratorKind::kExplicitEuler:
      work_->step_euler(state, step_s, false, report);
      break;
    case IntegratorKind::kSymplecticEuler:
      work_->step_euler(state, step_s, true, report);
      break;
    case IntegratorKind::kVelocityVerlet:
      work_->step_verlet(state, step_s, report);
      break;
    case IntegratorKind::kRungeKutta4:
      work_->step_runge_kutta(state, step_s, report);
      break;
    case IntegratorKind::kImplicitEuler:
      work_->step_linearised(state, step_s, report);
      break;
    case IntegratorKind::kPrefactored:
      work_->step_to_displacement(*work_->prefactored, state, step_s, report);
      break;
    case IntegratorKind::kBackwardEuler:
    case IntegratorKind::kBdf2:
    case IntegratorKind::kTrapezoidal:
      work_->step_newton(state, step_s, report);
      break;
    case IntegratorKind::kXpbd:
      work_->step_in_parts(*work_->positions, state, step_s, report);
      break;
    case IntegratorKind::kVbd:
      work_->step_in_parts(*work_->descent, state, step_s, report);
      break;
  }
  return report;
}

}  // namespace palpate::dynamics
