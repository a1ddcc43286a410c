// One face for all that can step a body: the integrators, and the plain and the tet engine in either
// precision.
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>

#include "core/dynamics/integrators/integrator.h"

namespace palpate::dynamics {

/// In which numbers the plain and the tet engine compute.
enum class Precision { kDouble, kSingle };

/// "double" or "float". Throws: InputError.
Precision parse_precision(std::string_view name);
/// The name that parse_precision reads.
const char* precision_name(Precision precision);

/// Steps one body, for those who watch it without caring how.
class BodyStepper {
 public:
  virtual ~BodyStepper() = default;

  virtual const MotionModel& model() const = 0;
  virtual void set_state(const MotionState& state) = 0;
  /// Takes `steps` steps of `step_s` > 0.
  virtual void advance(double step_s, std::uint64_t steps) = 0;
  /// As it stands; good until the next call.
  virtual const MotionState& state() = 0;
  /// Steps since set_state whose solver did not come to its tolerance.
  virtual std::uint64_t steps_unsolved() const { return 0; }
  /// Below this share of a body's size a displacement is rounding: 1e-14, single precision 1e-6.
  virtual double rounding() const = 0;
};

/// `model` must outlive the stepper. Throws: as Integrator.
std::unique_ptr<BodyStepper> make_stepper(const MotionModel& model, const IntegratorOptions& options);

/// The plain engine (core/dynamics/spring_engine/plain_engine.h). `model` must outlive it. Throws: as
/// PlainEngine.
std::unique_ptr<BodyStepper> make_plain_stepper(const MotionModel& model, Precision precision, int threads);

/// The tet engine (core/dynamics/tet_engine/tet_engine.h). `model` must outlive it. Throws: as TetEngine.
std::unique_ptr<BodyStepper> make_tet_stepper(const MotionModel& model, Precision precision, int threads);

}  // namespace palpate::dynamics
