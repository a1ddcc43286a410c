#include "experiments/spring_training/training_report.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <vector>

#include "core/base/number_text.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

constexpr std::array kSets{"train", "validate", "test_loads", "test_clamps"};
constexpr std::array kModels{"start", "calibrated_opposite", "fem_p1", "trained"};

std::string error_percent(const json& error) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.2f", 100.0 * error.get<double>());
  return text.data();
}

/// What was written, and why.
std::string verdict(const json& report) {
  if (report.at("kept") == "trained")
    return "Ridge " + short_number(report.at("ridge").get<double>()) +
           ", chosen by the validation set alone; no choice looked at the test sets.\n";
  const json& ridges = report.at("ridges");
  const auto best = std::min_element(ridges.begin(), ridges.end(), [](const json& a, const json& b) {
    return a.at("validate_rms").get<double>() < b.at("validate_rms").get<double>();
  });
  return "Training did not help: on the validation set the start is at " +
         error_percent(report.at("start_validate_rms")) + "%, the best fit at " +
         error_percent(best->at("validate_rms")) + "%. The start was written, untrained.\n";
}

}  // namespace

std::string training_tables(const json& report) {
  TextTable table({"set", "cases", "model", "rms %", "worst %", "worst case"}, "lrlrrl");
  for (const char* set : kSets) {
    const json& split = report.at("sets").at(set);
    const json& cases = split.at("cases");
    for (const char* model : kModels) {
      const bool is_first = model == kModels.front();
      const json& found = split.at("models").at(model);
      const auto errors = found.at("errors").get<std::vector<double>>();
      const auto at = std::max_element(errors.begin(), errors.end()) - errors.begin();
      table.add({is_first ? set : "", is_first ? std::to_string(cases.size()) : "", model,
                 error_percent(found.at("rms")), error_percent(found.at("worst")),
                 cases.at(static_cast<std::size_t>(at)).get<std::string>()});
    }
  }
  TextTable ridges({"ridge", "train rms %", "validate rms %", "iterations"}, "rrrr");
  for (const json& result : report.at("ridges"))
    ridges.add({short_number(result.at("ridge").get<double>()), error_percent(result.at("train_rms")),
                error_percent(result.at("validate_rms")),
                std::to_string(result.at("iterations").get<std::size_t>())});
  return "Relative L2 error of the displacement against quadratic elements\n" + table.text() + '\n' +
         ridges.text() + verdict(report);
}

}  // namespace palpate::experiments
