// Backward Euler by sweeps over the vertices, each moved to where its own energy is least: vertex block
// descent.
#pragma once

#include <memory>

#include "core/dynamics/integrators/step_balance.h"
#include "core/dynamics/motion/motion_forces.h"

namespace palpate::dynamics {

/// Minimises m / (2 h^2) |u' - u - h v|^2 + elastic energy + loads, vertex by vertex, each with the others
/// where they are by then, `iterations` sweeps a step, every second one backwards:
///
///   u'_v += B_v^-1 f_v,   f_v the forces on v out of balance,
///   B_v = m / h^2 + gamma / h + k (n n^T + (1 - L / |d|)+ (I - n n^T)) + c / h n n^T of its springs
///         + V vertex_stiffness + V / h vertex_damping of its domains + supports
///
/// A step that goes far, or turns a domain inside out whose law minds it, is halved until the vertex's own
/// energy is no higher, with what dampers take on the way. So no vertex raises it, and no motion grows of
/// itself (docs/integrators.md says what is not looked at).
///
/// One vertex at a time in the order of the mesh, so that the result is the same for any number of threads:
/// it uses one. Starts from u + h v.
///
/// Source: A. Chen, Z. Liu, Y. Yang and C. Yuksel, ACM Trans. Graph. 43 (2024), doi 10.1145/3658179.
class VertexDescentStep {
 public:
  /// Throws: InputError for a model with the thesis's volume force, which has no energy.
  VertexDescentStep(const MotionForces& forces, const StepSolverOptions& options);
  ~VertexDescentStep();
  VertexDescentStep(VertexDescentStep&&) noexcept;
  VertexDescentStep& operator=(VertexDescentStep&&) noexcept;

  /// Moves the displacements `u` from the state to the end of the step.
  ImplicitResult find_displacement(MotionForces& forces, const MotionState& state, double step_s,
                                   std::span<Vec3> u);

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace palpate::dynamics
