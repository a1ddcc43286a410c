#include "core/dynamics/integrators/newton_step.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/dynamics/linear_algebra/vertex_field.h"

namespace palpate::dynamics {
namespace {

constexpr int kMostHalvings = 20;

/// A linear system inside of Newton's method is solved to a share of what its step still has to lose, but
/// never worse than this: Newton's own convergence is quadratic.
constexpr double kLoosest = 1e-4;
constexpr double kShareOfTarget = 0.1;

}  // namespace

struct NewtonStep::Work {
  Work(const MotionForces& forces, ImplicitRule given_rule, const StepSolverOptions& given,
       const LinearOptions& linear)
      : rule(given_rule),
        options(given),
        goal(forces, given),
        is_linear(is_linear_body(forces.model())),
        constant_damping(build_motion_pattern(forces.model())),
        matrix(constant_damping),
        tightest(linear.tolerance),
        solver(linear) {
    add_constant_damping(forces.model(), constant_damping);
    const std::size_t n = forces.held_bits().size();
    for (std::vector<Vec3>* field : {&u, &velocity, &imbalance, &tried, &change, &product, &from_u, &from_v,
                                     &acceleration, &before_u, &before_v})
      field->resize(n);
  }

  /// Whether `state` is where the last step left it, so that what is remembered belongs to it.
  bool is_continued(const MotionState& state, double h) const {
    return last_h == h && last.time_s == state.time_s && last.displacement_m == state.displacement_m &&
           last.velocity_m_s == state.velocity_m_s;
  }

  void find_acceleration(MotionForces& forces, const MotionState& state) {
    forces.evaluate(state.displacement_m, state.velocity_m_s, state.time_s, acceleration);
    for (std::size_t v = 0; v < acceleration.size(); ++v)
      acceleration[v] = (1.0 / forces.model().mass_kg[v]) * acceleration[v];
  }

  /// r, u* and v*. Of what is held they are of no consequence.
  void set_relation(MotionForces& forces, const MotionState& state, double h) {
    const bool goes_on = is_continued(state, h);
    step_rule = rule == ImplicitRule::kBdf2 && !goes_on ? ImplicitRule::kBackwardEuler : rule;
    has_acceleration = goes_on || step_rule == ImplicitRule::kTrapezoidal;
    if (has_acceleration && !goes_on) find_acceleration(forces, state);
    const std::vector<Vec3>& now_u = state.displacement_m;
    const std::vector<Vec3>& now_v = state.velocity_m_s;
    for (std::size_t v = 0; v < u.size(); ++v) {
      if (step_rule == ImplicitRule::kBackwardEuler) {
        from_u[v] = now_u[v];
        from_v[v] = now_v[v];
      } else if (step_rule == ImplicitRule::kTrapezoidal) {
        from_u[v] = now_u[v] + (0.5 * h) * now_v[v];
        from_v[v] = now_v[v] + (0.5 * h) * acceleration[v];
      } else {
        from_u[v] = (1.0 / 3.0) * (4.0 * now_u[v] - before_u[v]);
        from_v[v] = (1.0 / 3.0) * (4.0 * now_v[v] - before_v[v]);
      }
    }
    const double steps = step_rule == ImplicitRule::kBackwardEuler ? 1.0
                         : step_rule == ImplicitRule::kTrapezoidal ? 2.0
                                                                   : 1.5;
    rate = steps / h;
  }

  /// The norm of f - m a at `place`, whose held components are put where they belong.
  double find_residual(MotionForces& forces, double time_s, std::vector<Vec3>& place) {
    for (std::size_t v = 0; v < place.size(); ++v) velocity[v] = rate * (place[v] - from_u[v]);
    if (step_rule == ImplicitRule::kBackwardEuler) {
      // What is held moves by the same rule as the rest.
      set_held(forces, time_s, place);
      for (const HeldComponent& held : forces.held())
        velocity[held.vertex] = rate * (place[held.vertex] - from_u[held.vertex]);
    } else {
      forces.impose(time_s, place, velocity);
    }
    zero_length += forces.evaluate(place, velocity, time_s, imbalance);
    const std::vector<double>& mass = forces.model().mass_kg;
    for (std::size_t v = 0; v < place.size(); ++v)
      imbalance[v] = imbalance[v] - (mass[v] * rate) * (velocity[v] - from_v[v]);
    clear_held(forces.held_bits(), imbalance);
    return norm_of(imbalance);
  }

  bool assemble(const MotionForces& forces, TangentKind kind) {
    const MotionModel& model = forces.model();
    for (std::size_t k = 0; k < matrix.blocks.size(); ++k)
      matrix.blocks[k] = rate * constant_damping.blocks[k];
    add_motion_tangent(model, u, kind, rate, matrix);
    for (std::size_t v = 0; v < u.size(); ++v)
      add_block(matrix, static_cast<Index>(v), static_cast<Index>(v),
                (rate * rate * model.mass_kg[v]) * kIdentity);
    const MatrixUse use = is_linear ? MatrixUse::kKept : MatrixUse::kFewTimes;
    return solver.prepare(matrix, forces.held_bits(), use) == LinearStatus::kSolved;
  }

  /// The matrix at `u`, unless the body is linear and the one that there is will do.
  void prepare(const MotionForces& forces) {
    if (is_linear && prepared_rate == rate) return;
    if (!assemble(forces, TangentKind::kExact)) assemble(forces, TangentKind::kProjected);
    prepared_rate = rate;
  }

  /// u += s change with the largest s of 1, 1/2, 1/4, ... that lowers the residual. Returns it, or nothing.
  std::optional<double> search(MotionForces& forces, double time_s, double residual) {
    double share = 1.0;
    for (int halving = 0; halving <= kMostHalvings; ++halving, share *= 0.5) {
      for (std::size_t v = 0; v < u.size(); ++v) tried[v] = u[v] + share * change[v];
      const double found = find_residual(forces, time_s, tried);
      if (found < residual) {
        u.swap(tried);
        return found;
      }
    }
    return std::nullopt;
  }

  /// The same for a linear body, by its matrix: a full step, or none.
  std::optional<double> take_linear(const MotionForces& forces, double residual) {
    multiply(matrix, change, product, forces.threads());
    clear_held(forces.held_bits(), product);
    add_scaled(imbalance, -1.0, product);
    const double found = norm_of(imbalance);
    if (!(found < residual)) return std::nullopt;
    add_scaled(u, 1.0, change);
    return found;
  }

  /// The better of the two guesses is left in `u`; returns the residuals of the inertial one and of `u`.
  std::pair<double, double> guess(MotionForces& forces, const MotionState& state, double h) {
    const double time_s = state.time_s + h;
    double warm = 0.0;
    const bool is_warm = has_acceleration && !is_linear;  // a linear body is solved at once from anywhere
    if (is_warm) {
      for (std::size_t v = 0; v < u.size(); ++v)
        tried[v] = state.displacement_m[v] + h * state.velocity_m_s[v] + (0.5 * h * h) * acceleration[v];
      warm = find_residual(forces, time_s, tried);
      change.swap(imbalance);  // kept
    }
    for (std::size_t v = 0; v < u.size(); ++v) u[v] = state.displacement_m[v] + h * state.velocity_m_s[v];
    const double inertial = find_residual(forces, time_s, u);
    if (!is_warm || !(warm < inertial)) return {inertial, inertial};
    u.swap(tried);
    change.swap(imbalance);
    return {inertial, warm};
  }

  ImplicitResult take(MotionForces& forces, MotionState& state, double h) {
    zero_length = 0;
    set_relation(forces, state, h);
    const double time_s = state.time_s + h;
    const std::pair<double, double> guessed = guess(forces, state, h);
    const double first = guessed.first;
    double residual = guessed.second;
    ImplicitResult result;
    const auto is_solved = [&] { return goal.is_met(residual, first, u, h); };
    result.solved = is_solved();
    bool is_broken = false;
    while (!result.solved && result.iterations < options.iterations) {
      prepare(forces);
      solver.set_tolerance(std::clamp(kShareOfTarget * goal.target(first, u, h) / residual, tightest,
                                      std::max(tightest, kLoosest)));
      is_broken = solver.solve(imbalance, change).status != LinearStatus::kSolved;
      ++result.iterations;
      std::optional<double> found;
      if (!is_broken) found = is_linear ? take_linear(forces, residual) : search(forces, time_s, residual);
      if (!found) {
        // Nothing is lower: rounding, or a place without a way down.
        residual = find_residual(forces, time_s, u);
        break;
      }
      residual = *found;
      result.solved = is_solved();
    }
    if (options.tolerance == 0.0) result.solved = !is_broken;
    result.residual_relative = first > 0.0 ? residual / first : 0.0;
    result.zero_length_springs = zero_length;
    finish(forces, state, h);
    return result;
  }

  void finish(const MotionForces& forces, MotionState& state, double h) {
    before_u = state.displacement_m;
    before_v = state.velocity_m_s;
    for (std::size_t v = 0; v < u.size(); ++v) {
      state.velocity_m_s[v] = rate * (u[v] - from_u[v]);
      acceleration[v] = rate * (state.velocity_m_s[v] - from_v[v]);
    }
    state.displacement_m = u;
    forces.impose(state.time_s + h, state.displacement_m, state.velocity_m_s);
    last = state;
    last.time_s = state.time_s + h;
    last_h = h;
  }

  ImplicitRule rule;
  ImplicitRule step_rule = ImplicitRule::kBackwardEuler;  ///< of this step
  StepSolverOptions options;
  StepGoal goal;
  bool is_linear;
  BlockMatrix constant_damping;
  BlockMatrix matrix;
  double tightest;  ///< of the linear systems' tolerances
  LinearSolver solver;
  double rate = 0.0;
  double prepared_rate = 0.0;
  bool has_acceleration = false;
  std::size_t zero_length = 0;
  std::vector<Vec3> u;
  std::vector<Vec3> velocity;
  std::vector<Vec3> imbalance;  ///< at the place that was looked at last
  std::vector<Vec3> tried;
  std::vector<Vec3> change;
  std::vector<Vec3> product;
  std::vector<Vec3> from_u;
  std::vector<Vec3> from_v;
  std::vector<Vec3> acceleration;  ///< at the end of the last step
  std::vector<Vec3> before_u;      ///< at the start of the last step
  std::vector<Vec3> before_v;
  MotionState last;
  double last_h = 0.0;
};

NewtonStep::NewtonStep(const MotionForces& forces, ImplicitRule rule, const StepSolverOptions& options,
                       const LinearOptions& linear)
    : work_(std::make_unique<Work>(forces, rule, options, linear)) {}
NewtonStep::~NewtonStep() = default;
NewtonStep::NewtonStep(NewtonStep&&) noexcept = default;
NewtonStep& NewtonStep::operator=(NewtonStep&&) noexcept = default;

ImplicitResult NewtonStep::take(MotionForces& forces, MotionState& state, double step_s) {
  return work_->take(forces, state, step_s);
}

}  // namespace palpate::dynamics
