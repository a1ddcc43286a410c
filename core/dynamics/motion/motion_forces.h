// The forces on a moving body, added up in one order on any number of threads.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/dynamics/elasticity/tangent.h"
#include "core/dynamics/linear_algebra/block_matrix.h"
#include "core/dynamics/motion/motion_model.h"
#include "core/dynamics/motion/vertex_incidence.h"

namespace palpate::dynamics {

/// Evaluates the right-hand side of the equation of motion.
///
/// The force of each spring and the stress of each domain is found once, in parallel; each vertex then adds
/// up its own in a fixed order. So the bits of the result don't depend on the number of threads.
class MotionForces {
 public:
  /// `model` must outlive this. Throws: as validate(MotionModel).
  MotionForces(const MotionModel& model, int threads);

  /// All forces in N at displacements `u`, velocities `v` and time `time_s`, held components included: there
  /// it is what the holder has to balance.
  ///
  /// Returns:  number of springs of length zero; they have no direction and give no force.
  std::size_t evaluate(std::span<const Vec3> u, std::span<const Vec3> v, double time_s,
                       std::span<Vec3> force);

  /// The force that each group of loads exerts on the body at a state, in N: supports, dead loads, and at
  /// held components what moves them as prescribed, m a - (the other forces).
  std::vector<Vec3> group_forces(const MotionState& state);

  /// Puts held components where the profiles have them at `time_s`, with the profiles' velocities.
  void impose(double time_s, std::span<Vec3> u, std::span<Vec3> v) const;

  const MotionModel& model() const { return *model_; }
  const std::vector<HeldComponent>& held() const { return held_; }
  /// Bit i of entry v: axis i of vertex v is held.
  const std::vector<std::uint8_t>& held_bits() const { return held_bits_; }
  int threads() const { return threads_; }

 private:
  std::size_t pull_springs(std::span<const Vec3> u, std::span<const Vec3> v);
  void stress_domains(std::span<const Vec3> u, std::span<const Vec3> v);
  void gather(std::span<const Vec3> v, std::span<Vec3> force) const;

  const MotionModel* model_;
  int threads_;
  std::vector<HeldComponent> held_;
  std::vector<std::uint8_t> held_bits_;
  VertexLists spring_ends_;                ///< 2 s for the first end of spring s, 2 s + 1 for the second
  std::vector<VertexLists> term_entries_;  ///< of each term: entries of its operator
  std::vector<std::vector<Index>> domain_of_entry_;
  std::vector<Vec3> pull_;                 ///< on the first end of each spring
  std::vector<std::vector<Mat3>> stress_;  ///< -V P of each domain of each term
};

/// The zero matrix with the pattern of stiffness and damping, supports included.
BlockMatrix build_motion_pattern(const MotionModel& model);

/// Adds stiffness in N/m: the elastic model's tangent and the supports. The volume force's part, which is not
/// symmetric, is left out.
void add_motion_stiffness(const MotionModel& model, std::span<const Vec3> u, TangentKind kind,
                          BlockMatrix& matrix);

/// Whether stiffness and damping are the same at every `u`: springs, if any, along their directions at rest,
/// linear laws, no volume force.
bool is_linear_body(const MotionModel& model);

/// Adds add_motion_stiffness and `rate_per_s` times add_changing_damping, each domain in one pass.
void add_motion_tangent(const MotionModel& model, std::span<const Vec3> u, TangentKind kind,
                        double rate_per_s, BlockMatrix& matrix);

/// Adds the damping matrix in N s/m, minus the derivative of the forces by the velocities: the part that
/// changes with `u`, of springs and of strain terms at large strain, and the part that never does, of
/// environment and linear strain terms.
void add_changing_damping(const MotionModel& model, std::span<const Vec3> u, BlockMatrix& matrix);
/// The part that never changes; see add_changing_damping.
void add_constant_damping(const MotionModel& model, BlockMatrix& matrix);

}  // namespace palpate::dynamics
