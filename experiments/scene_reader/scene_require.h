// What a scene requires of a model: tolerance and budget, for `palpate fit`.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "experiments/text/yaml_value.h"

namespace palpate::experiments {

/// What is to be reached, and what must remain possible.
struct SceneRequirement {
  std::string measure;                      ///< of the judge: "displacement_deformation", ...
  double at_most = 0.0;                     ///< of that error, relative
  std::optional<double> time_per_second_s;  ///< of the clock, for a simulated second
  std::optional<double> rate_hz;            ///< answers a second
  std::optional<double> answer_s;           ///< of the clock, for a first answer
  std::optional<std::uint64_t> memory_bytes;
  std::vector<std::string> needs;  ///< of what a model can do: "large_strain", "supports", "cuts", ...
};

/// What a scene may ask to remain changeable, beside its loads.
const std::vector<std::string>& changeable_things();

/// Reads the mapping below `require`:
///
///   require:
///     error: {measure: deformation_l2, at_most: 0.05}   # relative_l2, energy, max, pad_force
///     time_per_second_s: 0.5      # wall time of a simulated second: a model that moves
///     rate_hz: 1000               # at rest: answers to new loads a second
///     answer_s: 1                 # at rest: the first answer, set-up and all
///     memory_bytes: 500000000
///     large_strain: true
///     may_change: [supports, cuts]
///
/// Throws: InputError with file and line, also for two budgets that exclude each other.
SceneRequirement read_requirement(const YamlValue& value);

}  // namespace palpate::experiments
