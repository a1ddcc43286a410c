// What a plan sweeps over, axis by axis.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "experiments/contestants/stop.h"
#include "experiments/registry/method_options.h"
#include "experiments/text/yaml_value.h"

namespace palpate::experiments {

/// One dimension of the sweep.
struct SweepAxis {
  std::string name;  ///< a stop ("tets_removed_ratio", "fusions", "tets"), "poisson_ratio", "vertices" or
                     ///< "option.NAME"
  std::vector<nlohmann::json> values;
  std::vector<GivenOption> texts;  ///< the same as written, for options

  bool is_option() const { return name.rfind("option.", 0) == 0; }
  bool is_problem() const { return name == "poisson_ratio" || name == "vertices"; }
  bool is_stop() const { return !is_option() && !is_problem(); }
  std::string option() const { return name.substr(7); }
  StopKind stop_kind() const;
};

/// The value of a stop, checked against its kind: counts are whole and not negative, a ratio is in [0, 1).
double read_stop_value(StopKind kind, const YamlValue& value);

/// Reads the axes of a sweep. `axes`: the names that the plan's contest knows beside option.NAME.
/// Throws: InputError with file and line for an unknown axis (with the nearest), two kinds of stop, values
/// twice or out of range.
std::vector<SweepAxis> read_sweep(const YamlValue& value, const std::vector<std::string>& axes);

}  // namespace palpate::experiments
