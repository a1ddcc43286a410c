// How two motions of one problem are compared.
#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/judge/motion/motion_error.h"
#include "core/judge/motion/oscillation.h"
#include "experiments/contests/motion/motion_input.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;
constexpr std::size_t kFittedOscillations = 4;
using reference::MotionHistory;
using reference::MotionProblem;

/// The rows of a history with after < time <= until (from the start on if after is below zero).
struct Stretch {
  std::vector<double> time_s;
  std::vector<const std::vector<double>*> rows;

  Stretch(const MotionHistory& history, double after, double until) {
    for (const std::vector<double>& row : history.rows) {
      if (row[0] <= after || row[0] > until) continue;
      time_s.push_back(row[0]);
      rows.push_back(&row);
    }
  }

  std::vector<double> column(std::size_t at) const {
    std::vector<double> values;
    for (const std::vector<double>* row : rows) values.push_back((*row)[at]);
    return values;
  }
};

std::size_t place_of(const MotionHistory& history, const std::string& name) {
  const auto at = std::find(history.columns.begin(), history.columns.end(), name);
  require(at != history.columns.end(), "a column that the problem has");
  return static_cast<std::size_t>(at - history.columns.begin());
}

void compare_frequencies(const JudgedMotion& found, const JudgedMotion& truth, json& figures) {
  constexpr double kRigidShare = 1e-3;  // of the highest compared frequency
  if (found.frequencies_hz.size() != truth.frequencies_hz.size() || truth.frequencies_hz.empty()) return;
  const std::vector<double> errors = judge::frequency_errors(found.frequencies_hz, truth.frequencies_hz,
                                                             kRigidShare * truth.frequencies_hz.back());
  if (errors.empty()) return;
  double sum = 0.0;
  double worst = 0.0;
  for (const double error : errors) {
    sum += std::fabs(error);
    worst = std::max(worst, std::fabs(error));
  }
  figures["frequency_errors"] = errors;
  figures["frequency_first"] = std::fabs(errors.front());
  figures["frequency_mean"] = sum / static_cast<double>(errors.size());
  figures["frequency_worst"] = worst;
}

void compare_probes(const MotionProblem& problem, const JudgedMotion& found, const JudgedMotion& truth,
                    json& figures) {
  const Stretch at(truth.history, -1.0, problem.duration_s);
  const Stretch own(found.history, -1.0, 2.0 * problem.duration_s);
  std::vector<std::vector<double>> expected;
  std::vector<std::vector<double>> measured;
  const std::size_t first = place_of(truth.history, "probe_1_ux_m");
  for (std::size_t c = first; c < truth.history.columns.size(); ++c) {
    expected.push_back(at.column(c));
    measured.push_back(judge::sample_smooth(own.time_s, own.column(c), at.time_s));
  }
  if (const auto error = judge::history_error(at.time_s, measured, expected)) figures["probe_l2"] = *error;
}

/// While a tool is there: its rows begin after it has come, and end with it.
void compare_forces(const MotionProblem& problem, const JudgedMotion& found, const JudgedMotion& truth,
                    json& figures) {
  for (std::size_t k = 0; k < problem.loads.size(); ++k) {
    const reference::MotionLoad& load = problem.loads[k];
    if (!load.is_tool()) continue;
    const double after = load.from_s > 0.0 ? load.from_s * (1.0 + 1e-12) : -1.0;
    const double until =
        std::min(load.until_s.value_or(problem.duration_s), problem.duration_s) * (1.0 + 1e-9);
    const Stretch at(truth.history, after, until);
    const Stretch own(found.history, after, until);
    if (at.time_s.empty() || own.time_s.empty()) continue;
    const std::size_t first = place_of(truth.history, "tool_" + std::to_string(k + 1) + "_fx_n");
    std::vector<std::vector<double>> expected;
    std::vector<std::vector<double>> measured;
    for (std::size_t c = first; c < first + 3; ++c) {
      expected.push_back(at.column(c));
      measured.push_back(judge::sample_straight(own.time_s, own.column(c), at.time_s));
    }
    if (const auto error = judge::history_error(at.time_s, measured, expected))
      figures["force_l2"] = std::max(figures.value("force_l2", 0.0), *error);
  }
}

/// The first probe's displacement along `direction`.
std::vector<double> project(const Stretch& rows, std::size_t first, const Vec3& direction) {
  std::vector<double> values;
  for (const std::vector<double>* row : rows.rows)
    values.push_back(dot(direction, {(*row)[first], (*row)[first + 1], (*row)[first + 2]}));
  return values;
}

void compare_oscillation(const MotionProblem& problem, const JudgedMotion& found, const JudgedMotion& truth,
                         json& figures) {
  const auto [from, to] = judging_window(problem);
  const std::size_t first = place_of(truth.history, "probe_1_ux_m");
  const Stretch at(truth.history, from * (1.0 - 1e-12) - 1e-300, to * (1.0 + 1e-9));
  std::vector<Vec3> path;
  for (const std::vector<double>* row : at.rows)
    path.push_back({(*row)[first], (*row)[first + 1], (*row)[first + 2]});
  const auto direction = judge::main_direction(path);
  if (!direction) return;
  const judge::FitWindow window{from, to};
  const auto expected =
      judge::fit_oscillations(at.time_s, project(at, first, *direction), window, kFittedOscillations);
  if (!expected || !(expected->oscillations[0].amplitude > 0.0)) return;
  const judge::Oscillation& main = expected->oscillations[0];
  const Stretch own(found.history, from * (1.0 - 1e-12) - 1e-300, to * (1.0 + 1e-9));
  const auto measured =
      judge::fit_oscillations_like(own.time_s, project(own, first, *direction), window, *expected);
  figures["reference_oscillation"] = {{"frequency_hz", main.frequency_hz},
                                      {"amplitude_m", main.amplitude},
                                      {"decay_per_s", main.decay_per_s},
                                      {"unexplained", expected->unexplained}};
  if (!measured) return;
  figures["unexplained"] = measured->unexplained;
  // What is not the sum of a few oscillations has no amplitude, phase and decay that could be compared.
  if (judge::explains_too_little(*expected) || judge::explains_too_little(*measured)) return;
  const judge::OscillationError error = judge::compare_oscillations(measured->oscillations[0], main);
  figures["amplitude_error"] = error.amplitude;
  figures["phase_error_deg"] = error.phase_deg;
  figures["oscillation_error"] = error.frequency;
  figures["damping_ratio_error"] = error.damping_ratio;
  if (error.decay) figures["decay_error"] = *error.decay;
  figures["oscillation_hz"] = measured->oscillations[0].frequency_hz;
}

}  // namespace

json compare_motions(const MotionProblem& problem, const JudgedMotion& found, const JudgedMotion& truth) {
  json figures = json::object();
  compare_frequencies(found, truth, figures);
  compare_probes(problem, found, truth, figures);
  compare_forces(problem, found, truth, figures);
  compare_oscillation(problem, found, truth, figures);
  return figures;
}

}  // namespace palpate::experiments
