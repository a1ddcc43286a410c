// The plain path: springs with axial damping, loads and symplectic Euler, nothing else, as fast as it goes.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "core/dynamics/motion/motion_model.h"
#include "core/dynamics/spring_engine/plain_options.h"

namespace palpate::dynamics {

/// What of a model the plain path cannot take: "strain energies", "a volume force", "linearised springs" or
/// "isotropic damping". Empty: it takes all of it.
std::string find_more_than_plain(const MotionModel& model);

/// Steps a body of springs in single or double precision:
///
///   v' = v + h / m (sum of (k (1 - L / r) + c (w . d) / r^2) d - gamma v + f),  x' = x + h v'
///
/// d and w are the differences of positions and velocities of a spring's ends, r = |d|, f the loads: dead
/// ones, elastic supports and pads, each with its profile (core/dynamics/spring_engine/plain_loads.h). Held
/// components follow their profiles, as Integrator has them. Positions are kept from the rest shape's centre.
/// The arithmetic is fixed by the layout alone (core/dynamics/spring_engine/plain_layout.h): one thread and
/// two give the same bits, with AVX2 and without.
///
/// Precision: of single precision, an elongation is known to about 1e-7 of the distance from the centre.
template <typename Real>
class PlainEngine {
 public:
  /// Throws: as validate(MotionModel); InputError for a model with more than it takes
  /// (find_more_than_plain).
  PlainEngine(const MotionModel& model, const PlainOptions& options);
  ~PlainEngine();
  PlainEngine(PlainEngine&&) noexcept;
  PlainEngine& operator=(PlainEngine&&) noexcept;

  /// Shape: as MotionState of the model. Held components are put where their profiles have them.
  void set_state(const MotionState& state);
  MotionState state() const;

  /// Takes `steps` steps of length `step_s` > 0.
  PlainReport step(double step_s, std::uint64_t steps, const PlainObserver& observer = {});

  /// The force of each group of loads on the body, in N, at the start of the last step
  /// (MotionForces::group_forces); zero before the first.
  const std::vector<Vec3>& group_forces() const;

  /// Puts an elastic pad on faces of the body between two steps, at rest, in the place of the one before; no
  /// faces: takes it away. move_pad says how far it is moved; SupportFace::by_m is not read. It acts like the
  /// supports of a group of loads, but for a last place of rounding.
  void set_pad(std::span<const SupportFace> faces);
  void move_pad(const Vec3& by_m);
  /// The pad's force on the body at the start of the last step, in N; zero without one.
  Vec3 pad_force() const;

  /// Whether springs are computed eight at a time: in single precision, on a processor that can.
  bool uses_avx2() const;

  /// What one step reads and writes at the least: springs, vertices before and after, masses and loads;
  /// what a write fetches first is not counted.
  std::size_t bytes_per_step() const;

  std::size_t springs() const;
  /// Springs between two blocks, which are computed twice.
  std::size_t springs_across() const;

 private:
  struct Body;
  std::unique_ptr<Body> body_;
};

extern template class PlainEngine<float>;
extern template class PlainEngine<double>;

}  // namespace palpate::dynamics
