#include "experiments/spring_training/training_report.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/springs/network/moduli_csv.h"
#include "core/springs/network/springs_csv.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

double worst(const std::vector<double>& errors) {
  return *std::max_element(errors.begin(), errors.end());
}

std::string percent(double error) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.2f", 100.0 * error);
  return text.data();
}

/// What was written, and why.
std::string verdict(const TrainingOutcome& outcome) {
  const RidgeResult& best = outcome.ridges[outcome.chosen];
  if (outcome.start_is_kept)
    return "Training did not help: on the validation set the start is at " +
           percent(outcome.start_validate_rms) + "%, the best fit at " + percent(best.validate_rms) +
           "%. The start was written, untrained.\n";
  return "Ridge " + short_number(best.ridge) +
         ", chosen by the validation set alone; no choice looked at the test sets.\n";
}

json describe_split(const TrainingOutcome& outcome, const SplitErrors& split) {
  json out = {{"cases", split.cases}};
  for (std::size_t m = 0; m < outcome.models.size(); ++m) {
    const std::vector<double>& errors = split.of_model[m];
    out["models"][outcome.models[m]] = {
        {"rms", root_mean_square(errors)}, {"worst", worst(errors)}, {"errors", errors}};
  }
  return out;
}

}  // namespace

void write_trained_springs(const std::filesystem::path& path, const TrainingInput& input,
                           const TrainingOutcome& outcome) {
  SpringNetwork network = input.start.network;
  require(outcome.constant.size() >= network.springs.size(), "training: one constant a spring");
  std::copy_n(outcome.constant.begin(), network.springs.size(), network.stiffness_n_per_m.begin());
  springs::write_springs_csv(path, network);
}

void write_trained_moduli(const std::filesystem::path& path, TrainedVolume volume, const TrainingInput& input,
                          const TrainingOutcome& outcome) {
  require(volume != TrainedVolume::kNone, "training: moduli belong to a volume model");
  const auto first =
      outcome.constant.begin() + static_cast<std::ptrdiff_t>(input.start.network.springs.size());
  springs::write_moduli_csv(path, {volume == TrainedVolume::kNodeAverage, {first, outcome.constant.end()}});
}

json build_training_report(const TrainingInput& input, const TrainingOutcome& outcome) {
  const std::size_t springs = input.start.network.springs.size();
  json report{{"vertices", input.mesh.points.size()},
              {"springs", springs},
              {"moduli", outcome.constant.size() - springs},
              {"kept", outcome.start_is_kept ? "start" : "trained"},
              {"start_validate_rms", outcome.start_validate_rms},
              {"ridge", outcome.start_is_kept ? json(nullptr) : json(outcome.ridges[outcome.chosen].ridge)}};
  for (const RidgeResult& result : outcome.ridges)
    report["ridges"].push_back({{"ridge", result.ridge},
                                {"train_rms", result.train_rms},
                                {"validate_rms", result.validate_rms},
                                {"iterations", result.lbfgs.iterations},
                                {"evaluations", result.lbfgs.evaluations}});
  for (const SplitErrors& split : outcome.errors) report["sets"][split.name] = describe_split(outcome, split);
  return report;
}

std::string training_tables(const TrainingOutcome& outcome) {
  TextTable table({"set", "cases", "model", "rms %", "worst %", "worst case"}, "lrlrrl");
  for (const SplitErrors& split : outcome.errors) {
    for (std::size_t m = 0; m < outcome.models.size(); ++m) {
      const std::vector<double>& errors = split.of_model[m];
      const auto at = std::max_element(errors.begin(), errors.end()) - errors.begin();
      table.add({m == 0 ? split.name : "", m == 0 ? std::to_string(split.cases.size()) : "",
                 outcome.models[m], percent(root_mean_square(errors)), percent(worst(errors)),
                 split.cases[static_cast<std::size_t>(at)]});
    }
  }
  TextTable ridges({"ridge", "train rms %", "validate rms %", "iterations"}, "rrrr");
  for (const RidgeResult& result : outcome.ridges)
    ridges.add({short_number(result.ridge), percent(result.train_rms), percent(result.validate_rms),
                std::to_string(result.lbfgs.iterations)});
  return "Relative L2 error of the displacement against quadratic elements\n" + table.text() + '\n' +
         ridges.text() + verdict(outcome);
}

}  // namespace palpate::experiments
