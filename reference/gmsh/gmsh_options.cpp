// Built with gmsh, GPL: this program is distributed under GPL-3.0-or-later.
#include "core/base/error.h"
#include "reference/gmsh/gmsh_tools.h"

namespace palpate::reference {

double take_optimize_threshold(nlohmann::json& options) {
  const auto given = options.find("optimize_threshold");
  if (given == options.end()) return FillSettings{}.optimize_threshold;
  if (!given->is_number() || !(*given >= 0.0 && *given <= 1.0)) {
    throw InputError("optimize_threshold", 0, "a number from 0 to 1", given->dump());
  }
  const auto threshold = given->get<double>();
  options.erase(given);
  return threshold;
}

}  // namespace palpate::reference
