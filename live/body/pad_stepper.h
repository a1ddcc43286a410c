// One face for all that can step a body under a finger: the plain engine, the tet engine and the integrators.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/dynamics/integrators/integrator.h"

namespace palpate::live {

/// Steps a body that one elastic pad may press, which comes, moves and goes between steps.
class PadStepper {
 public:
  virtual ~PadStepper() = default;

  /// Takes `steps` steps of `step_s` > 0. Returns: whether all displacements are finite and none is beyond
  /// the bound; if not, it may have stopped early.
  virtual bool step(double step_s, std::uint64_t steps) = 0;
  /// Another pad, at rest; none: no faces.
  virtual void set_pad(const std::vector<dynamics::SupportFace>& faces) = 0;
  virtual void move_pad(const Vec3& by_m) = 0;
  /// The pad's force on the body, in N.
  virtual Vec3 pad_force() = 0;
  virtual void set_state(const dynamics::MotionState& state) = 0;
  /// As it stands; good until the next call.
  virtual const dynamics::MotionState& state() = 0;
};

/// What steps a body, by name, and why it is not a faster one.
struct StepperChoice {
  std::string engine;  ///< "springs", "tets" (both eight at a time, single precision) or "general" (double)
  std::string why_general;
};

/// The fastest stepper that takes the model and the integrator. A displacement beyond `escape_m` is an
/// escape. The last group of the model's loads is the pad's own, and has none of its own: the general stepper
/// writes its faces there. `model` must outlive it. Throws: as Integrator.
std::unique_ptr<PadStepper> make_pad_stepper(dynamics::MotionModel& model, dynamics::IntegratorKind kind,
                                             double escape_m, StepperChoice& choice);

}  // namespace palpate::live
