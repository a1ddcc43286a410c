// What one step does to every small motion: its matrix, taken from the stepper itself, and its eigenvalues.
#pragma once

#include "core/dynamics/stability/measured_step.h"

namespace palpate::dynamics {

/// The greatest |z|^2 - 1 over the eigenvalues z of one step of `step_s`, as a map of (u, step_s v) of the
/// free components. Its columns are the steps from unit displacements and unit velocities; B, the map minus
/// the identity, is what is kept, so that |z|^2 - 1 = 2 Re(b) + |b|^2 is known to about 1e-15 |b| even where
/// z is next to 1. Eigenvalues below 1e-6 of the largest |b| are a body's free motions and left out.
///
/// The time grows with the third power of the vertices: up to some hundred of them (120: about a second).
/// Requires: a linear model (linearise), of which no velocities are limited; a stepper that remembers nothing
///           but its state (velocity Verlet carries an acceleration along). `step_s` finite and above zero.
double measure_map_growth(BodyStepper& stepper, double step_s);

/// How measure_stable_step_by_map tries steps.
struct MeasureMapOptions {
  double first_step_s = 0.0;
  double first_stride =
      1.02;                  ///< the first step is multiplied or divided by it, then by its square and so on
  double tolerance = 0.005;  ///< the bracket's upper end over its lower, minus 1
};

/// The longest stable step by bisection of measure_map_growth's sign. It sees growth that would take any
/// number of steps to show, as explicit Euler's with little damping. Throws: InputError for a first step,
/// stride or tolerance that makes no sense.
MeasuredStep measure_stable_step_by_map(BodyStepper& stepper, const MeasureMapOptions& options);

}  // namespace palpate::dynamics
