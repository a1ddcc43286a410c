// What a simulated second of an elastic model costs: its longest stable step, and the time that a step takes.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "core/dynamics/elasticity/elastic_model.h"
#include "core/dynamics/elasticity/loads.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::reference {

/// Share of the predicted bound that a step takes, as `simulate` does where a scene says "auto".
inline constexpr double kStepSafety = 0.9;

/// Cost of explicit steps of one body.
struct StepCost {
  double stable_step_s = 0.0;  ///< predicted bound of symplectic Euler, undamped
  double step_wall_s = 0.0;    ///< that a step takes: median of nine runs of some 10 ms
  std::string engine;          ///< "plain", "tets" (both single precision) or "general"
  bool is_finite = true;       ///< of the last state

  /// Time for a simulated second, kStepSafety of the bound a step.
  double simulated_second_s() const { return step_wall_s / (kStepSafety * stable_step_s); }
};

/// Steps the body from rest under all of `loads`, with symplectic Euler, lumped masses and no damping, on the
/// fastest engine that takes the model. Springs without strain energies turn with the body, whatever the
/// strain: that is what the plain engine is for.
///
/// Requires: a density above zero. Throws: InputError for a body without a stable step, and as
/// predict_stable_step.
StepCost measure_step_cost(const TetMesh& mesh, dynamics::ElasticModel model, const dynamics::Loads& loads,
                           double density_kg_m3, int threads);

/// Adds explicit_step_s (the bound), step_wall_s, simulated_second_s and step_engine. Where the motion left
/// the finite numbers, the times are null: they were no steps of a body.
void report_step_cost(const StepCost& cost, nlohmann::json& report);

}  // namespace palpate::reference
