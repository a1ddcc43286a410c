// The plain path: springs with axial damping and symplectic Euler, nothing else, as fast as it goes.
#pragma once

#include <cstdint>
#include <memory>

#include "core/dynamics/motion_model.h"

namespace palpate::dynamics {

struct PlainOptions {
  int threads = 1;
  double speed_limit_m_s = 0.0;  ///< 0: no limit
  bool portable = false;         ///< do without AVX2 where there is one; the bits are the same
};

/// What happened in some steps.
struct PlainReport {
  std::uint64_t speeds_cut = 0;              ///< vertices times steps
  std::uint64_t steps_with_zero_length = 0;  ///< in which a spring had no length (below 1e-18 m) and no force
};

/// Steps a body of springs in single or double precision:
///
///   v' = v + h / m (sum of (k (1 - L / r) + c (w . d) / r^2) d - gamma v + f),  x' = x + h v'
///
/// d and w are the differences of positions and velocities of a spring's ends, r = |d|, f the loads in full.
/// Positions are kept from the rest shape's centre. The arithmetic is fixed by the layout alone
/// (core/dynamics/plain_layout.h): one thread and two give the same bits, with AVX2 and without.
///
/// Precision: of single precision, an elongation is known to about 1e-7 of the distance from the centre.
template <typename Real>
class PlainEngine {
 public:
  /// Throws: InputError for a model with more than it takes: strain terms, a volume force, linearised
  /// springs, isotropic damping, elastic supports, prescribed motions, or vertices held in some directions
  /// alone.
  PlainEngine(const MotionModel& model, const PlainOptions& options);
  ~PlainEngine();
  PlainEngine(PlainEngine&&) noexcept;
  PlainEngine& operator=(PlainEngine&&) noexcept;

  /// Shape: as MotionState of the model.
  void set_state(const MotionState& state);
  MotionState state() const;

  /// Takes `steps` steps of length `step_s` > 0.
  PlainReport step(double step_s, std::uint64_t steps);

  /// Whether springs are computed eight at a time: in single precision, on a processor that can.
  bool uses_avx2() const;

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
