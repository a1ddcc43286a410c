#include "core/dynamics/integrators/step_balance.h"

#include <cmath>
#include <limits>

#include "core/base/component.h"
#include "core/dynamics/linear_algebra/vertex_field.h"

namespace palpate::dynamics {

RoundingFloor::RoundingFloor(const MotionForces& forces) : mass_kg_(forces.model().mass_kg) {
  const MotionModel& model = forces.model();
  BlockMatrix stiffness = build_motion_pattern(model);
  add_motion_stiffness(model, std::vector<Vec3>(mass_kg_.size()), TangentKind::kExact, stiffness);
  stiffness_n_per_m_.resize(mass_kg_.size());
  for (std::size_t v = 0; v < stiffness.rows(); ++v) {
    for (std::size_t k = stiffness.offsets[v]; k < stiffness.offsets[v + 1]; ++k) {
      const Mat3& block = stiffness.blocks[k];
      if (stiffness.columns[k] == v) stiffness_n_per_m_[v] = std::sqrt(contract(block, block));
    }
  }
}

double RoundingFloor::of(std::span<const Vec3> u, double step_s) const {
  double sum = 0.0;
  for (std::size_t v = 0; v < u.size(); ++v) {
    const double resistance = stiffness_n_per_m_[v] + mass_kg_[v] / (step_s * step_s);
    sum += resistance * resistance * length_sq(u[v]);
  }
  constexpr double kOperations = 16.0;
  return kOperations * std::numeric_limits<double>::epsilon() * std::sqrt(sum);
}

std::size_t find_imbalance(MotionForces& forces, const MotionState& state, double step_s,
                           std::span<const Vec3> u, std::span<Vec3> velocity, std::span<Vec3> imbalance) {
  const std::vector<double>& mass = forces.model().mass_kg;
  for (std::size_t v = 0; v < u.size(); ++v) velocity[v] = (1.0 / step_s) * (u[v] - state.displacement_m[v]);
  const std::size_t zero_length = forces.evaluate(u, velocity, state.time_s + step_s, imbalance);
  for (std::size_t v = 0; v < u.size(); ++v)
    imbalance[v] = imbalance[v] - (mass[v] / step_s) * (velocity[v] - state.velocity_m_s[v]);
  clear_held(forces.held_bits(), imbalance);
  return zero_length;
}

void set_held(const MotionForces& forces, double time_s, std::span<Vec3> u) {
  for (const HeldComponent& held : forces.held()) {
    const double place = value_at(forces.model().loads[held.group].profile, time_s).share * held.by_m;
    component(u[held.vertex], held.axis) = place;
  }
}

void set_inertial_guess(const MotionForces& forces, const MotionState& state, double step_s,
                        std::span<Vec3> u) {
  for (std::size_t v = 0; v < u.size(); ++v) u[v] = state.displacement_m[v] + step_s * state.velocity_m_s[v];
  set_held(forces, state.time_s + step_s, u);
}

StepGoal::StepGoal(const MotionForces& forces, const StepSolverOptions& options)
    : tolerance_(options.tolerance) {
  if (tolerance_ > 0.0) rounding_.emplace(forces);
}

bool StepGoal::is_met(double residual, double first, std::span<const Vec3> u, double step_s) const {
  return residual == 0.0 || (rounding_ && residual <= target(first, u, step_s));
}

double StepGoal::target(double first, std::span<const Vec3> u, double step_s) const {
  return rounding_ ? tolerance_ * first + rounding_->of(u, step_s) : 0.0;
}

Sweeper::Sweeper(const MotionForces& forces, const StepSolverOptions& options)
    : options_(options),
      goal_(forces, options),
      velocity_(forces.held_bits().size()),
      imbalance_(velocity_.size()) {}

ImplicitResult Sweeper::solve(MotionForces& forces, const MotionState& state, double step_s,
                              std::span<Vec3> u, const std::function<void(std::size_t)>& sweep) {
  ImplicitResult result;
  const auto look = [&] {
    result.zero_length_springs += find_imbalance(forces, state, step_s, u, velocity_, imbalance_);
    return norm_of(imbalance_);
  };
  set_inertial_guess(forces, state, step_s, u);
  const bool has_tolerance = options_.tolerance > 0.0;
  const bool is_looked_at = has_tolerance || is_leftover_due(steps_++);
  const double first = is_looked_at ? look() : 0.0;
  double residual = first;
  const auto is_solved = [&] { return has_tolerance && goal_.is_met(residual, first, u, step_s); };
  result.solved = is_solved();
  while (!result.solved && result.iterations < options_.iterations) {
    sweep(result.iterations++);
    if (!has_tolerance) continue;
    residual = look();
    result.solved = is_solved();
  }
  if (!has_tolerance) {
    result.solved = true;
    if (is_looked_at) residual = look();
  }
  if (is_looked_at) result.residual_relative = first > 0.0 ? residual / first : 0.0;
  return result;
}

}  // namespace palpate::dynamics
