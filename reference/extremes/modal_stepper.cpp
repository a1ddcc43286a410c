#include "reference/extremes/modal_stepper.h"

#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/dynamics/linear_algebra/sparse_factor.h"
#include "core/dynamics/reduced/modal_phase.h"

namespace palpate::reference {
namespace {

using dynamics::MotionModel;
using dynamics::MotionState;

/// Rayleigh's shares of a model, of its stiffness and masses with their factors.
dynamics::ModalOptions read_damping(const MotionModel& model, const StabilityTask& task, std::size_t modes) {
  const DampingLaw law = task.problem.damping;
  if (law != DampingLaw::kNone && law != DampingLaw::kStiffness && law != DampingLaw::kMass)
    throw InputError("damping", 0, "none, stiffness or mass for modes", "another");
  dynamics::ModalOptions out;
  out.modes = modes;
  if (model.strain_damping_s > 0.0) out.damping_stiffness_s = model.strain_damping_s;
  if (law == DampingLaw::kMass) {
    const std::vector<double>& factors = task.problem.mass_factors;
    if (std::adjacent_find(factors.begin(), factors.end(), std::not_equal_to<>()) != factors.end())
      throw InputError("mass_ratio", 0, "1 beside damping by mass, for modes", "another");
    out.damping_mass_per_s = model.environment_damping_n_s_per_m.front() / model.mass_kg.front();
  }
  return out;
}

/// The masses of a model in the place of consistent ones, so that its energies are those of the modes.
void lump_masses(const std::vector<double>& mass_kg, dynamics::ElementMatrices& body) {
  const dynamics::BlockMatrix& pattern = body.stiffness;
  for (std::size_t row = 0; row < pattern.rows(); ++row) {
    for (std::size_t k = pattern.offsets[row]; k < pattern.offsets[row + 1]; ++k)
      body.mass_kg[k] = pattern.columns[k] == row ? mass_kg[row] : 0.0;
  }
}

class ModalStepper : public dynamics::BodyStepper {
 public:
  ModalStepper(const MotionModel& model, const StabilityTask& task, std::size_t modes)
      : model_(model), space_(dynamics::build_element_space(task.mesh, 1)), state_(start_at_rest(model)) {
    Material material = task.problem.material;
    material.young_modulus_pa *= task.problem.stiffness_factor;
    matrices_ = build_element_matrices(task.mesh, space_, material);
    lump_masses(model.mass_kg, matrices_);
    const std::size_t n = space_.nodes();
    dynamics::ModalGroup group{{std::vector<Vec3>(n), {}, std::vector<std::uint8_t>(n), std::vector<Vec3>(n)},
                               {}};
    for (const Index v : task.problem.held) group.loads.held[v] = 7;
    const std::size_t free = 3 * (n - task.problem.held.size());
    // Lanczos's method wants fewer modes than there are.
    phase_ = std::make_unique<dynamics::ModalPhase>(
        matrices_, 1, std::vector<dynamics::ModalGroup>{std::move(group)},
        read_damping(model, task, std::min(modes, std::max<std::size_t>(1, free / 3))),
        dynamics::factor_simplicial);
    set_state(state_);
  }

  const MotionModel& model() const override { return model_; }

  void set_state(const MotionState& state) override {
    phase_->start({state.displacement_m, state.velocity_m_s}, state.time_s);
    state_.time_s = state.time_s;
    is_fresh_ = false;
  }

  void advance(double step_s, std::uint64_t steps) override {
    for (std::uint64_t k = 0; k < steps; ++k) {
      state_.time_s += step_s;
      phase_->advance(step_s, state_.time_s);
    }
    is_fresh_ = false;
  }

  const MotionState& state() override {
    if (!is_fresh_) {
      dynamics::NodeState now = phase_->state();
      state_.displacement_m = std::move(now.displacement_m);
      state_.velocity_m_s = std::move(now.velocity_m_s);
      is_fresh_ = true;
    }
    return state_;
  }

  double rounding() const override { return kRounding; }

 private:
  static constexpr double kRounding = 1e-14;

  const MotionModel& model_;
  dynamics::ElementSpace space_;
  dynamics::ElementMatrices matrices_;
  std::unique_ptr<dynamics::ModalPhase> phase_;
  MotionState state_;
  bool is_fresh_ = false;
};

}  // namespace

std::unique_ptr<dynamics::BodyStepper> make_modal_stepper(const MotionModel& model, const StabilityTask& task,
                                                          std::size_t modes) {
  const auto& terms = model.elastic.strain_terms;
  const bool is_linear = terms.size() == 1 && terms[0].op.volume_m3.size() == task.mesh.tets.size() &&
                         model.elastic.springs.springs.empty() &&
                         std::all_of(terms.begin(), terms.end(), [](const dynamics::StrainTerm& term) {
                           return term.law == dynamics::StrainLaw::kLinear;
                         });
  if (!is_linear)
    throw InputError("tets", 0, "linear: modes are of linear tetrahedra at small strain", "another");
  if (task.problem.held.empty()) throw InputError("held", 0, "end: modes are of a body that is held", "none");
  return std::make_unique<ModalStepper>(model, task, modes);
}

}  // namespace palpate::reference
