#include "core/dynamics/stability/step_map.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <string>

#include "core/base/component.h"
#include "core/base/error.h"
#include "core/dynamics/linear_algebra/vertex_field.h"

namespace palpate::dynamics {
namespace {

/// A component of a vertex that is not held.
struct FreeComponent {
  std::size_t vertex = 0;
  std::size_t axis = 0;
};

std::vector<FreeComponent> find_free(const MotionModel& model) {
  std::vector<bool> is_held(3 * model.elastic.rest.size(), false);
  for (const HeldComponent& held : find_held(model)) is_held[3 * held.vertex + held.axis] = true;
  std::vector<FreeComponent> free;
  for (std::size_t k = 0; k < is_held.size(); ++k) {
    if (!is_held[k]) free.push_back({k / 3, k % 3});
  }
  return free;
}

/// The step's map minus the identity.
Eigen::MatrixXd build_change(BodyStepper& stepper, double step_s, const std::vector<FreeComponent>& free) {
  const auto n = static_cast<Eigen::Index>(free.size());
  Eigen::MatrixXd change(2 * n, 2 * n);
  const MotionState rest = start_at_rest(stepper.model());
  for (Eigen::Index column = 0; column < 2 * n; ++column) {
    MotionState start = rest;
    const bool is_velocity = column >= n;
    const FreeComponent& at = free[static_cast<std::size_t>(is_velocity ? column - n : column)];
    component((is_velocity ? start.velocity_m_s : start.displacement_m)[at.vertex], at.axis) =
        is_velocity ? 1.0 / step_s : 1.0;
    stepper.set_state(start);
    stepper.advance(step_s, 1);
    MotionState end = stepper.state();
    for (Eigen::Index row = 0; row < n; ++row) {
      const FreeComponent& to = free[static_cast<std::size_t>(row)];
      change(row, column) = component(end.displacement_m[to.vertex], to.axis) -
                            component(start.displacement_m[to.vertex], to.axis);
      change(n + row, column) = step_s * (component(end.velocity_m_s[to.vertex], to.axis) -
                                          component(start.velocity_m_s[to.vertex], to.axis));
    }
  }
  return change;
}

}  // namespace

double measure_map_growth(BodyStepper& stepper, double step_s) {
  require(step_s > 0.0 && std::isfinite(step_s), "a finite step above zero");
  const std::vector<FreeComponent> free = find_free(stepper.model());
  require(!free.empty(), "a body that can move");
  Eigen::MatrixXd change = build_change(stepper, step_s, free);
  if (!change.allFinite()) return std::numeric_limits<double>::infinity();
  // The rows of (u, h v) may differ by many powers of ten: (s u, h v) has the same eigenvalues.
  const auto n = static_cast<Eigen::Index>(free.size());
  const double back = change.bottomLeftCorner(n, n).cwiseAbs().maxCoeff();
  if (back > 0.0) {
    const double scale = std::sqrt(back);
    change.topRightCorner(n, n) *= scale;
    change.bottomLeftCorner(n, n) /= scale;
  }
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(change, false);
  require(solver.info() == Eigen::Success, "eigenvalues of a finite matrix");
  double largest = 0.0;
  for (const std::complex<double>& b : solver.eigenvalues()) largest = std::max(largest, std::abs(b));
  constexpr double kFreeMotion = 1e-6;
  double growth = -std::numeric_limits<double>::max();
  for (const std::complex<double>& b : solver.eigenvalues()) {
    if (std::abs(b) > kFreeMotion * largest) growth = std::max(growth, 2.0 * b.real() + std::norm(b));
  }
  return growth;
}

MeasuredStep measure_stable_step_by_map(BodyStepper& stepper, const MeasureMapOptions& options) {
  if (!(options.first_step_s > 0.0) || !std::isfinite(options.first_step_s))
    throw InputError("first step", 0, "a finite number above zero", std::to_string(options.first_step_s));
  if (!(options.first_stride > 1.0) || !(options.first_stride <= 1e6))
    throw InputError("stride", 0, "a number above 1, at most 1e6", std::to_string(options.first_stride));
  if (!(options.tolerance > 0.0))
    throw InputError("tolerance", 0, "a number above zero", std::to_string(options.tolerance));
  MeasuredStep out;
  out.unstable_s = std::numeric_limits<double>::infinity();
  const auto attempt = [&](double step) {
    ++out.trials;
    const double growth = measure_map_growth(stepper, step);
    const bool grows = growth > 0.0;
    (grows ? out.unstable_s : out.stable_s) = step;
    (grows ? out.unstable : out.stable).growth = growth;
    return grows;
  };
  constexpr int kMostStrides = 12;
  double step = options.first_step_s;
  double stride = options.first_stride;
  const bool first_grows = attempt(step);
  for (int k = 0; k < kMostStrides && !out.is_found(); ++k) {
    step = first_grows ? step / stride : step * stride;
    stride *= stride;
    if (!(step > 0.0) || !std::isfinite(step)) break;
    attempt(step);
  }
  while (out.is_found() && out.unstable_s > (1.0 + options.tolerance) * out.stable_s) attempt(out.step_s());
  return out;
}

}  // namespace palpate::dynamics
