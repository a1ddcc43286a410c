#include "experiments/scene_writer/unit_guess.h"

#include <algorithm>

#include "core/base/number_text.h"

namespace palpate::experiments {

std::optional<UnitGuess> guess_unit(double diagonal) {
  constexpr double kUsuallyFromM = 0.04;
  constexpr double kUsuallyToM = 0.4;
  std::vector<double> fitting;
  for (const double unit : {0.001, 0.01, 1.0}) {
    const double size = unit * diagonal;
    if (size >= kSmallestOrganM && size <= kLargestOrganM) fitting.push_back(unit);
  }
  if (fitting.empty()) return std::nullopt;
  const auto usual = std::find_if(fitting.begin(), fitting.end(), [&](double unit) {
    return unit * diagonal >= kUsuallyFromM && unit * diagonal <= kUsuallyToM;
  });
  UnitGuess guess;
  guess.unit_m = usual == fitting.end() ? fitting.front() : *usual;
  std::copy_if(fitting.begin(), fitting.end(), std::back_inserter(guess.others),
               [&](double unit) { return unit != guess.unit_m; });
  return guess;
}

std::string unit_name(double unit_m) {
  if (unit_m == 0.001) return "mm";
  if (unit_m == 0.01) return "cm";
  if (unit_m == 1.0) return "m";
  return short_number(unit_m) + " m";
}

}  // namespace palpate::experiments
