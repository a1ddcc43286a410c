// The option "objective" of palpate.refined and palpate.surface.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/simplify/refined/stable_step.h"
#include "reference/door/request_options.h"

namespace palpate::reference {

/// Reads the option "objective" and removes it from `options`; the first of `names` is the default. Throws:
/// InputError for an unknown one.
inline simplify::Objective take_objective(nlohmann::json& options, const std::vector<std::string>& names) {
  const std::string& name = names[take_choice(options, "objective", names)];
  if (name == "shape") return simplify::Objective::kShape;
  return name == "quality" ? simplify::Objective::kQuality : simplify::Objective::kStableStep;
}

}  // namespace palpate::reference
