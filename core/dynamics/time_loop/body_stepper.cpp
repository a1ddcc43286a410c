#include "core/dynamics/time_loop/body_stepper.h"

#include <string>

#include "core/base/enum_names.h"
#include "core/base/error.h"
#include "core/dynamics/spring_engine/plain_engine.h"
#include "core/dynamics/tet_engine/tet_engine.h"

namespace palpate::dynamics {
namespace {

constexpr EnumNames<Precision, 2> kPrecisionNames{"precision", {"double", "float"}};

constexpr double kDoubleRounding = 1e-14;
constexpr double kSingleRounding = 1e-6;

class IntegratorStepper : public BodyStepper {
 public:
  IntegratorStepper(const MotionModel& model, const IntegratorOptions& options)
      : model_(&model), integrator_(model, options), state_(start_at_rest(model)) {}

  const MotionModel& model() const override { return *model_; }
  void set_state(const MotionState& state) override {
    state_ = state;
    unsolved_ = 0;
  }
  void advance(double step_s, std::uint64_t steps) override {
    for (std::uint64_t k = 0; k < steps; ++k) unsolved_ += integrator_.step(state_, step_s).solved ? 0 : 1;
  }
  std::uint64_t steps_unsolved() const override { return unsolved_; }
  const MotionState& state() override { return state_; }
  double rounding() const override { return kDoubleRounding; }

 private:
  const MotionModel* model_;
  Integrator integrator_;
  MotionState state_;
  std::uint64_t unsolved_ = 0;
};

/// PlainEngine or TetEngine.
template <typename Engine>
class EngineStepper : public BodyStepper {
 public:
  EngineStepper(const MotionModel& model, int threads) : model_(&model), engine_(model, {threads, 0.0}) {}

  const MotionModel& model() const override { return *model_; }
  void set_state(const MotionState& state) override { engine_.set_state(state); }
  void advance(double step_s, std::uint64_t steps) override { engine_.step(step_s, steps); }
  const MotionState& state() override { return state_ = engine_.state(); }
  double rounding() const override { return is_single(engine_) ? kSingleRounding : kDoubleRounding; }

 private:
  template <template <typename> class Any>
  static bool is_single(const Any<float>&) {
    return true;
  }
  template <template <typename> class Any>
  static bool is_single(const Any<double>&) {
    return false;
  }

  const MotionModel* model_;
  Engine engine_;
  MotionState state_;
};

}  // namespace

Precision parse_precision(std::string_view name) {
  return kPrecisionNames.parse(name);
}

const char* precision_name(Precision precision) {
  return kPrecisionNames.of(precision);
}

std::unique_ptr<BodyStepper> make_stepper(const MotionModel& model, const IntegratorOptions& options) {
  return std::make_unique<IntegratorStepper>(model, options);
}

std::unique_ptr<BodyStepper> make_plain_stepper(const MotionModel& model, Precision precision, int threads) {
  if (precision == Precision::kSingle)
    return std::make_unique<EngineStepper<PlainEngine<float>>>(model, threads);
  return std::make_unique<EngineStepper<PlainEngine<double>>>(model, threads);
}

std::unique_ptr<BodyStepper> make_tet_stepper(const MotionModel& model, Precision precision, int threads) {
  if (precision == Precision::kSingle)
    return std::make_unique<EngineStepper<TetEngine<float>>>(model, threads);
  return std::make_unique<EngineStepper<TetEngine<double>>>(model, threads);
}

}  // namespace palpate::dynamics
