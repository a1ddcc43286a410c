#include "core/dynamics/integrators/linearised_step.h"

#include <algorithm>

#include "core/base/component.h"
#include "core/dynamics/linear_algebra/vertex_field.h"

namespace palpate::dynamics {
namespace {

/// Velocities that carry held components to where they belong at the end of the step; `velocity` keeps the
/// others.
void set_held_velocity(const MotionForces& forces, const MotionState& state, double step_s,
                       std::span<Vec3> velocity) {
  for (const HeldComponent& held : forces.held()) {
    const double share = value_at(forces.model().loads[held.group].profile, state.time_s + step_s).share;
    const double change = share * held.by_m - component(state.displacement_m[held.vertex], held.axis);
    Vec3& v = velocity[held.vertex];
    double& along = component(v, held.axis);
    along += change / step_s - along;
  }
}

}  // namespace

LinearisedStep::LinearisedStep(const MotionForces& forces, const LinearOptions& options)
    : is_linear_(is_linear_body(forces.model())),
      pattern_(build_motion_pattern(forces.model())),
      constant_(pattern_),
      stiffness_(pattern_),
      system_(pattern_),
      solver_(options),
      force_(forces.held_bits().size()),
      product_(force_.size()),
      change_(force_.size()) {
  add_constant_damping(forces.model(), constant_);
}

void LinearisedStep::prepare(const MotionForces& forces, const MotionState& state, double step_s) {
  const MotionModel& model = forces.model();
  const double h = step_s;
  stiffness_.blocks = pattern_.blocks;
  add_motion_stiffness(model, state.displacement_m, TangentKind::kProjected, stiffness_);
  system_.blocks = constant_.blocks;
  add_changing_damping(model, state.displacement_m, system_);
  for (std::size_t k = 0; k < system_.blocks.size(); ++k)
    system_.blocks[k] = h * system_.blocks[k] + (h * h) * stiffness_.blocks[k];
  for (std::size_t v = 0; v < model.mass_kg.size(); ++v)
    add_block(system_, static_cast<Index>(v), static_cast<Index>(v), model.mass_kg[v] * kIdentity);
  const MatrixUse use = is_linear_ ? MatrixUse::kKept : MatrixUse::kFewTimes;
  is_definite_ = solver_.prepare(system_, forces.held_bits(), use) == LinearStatus::kSolved;
  prepared_step_s_ = h;
}

ImplicitResult LinearisedStep::find_velocity(MotionForces& forces, const MotionState& state, double step_s,
                                             std::span<Vec3> velocity) {
  const double h = step_s;
  ImplicitResult result;
  result.zero_length_springs =
      forces.evaluate(state.displacement_m, state.velocity_m_s, state.time_s + h, force_);
  if (!is_linear_ || prepared_step_s_ != h) prepare(forces, state, h);

  multiply(stiffness_, state.velocity_m_s, product_, forces.threads());
  for (std::size_t v = 0; v < force_.size(); ++v) force_[v] = h * (force_[v] - h * product_[v]);
  // What held components are told goes to the right-hand side.
  std::copy(state.velocity_m_s.begin(), state.velocity_m_s.end(), velocity.begin());
  set_held_velocity(forces, state, h, velocity);
  for (std::size_t v = 0; v < force_.size(); ++v) change_[v] = velocity[v] - state.velocity_m_s[v];
  if (!forces.held().empty()) {
    multiply(system_, change_, product_, forces.threads());
    for (std::size_t v = 0; v < force_.size(); ++v) force_[v] = force_[v] - product_[v];
  }
  const LinearResult solve = solver_.solve(force_, change_);
  result.iterations = solve.iterations;
  result.solved = is_definite_ && solve.status == LinearStatus::kSolved;
  for (std::size_t v = 0; v < force_.size(); ++v) velocity[v] = velocity[v] + change_[v];
  return result;
}

}  // namespace palpate::dynamics
