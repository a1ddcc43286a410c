// The option "objective" of palpate.refined and palpate.surface.
#pragma once

#include <array>
#include <nlohmann/json.hpp>

#include "core/simplify/refined/stable_step.h"
#include "reference/door/request_options.h"

namespace palpate::reference {

/// Reads the option "objective" of palpate.refined and removes it from `options`. Throws: InputError for an
/// unknown one.
inline simplify::Objective take_objective_inside(nlohmann::json& options) {
  constexpr std::array kObjectives{simplify::Objective::kShape, simplify::Objective::kQuality,
                                   simplify::Objective::kStableStep};
  return kObjectives[take_choice(options, "objective", {"shape", "quality", "stable_step"})];
}

/// The same of palpate.surface.
inline simplify::Objective take_objective_of_surface(nlohmann::json& options) {
  constexpr std::array kObjectives{simplify::Objective::kQuality, simplify::Objective::kStableStep};
  return kObjectives[take_choice(options, "objective", {"quality", "stable_step"})];
}

}  // namespace palpate::reference
