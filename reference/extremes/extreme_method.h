// What steps a body of the contest stability: an integrator, one of the fast engines, or modes.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "core/dynamics/motion/integrator_kind.h"
#include "core/dynamics/time_loop/body_stepper.h"
#include "core/mesh/tet_mesh.h"
#include "reference/door/stability_problem.h"

namespace palpate::reference {

/// The integrator that a method names, or what steps in its place.
struct ExtremeMethod {
  enum class Engine { kGeneral, kPlain, kTets, kModes };

  std::string name;
  dynamics::IntegratorKind kind = dynamics::IntegratorKind::kSymplecticEuler;  ///< not of kModes
  Engine engine = Engine::kGeneral;
  dynamics::Precision precision = dynamics::Precision::kDouble;  ///< kPlain and kTets
  dynamics::StepSolverOptions solver;
  std::size_t modes = 30;  ///< kModes: at most

  bool is_single() const { return precision == dynamics::Precision::kSingle; }
  /// Whether no step is too long by what is known.
  bool has_no_bound() const { return engine == Engine::kModes || dynamics::is_implicit(kind); }
  /// Whether its forces can be made linear.
  bool has_linear_form() const { return engine != Engine::kPlain; }

  /// Throws: InputError for a model that it cannot take. `model` and `task` must outlive the stepper.
  std::unique_ptr<dynamics::BodyStepper> make(const dynamics::MotionModel& model, const StabilityTask& task,
                                              int threads) const;
};

/// Reads "motion.NAME". `options` loses what says how an integrator solves, and the number of modes. Sweeps
/// take as many as asked, others until the step is solved. Throws: InputError.
ExtremeMethod take_method(const std::string& name, nlohmann::json& options);

}  // namespace palpate::reference
