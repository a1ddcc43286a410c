#include "experiments/registry/stability_settings.h"

#include <optional>
#include <string>
#include <utility>

namespace palpate::experiments {
namespace {

OptionSpec number(std::string name, std::optional<double> min, double fallback, std::string help) {
  return {std::move(name), OptionType::kNumber, {}, min, std::nullopt, fallback, std::move(help)};
}

OptionSpec choice(std::string name, std::vector<std::string> choices, const char* fallback,
                  std::string help) {
  return {std::move(name), OptionType::kChoice, std::move(choices), std::nullopt, std::nullopt,
          fallback,        std::move(help)};
}

std::vector<OptionSpec> make_settings() {
  std::vector<OptionSpec> out{
      number("size_m", 0.0, 0.1, "the mesh is scaled to this longest side; 0: as it is"),
      number("coordinate_scale", 0.0, 1.0, "then all coordinates times this"),
      number("coordinate_shift_m", std::nullopt, 0.0, "then all coordinates plus this"),
      number("size_ratio", 1.0, 1.0,
             "the mesh becomes a cone whose elements are so many times larger at one end"),
      number("sliver_deg", 0.0, 0.0, "so flat are some tetrahedra made; 0: none"),
      choice("held", {"end", "none"}, "end", "the tenth of the body at the low end of its longest side"),
      number("poisson_ratio", -0.99, 0.25, "of the material (10 kPa, 1050 kg/m^3)"),
      number("stiffness_factor", 0.0, 1.0, "all stiffness times this"),
      number("mass_factor", 0.0, 1.0, "all masses times this"),
      number("mass_ratio", 1.0, 1.0,
             "each mass also times a random factor from 1 to this, even in its logarithm"),
      choice("damping", {"none", "stiffness", "mass", "axial", "isotropic", "drag"}, "axial",
             "Rayleigh's two; equal for all springs, axial or isotropic; equal for all vertices"),
      number("damping_ratio", 0.0, 0.05,
             "of the fastest motion of the body without factors, about; 1: critical"),
      choice("start", {"random", "stretch", "shear", "invert"}, "random",
             "runs start so, without speed; invert: the last quarter of its length is mirrored"),
      number("strain", std::nullopt, 1e-6,
             "how far: random: over the body's size; invert: 1 is the mirror image"),
      {"seed", OptionType::kInteger, {}, 0.0, std::nullopt, 1, "of perturbations, masses and slivers"}};
  for (OptionSpec& setting : out) {
    if (setting.name == "poisson_ratio") setting.max = 0.499999;
    if (setting.name == "sliver_deg") setting.max = 60.0;
  }
  return out;
}

}  // namespace

const std::vector<OptionSpec>& stability_settings() {
  static const std::vector<OptionSpec> settings = make_settings();
  return settings;
}

}  // namespace palpate::experiments
