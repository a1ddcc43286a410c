#include "live/body/pad_stepper.h"

#include <optional>

#include "core/dynamics/spring_engine/plain_engine.h"
#include "core/dynamics/tet_engine/tet_engine.h"

namespace palpate::live {
namespace {

using dynamics::MotionState;
using dynamics::SupportFace;

/// PlainEngine or TetEngine.
template <typename Engine>
class EngineStepper : public PadStepper {
 public:
  EngineStepper(const dynamics::MotionModel& model, double escape_m)
      : engine_(model, {.threads = 1, .escape_m = escape_m}) {}

  bool step(double step_s, std::uint64_t steps) override { return !engine_.step(step_s, steps).diverged; }
  void set_pad(const std::vector<SupportFace>& faces) override { engine_.set_pad(faces); }
  void move_pad(const Vec3& by_m) override { engine_.move_pad(by_m); }
  Vec3 pad_force() override { return engine_.pad_force(); }
  void set_state(const MotionState& state) override { engine_.set_state(state); }
  const MotionState& state() override { return state_ = engine_.state(); }

 private:
  Engine engine_;
  MotionState state_;
};

/// Any integrator, on the general forces.
class GeneralStepper : public PadStepper {
 public:
  GeneralStepper(dynamics::MotionModel& model, dynamics::IntegratorKind kind, double escape_m)
      : model_(&model), escape_m_(escape_m), state_(start_at_rest(model)) {
    options_.kind = kind;
    integrator_.emplace(model, options_);
  }

  bool step(double step_s, std::uint64_t steps) override {
    for (std::uint64_t k = 0; k < steps; ++k) {
      integrator_->step(state_, step_s);
      if (!is_within()) return false;
    }
    return true;
  }
  void set_pad(const std::vector<SupportFace>& faces) override {
    own().supports = faces;
    integrator_.emplace(*model_, options_);  // what it keeps of the stiffness or of the last forces is over
  }
  void move_pad(const Vec3& by_m) override {
    for (SupportFace& face : own().supports) face.by_m = by_m;
  }
  Vec3 pad_force() override {
    Vec3 sum;
    for (const SupportFace& face : own().supports) {
      for (const Index v : face.face)
        sum = sum + (4.0 * face.coefficient_n_per_m) * (face.by_m - state_.displacement_m[v]);
    }
    return sum;
  }
  void set_state(const MotionState& state) override {
    state_ = state;
    integrator_.emplace(*model_, options_);
  }
  const MotionState& state() override { return state_; }

 private:
  dynamics::Loads& own() { return model_->loads.back().loads; }

  bool is_within() const {
    for (const Vec3& u : state_.displacement_m) {
      if (!(length_sq(u) <= escape_m_ * escape_m_)) return false;
    }
    return true;
  }

  dynamics::MotionModel* model_;
  dynamics::IntegratorOptions options_;
  double escape_m_;
  std::optional<dynamics::Integrator> integrator_;
  MotionState state_;
};

}  // namespace

std::unique_ptr<PadStepper> make_pad_stepper(dynamics::MotionModel& model, dynamics::IntegratorKind kind,
                                             double escape_m, StepperChoice& choice) {
  if (kind == dynamics::IntegratorKind::kSymplecticEuler) {
    const std::string why_not_springs = find_more_than_plain(model);
    choice.engine = "springs";
    if (why_not_springs.empty())
      return std::make_unique<EngineStepper<dynamics::PlainEngine<float>>>(model, escape_m);
    choice.engine = "tets";
    if (find_more_than_tets(model).empty())
      return std::make_unique<EngineStepper<dynamics::TetEngine<float>>>(model, escape_m);
    choice.why_general = why_not_springs;
  } else {
    choice.why_general = integrator_name(kind);
  }
  choice.engine = "general";
  return std::make_unique<GeneralStepper>(model, kind, escape_m);
}

}  // namespace palpate::live
