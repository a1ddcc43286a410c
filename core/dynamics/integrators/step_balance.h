// What implicit steps have in common: what is held, and how far a step is from being solved.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/dynamics/motion/integrator_kind.h"
#include "core/dynamics/motion/motion_forces.h"

namespace palpate::dynamics {

/// What a solve for the end of a step came to.
struct ImplicitResult {
  std::size_t zero_length_springs = 0;
  std::size_t iterations = 0;
  bool solved = true;
  /// Forces out of balance over those of the inertial guess; nothing where it was not measured.
  std::optional<double> residual_relative;
};

/// Whether what is left over is measured in step `count` (from 0) where no tolerance asks for it: it takes an
/// evaluation of the forces.
constexpr bool is_leftover_due(std::size_t count) {
  constexpr std::size_t kEvery = 32;
  return count % kEvery == 0;
}

/// What rounding leaves out of balance in a step: below it no iteration gets.
class RoundingFloor {
 public:
  explicit RoundingFloor(const MotionForces& forces);

  /// 16 eps sqrt(sum of ((|K_vv| + m_v / h^2) |u_v|)^2) in N, K the stiffness at rest.
  double of(std::span<const Vec3> u, double step_s) const;

 private:
  std::vector<double> stiffness_n_per_m_;  ///< |K_vv|
  std::vector<double> mass_kg_;
};

/// f - M a at the end of a backward Euler step from `state` to the displacements `u`, v' = (u - u_state) / h,
/// a = (v' - v) / h, in N; zero at held components.
///
/// Returns:  number of springs of length zero.
std::size_t find_imbalance(MotionForces& forces, const MotionState& state, double step_s,
                           std::span<const Vec3> u, std::span<Vec3> velocity, std::span<Vec3> imbalance);

/// Sets held components to where their profiles have them at the end of the step; `u` keeps the others.
void set_held(const MotionForces& forces, double time_s, std::span<Vec3> u);

/// u + h v, held components where they belong at the end of the step: where a body would be without forces.
void set_inertial_guess(const MotionForces& forces, const MotionState& state, double step_s,
                        std::span<Vec3> u);

/// When a step counts as solved. What it needs to know of rounding is found only where there is a tolerance.
class StepGoal {
 public:
  StepGoal(const MotionForces& forces, const StepSolverOptions& options);

  /// Whether `residual` is below the tolerance times `first`, that of the inertial guess, or below what
  /// rounding leaves at the displacements `u` (norms of the forces out of balance, in N). Without a
  /// tolerance only a residual of zero will do.
  bool is_met(double residual, double first, std::span<const Vec3> u, double step_s) const;

  /// The residual that is_met asks for, in N; 0 without a tolerance.
  double target(double first, std::span<const Vec3> u, double step_s) const;

 private:
  double tolerance_;
  std::optional<RoundingFloor> rounding_;
};

/// Backward Euler by sweeps, and how it looks at itself.
class Sweeper {
 public:
  Sweeper(const MotionForces& forces, const StepSolverOptions& options);

  /// Takes `u` from the inertial guess to the end of a step from `state`: `sweep` moves it, given the number
  /// of sweeps before it in this step, until the step is solved as the options have it.
  ImplicitResult solve(MotionForces& forces, const MotionState& state, double step_s, std::span<Vec3> u,
                       const std::function<void(std::size_t)>& sweep);

 private:
  StepSolverOptions options_;
  StepGoal goal_;
  std::size_t steps_ = 0;  ///< before this one
  std::vector<Vec3> velocity_;
  std::vector<Vec3> imbalance_;
};

}  // namespace palpate::dynamics
