#include "experiments/gates/gate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "experiments/judging/measure.h"
#include "experiments/records/record_file.h"

namespace palpate::experiments {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

/// Whether the figure is an error against a reference that is not good enough to tell it.
bool is_marked(const RunRow& row, const Measure& measure) {
  return row.has_coarse_reference && std::string_view(measure.name).starts_with("displacement_");
}

/// Figures of a measure in all repeats of a case after warm-up, or why there are none.
struct Figures {
  std::vector<double> values;
  std::string problem;
};

Figures figures_of(const RunRows& rows, const std::string& run_case, const Measure& measure,
                   bool with_searches = true) {
  Figures figures;
  for (const RunRow* row : rows.of_case(run_case)) {
    if (row->is_warmup || (row->has_searched && !with_searches)) continue;
    if (*row->outcome != "accepted") return {{}, "a repeat is " + *row->outcome};
    if (is_marked(*row, measure)) return {{}, "marked: its reference is not five times better"};
    const auto figure = rows.figure(*row, measure);
    if (!figure) return {{}, "a repeat has no figure"};
    figures.values.push_back(*figure);
  }
  if (figures.values.empty()) figures.problem = "the run has no such case";
  return figures;
}

/// The line fails: the figure lies `outside` beyond a bound, where `tolerance` is allowed.
void fail_outside(GateLine& line, const std::string& problem, double outside, double tolerance) {
  line.problem = problem;
  const double size = std::fabs(line.figure.value.value_or(0.0));
  line.shortfall = outside / std::max(size, tolerance);
  line.by = short_number(outside);
  if (!line.figure.unit.empty() && line.figure.unit != "1") line.by += " " + line.figure.unit;
  if (size > 0.0) line.by += " (" + short_number(std::round(1e4 * outside / size) / 100.0) + "%)";
  if (tolerance > 0.0)
    line.by += ", " + short_number(std::round(100.0 * outside / tolerance) / 100.0) + " times the tolerance";
}

void fail_without_figure(GateLine& line, std::string problem) {
  line.problem = std::move(problem);
  line.shortfall = kInfinite;
}

/// Whether the line has a figure and something to hold it against; it fails otherwise.
bool is_comparable(GateLine& line) {
  if (line.problem.empty() && !line.figure.value) fail_without_figure(line, "no accepted value yet");
  return line.problem.empty();
}

void hold_bounds(GateLine& line) {
  const AcceptedFigure& figure = line.figure;
  if (!is_comparable(line)) return;
  const double below = *figure.value - figure.lower - *line.measured;
  const double above = *line.measured - (*figure.value + figure.upper);
  if (*line.measured < *figure.value - figure.lower) {
    fail_outside(line, "below the lower bound", below, figure.lower);
  } else if (*line.measured > *figure.value + figure.upper) {
    fail_outside(line, "above the upper bound", above, figure.upper);
  }
}

void hold_validity(GateLine& line, const std::vector<double>& values) {
  if (std::adjacent_find(values.begin(), values.end(), std::not_equal_to<>()) != values.end()) {
    line.measured.reset();
    return fail_without_figure(line, "its repeats differ");
  }
  if (!is_comparable(line) || *line.measured == *line.figure.value) return;
  fail_outside(line, "not the accepted value", std::fabs(*line.measured - *line.figure.value), 0.0);
}

void hold_stability(GateLine& line) {
  const AcceptedFigure& figure = line.figure;
  if (!is_comparable(line)) return;
  if (figure.at_least && *line.measured < *figure.at_least) {
    fail_outside(line, "below the least margin of " + short_number(*figure.at_least),
                 *figure.at_least - *line.measured, figure.lower);
  } else if (*line.measured < *figure.value - figure.lower) {
    fail_outside(line, "below the lower bound", *figure.value - figure.lower - *line.measured, figure.lower);
  }
}

/// A number of each repeat: accuracy, validity, stability.
void hold_number(GateLine& line, const RunRows& rows) {
  Figures figures = figures_of(rows, line.figure.run_case, *find_measure(line.figure.measure));
  if (!figures.problem.empty()) return fail_without_figure(line, figures.problem);
  line.measured = median(figures.values);
  if (line.figure.kind == FigureKind::kValidity) {
    hold_validity(line, figures.values);
  } else if (line.figure.kind == FigureKind::kStability) {
    hold_stability(line);
  } else {
    hold_bounds(line);
  }
}

/// An outcome, or the hash of the output: a word that all repeats have in common.
void hold_word(GateLine& line, const RunRows& rows) {
  const bool is_hash = line.figure.kind == FigureKind::kHash;
  std::set<std::string> words;
  for (const RunRow* row : rows.of_case(line.figure.run_case)) {
    if (row->is_warmup && !is_hash) continue;
    const std::string* word = is_hash ? row->output_hash : row->outcome;
    if (word == nullptr) return fail_without_figure(line, "a repeat left no output");
    words.insert(*word);
  }
  if (words.empty()) return fail_without_figure(line, "the run has no such case");
  if (words.size() > 1) {
    const std::string many = std::to_string(words.size());
    return fail_without_figure(line,
                               is_hash ? "its repeats gave " + many + " different outputs: not deterministic"
                                       : "its repeats ended in " + many + " different ways");
  }
  line.measured_word = *words.begin();
  if (line.figure.word.empty()) return fail_without_figure(line, "no accepted value yet");
  if (line.measured_word != line.figure.word)
    fail_without_figure(line, is_hash ? "another output" : "another outcome");
}

/// The medians of both cases of a line, by `read` of a case; nothing where one has no figures, which the line
/// then says.
template <typename Read>
std::optional<std::pair<double, double>> medians_of_both(GateLine& line, const Read& read) {
  std::pair<double, double> both;
  for (const auto& [run_case, into] :
       {std::pair(&line.figure.run_case, &both.first), std::pair(&line.figure.other_case, &both.second)}) {
    const Figures found = read(*run_case);
    if (!found.problem.empty()) {
      fail_without_figure(line, *run_case + ": " + found.problem);
      return std::nullopt;
    }
    *into = median(found.values);
  }
  return both;
}

void hold_comparison(GateLine& line, const RunRows& rows) {
  const AcceptedFigure& figure = line.figure;
  const Measure& measure = *find_measure(figure.measure);
  const auto both =
      medians_of_both(line, [&](const std::string& run_case) { return figures_of(rows, run_case, measure); });
  if (!both) return;
  const auto [left, right] = *both;
  if (figure.by_factor != 1.0 && (left < 0.0 || right < 0.0))
    return fail_without_figure(line, "a factor between figures that are not all positive");
  if (left != 0.0 && std::isfinite(right / left)) line.measured = right / left;
  const double bound = right / figure.by_factor;
  if (left < bound) return;
  line.problem = short_number(left) + " is not less than " + short_number(right) +
                 (figure.by_factor == 1.0 ? "" : " / " + short_number(figure.by_factor));
  line.shortfall = (left - bound) / std::fabs(bound);
  if (!std::isfinite(line.shortfall)) line.shortfall = left == bound ? 0.0 : kInfinite;
  line.by = short_number(left - bound);
  if (bound != 0.0)
    line.by += " (" + short_number(std::round(1e4 * (left - bound) / std::fabs(bound)) / 100.0) + "%)";
}

/// The times of a case that may be compared: of a process, those of repeats without a search.
Figures times_of(const RunRows& rows, const std::string& run_case, const Measure& measure) {
  const std::string_view name = measure.name;
  const bool of_process = name == "wall_s" || name == "user_s";
  Figures figures = figures_of(rows, run_case, measure, !of_process);
  if (figures.problem.empty() && figures.values.size() < kLeastTimeRepeats)
    figures.problem = std::to_string(figures.values.size()) + " repeats, a ratio of times needs at least " +
                      std::to_string(kLeastTimeRepeats);
  return figures;
}

void hold_time_ratio(GateLine& line, const RunRows& rows) {
  const AcceptedFigure& figure = line.figure;
  const Measure& measure = *find_measure(figure.measure);
  const auto both =
      medians_of_both(line, [&](const std::string& run_case) { return times_of(rows, run_case, measure); });
  if (!both) return;
  const auto [own, divisor] = *both;
  if (divisor <= 0.0) return fail_without_figure(line, figure.other_case + ": its time is not above zero");
  line.measured = own / divisor;
  if (!is_comparable(line)) return;
  const double low = *figure.value / figure.lower;
  const double high = *figure.value * figure.upper;
  if (*line.measured < low) {
    fail_outside(line, "below the lower bound", low - *line.measured, *figure.value - low);
  } else if (*line.measured > high) {
    fail_outside(line, "above the upper bound", *line.measured - high, high - *figure.value);
  }
}

}  // namespace

bool GateResult::holds() const {
  return problems.empty() &&
         std::all_of(lines.begin(), lines.end(), [](const GateLine& line) { return line.problem.empty(); });
}

std::vector<const GateLine*> GateResult::failures() const {
  std::vector<const GateLine*> failing;
  for (const GateLine& line : lines) {
    if (!line.problem.empty()) failing.push_back(&line);
  }
  std::stable_sort(failing.begin(), failing.end(),
                   [](const GateLine* a, const GateLine* b) { return a->shortfall > b->shortfall; });
  return failing;
}

std::vector<const Measure*> measures_of(const AcceptedFile& accepted) {
  std::vector<const Measure*> measures;
  for (const AcceptedFigure& figure : accepted.figures) {
    const Measure* measure = find_measure(figure.measure);
    if (measure != nullptr && std::find(measures.begin(), measures.end(), measure) == measures.end())
      measures.push_back(measure);
  }
  return measures;
}

GateLine hold_figure(const AcceptedFigure& figure, const RunRows& rows) {
  GateLine line;
  line.figure = figure;
  if (figure.kind == FigureKind::kComparison) {
    hold_comparison(line, rows);
  } else if (figure.kind == FigureKind::kTimeRatio) {
    hold_time_ratio(line, rows);
  } else if (figure.is_word()) {
    hold_word(line, rows);
  } else {
    hold_number(line, rows);
  }
  return line;
}

GateResult hold_against(const RunRows& rows, const std::string& plan,
                        const std::filesystem::path& accepted_file) {
  const AcceptedFile accepted = read_accepted(accepted_file, plan);
  GateResult result;
  result.plan = plan;
  bool compared = false;
  for (const AcceptedFigure& figure : accepted.figures) {
    result.lines.push_back(hold_figure(figure, rows));
    const GateLine& line = result.lines.back();
    compared = compared || line.problem.empty() || std::isfinite(line.shortfall) || line.measured ||
               !line.measured_word.empty();
  }
  if (accepted.figures.empty()) {
    result.problems.push_back("nothing to compare: " + accepted_file.string() + " holds no figures");
  } else if (!compared) {
    result.problems.push_back("nothing to compare: the run has none of the " +
                              std::to_string(accepted.figures.size()) + " accepted figures");
  }
  return result;
}

}  // namespace palpate::experiments
