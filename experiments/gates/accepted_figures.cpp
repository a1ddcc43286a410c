#include "experiments/gates/accepted_figures.h"

#include <algorithm>
#include <array>
#include <set>
#include <tuple>

#include "core/base/error.h"
#include "experiments/judging/measure.h"
#include "experiments/text/nearest_name.h"
#include "reference/door/json_file.h"

namespace palpate::experiments {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kLargestAccepted = 64U << 20U;
constexpr const char* kNoTimes =
    "a time by itself says as much of the machine and its load as of the code; accept the kind time_ratio, "
    "one "
    "case's time over another's in the same run";
constexpr std::array kStabilityMeasures{"measured_over_predicted", "row_sum_over_measured",
                                        "stability_margin",        "measured_step_s",
                                        "predicted_step_s",        "stable_step_s"};

/// One figure of the file, and where it stands.
struct Entry {
  const ordered_json& value;
  std::string where;

  [[noreturn]] void fail(const std::string& message) const { throw InputError(where + ": " + message); }

  std::string text(const char* key) const {
    const ordered_json& found = value.at(key);
    if (!found.is_string() || found.get<std::string>().empty())
      throw InputError(where + ": " + key, 0, "text", found.dump());
    return found.get<std::string>();
  }

  double number(const char* key, double least, const char* expected) const {
    const ordered_json& found = value.at(key);
    if (!found.is_number() || found.get<double>() < least)
      throw InputError(where + ": " + key, 0, expected, found.dump());
    return found.get<double>();
  }

  std::optional<double> number_or_null(const char* key) const {
    const ordered_json& found = value.at(key);
    if (!found.is_number() && !found.is_null())
      throw InputError(where + ": " + key, 0, "a number", found.dump());
    return found.is_null() ? std::nullopt : std::optional<double>(found.get<double>());
  }

  std::string text_or_null(const char* key) const { return value.at(key).is_null() ? "" : text(key); }
};

/// Refuses keys beside `needed` and `optional`, and missing ones.
void check_keys(const Entry& entry, const std::vector<std::string>& needed,
                const std::vector<std::string>& optional = {}) {
  std::vector<std::string> known = needed;
  known.insert(known.end(), optional.begin(), optional.end());
  for (const auto& [key, value] : entry.value.items()) {
    if (std::find(known.begin(), known.end(), key) == known.end())
      entry.fail("unknown key \"" + key + "\"" + nearest_hint(key, known));
  }
  for (const std::string& key : needed) {
    if (!entry.value.contains(key)) entry.fail("the key \"" + key + "\" is missing");
  }
}

const Measure& measure_of(const Entry& entry) {
  const std::string name = entry.text("measure");
  const Measure* measure = find_measure(name);
  if (measure == nullptr || !measure->scalar)
    entry.fail("unknown measure \"" + name + "\"" + nearest_hint(name, measure_names()));
  return *measure;
}

void read_unit(const Entry& entry, const Measure& measure, AcceptedFigure& figure) {
  figure.unit = entry.text("unit");
  if (figure.unit != measure.unit)
    throw InputError(entry.where + ": unit of " + figure.measure, 0, std::string("\"") + measure.unit + "\"",
                     "\"" + figure.unit + "\"");
}

void read_case_and_measure(const Entry& entry, AcceptedFigure& figure) {
  const Measure& measure = measure_of(entry);
  figure.run_case = entry.text("case");
  figure.measure = measure.name;
  read_unit(entry, measure, figure);
}

void refuse_times(const Entry& entry, const AcceptedFigure& figure) {
  if (is_clock_time(*find_measure(figure.measure))) entry.fail(figure.measure + ": " + kNoTimes);
}

AcceptedFigure read_accuracy(const Entry& entry) {
  check_keys(entry, {"case", "measure", "value", "lower", "upper", "unit"}, {"kind"});
  AcceptedFigure figure;
  read_case_and_measure(entry, figure);
  figure.lower = entry.number("lower", 0.0, "a tolerance of at least 0");
  figure.upper = entry.number("upper", 0.0, "a tolerance of at least 0");
  figure.value = entry.number_or_null("value");
  return figure;
}

AcceptedFigure read_validity(const Entry& entry) {
  AcceptedFigure figure;
  if (entry.value.contains("outcome")) {
    check_keys(entry, {"kind", "case", "outcome"});
    figure.run_case = entry.text("case");
    figure.word = entry.text_or_null("outcome");
    return figure;
  }
  check_keys(entry, {"kind", "case", "measure", "value", "unit"});
  read_case_and_measure(entry, figure);
  figure.value = entry.number_or_null("value");
  return figure;
}

AcceptedFigure read_stability(const Entry& entry) {
  check_keys(entry, {"kind", "case", "measure", "value", "lower", "unit"}, {"at_least"});
  AcceptedFigure figure;
  read_case_and_measure(entry, figure);
  if (!is_stability_measure(figure.measure)) {
    const std::vector<std::string> known(kStabilityMeasures.begin(), kStabilityMeasures.end());
    entry.fail("no measure of stability: \"" + figure.measure + "\"" + nearest_hint(figure.measure, known));
  }
  figure.lower = entry.number("lower", 0.0, "a tolerance of at least 0");
  figure.value = entry.number_or_null("value");
  if (entry.value.contains("at_least"))
    figure.at_least = entry.number("at_least", 0.0, "a number of at least 0");
  return figure;
}

AcceptedFigure read_hash(const Entry& entry) {
  check_keys(entry, {"kind", "case", "value"});
  AcceptedFigure figure;
  figure.run_case = entry.text("case");
  figure.word = entry.text_or_null("value");
  return figure;
}

/// The two cases that a figure holds against each other.
void read_cases(const Entry& entry, const char* first, const char* second, AcceptedFigure& figure) {
  figure.run_case = entry.text(first);
  figure.other_case = entry.text(second);
  if (figure.run_case == figure.other_case)
    throw InputError(entry.where + ": " + second, 0, "another case than " + std::string(first),
                     figure.other_case);
}

AcceptedFigure read_comparison(const Entry& entry) {
  check_keys(entry, {"kind", "less", "than", "measure"}, {"by_factor", "value"});
  AcceptedFigure figure;
  read_cases(entry, "less", "than", figure);
  figure.measure = measure_of(entry).name;
  if (entry.value.contains("by_factor"))
    figure.by_factor = entry.number("by_factor", 1.0, "a factor of at least 1");
  if (entry.value.contains("value")) figure.value = entry.number_or_null("value");
  return figure;
}

AcceptedFigure read_time_ratio(const Entry& entry) {
  check_keys(entry, {"kind", "case", "over", "measure", "value", "lower", "upper"});
  AcceptedFigure figure;
  read_cases(entry, "case", "over", figure);
  const Measure& measure = measure_of(entry);
  if (!is_clock_time(measure)) entry.fail(std::string(measure.name) + " is no time of a clock");
  figure.measure = measure.name;
  figure.lower = entry.number("lower", 1.0, "a factor of at least 1");
  figure.upper = entry.number("upper", 1.0, "a factor of at least 1");
  figure.value = entry.number_or_null("value");
  return figure;
}

AcceptedFigure read_kind(const Entry& entry, FigureKind kind) {
  switch (kind) {
    case FigureKind::kAccuracy:
      return read_accuracy(entry);
    case FigureKind::kValidity:
      return read_validity(entry);
    case FigureKind::kStability:
      return read_stability(entry);
    case FigureKind::kHash:
      return read_hash(entry);
    case FigureKind::kComparison:
      return read_comparison(entry);
    case FigureKind::kTimeRatio:
      return read_time_ratio(entry);
  }
  throw ContractError("read_kind: unknown kind");
}

AcceptedFigure read_figure(const Entry& entry, bool has_kinds) {
  if (!entry.value.is_object()) throw InputError(entry.where, 0, "an object", entry.value.dump());
  if (!has_kinds) {
    if (entry.value.contains("kind")) entry.fail("kinds belong to palpate/accepted/2");
    return read_accuracy(entry);
  }
  if (!entry.value.contains("kind")) entry.fail("the key \"kind\" is missing");
  const std::string name = entry.text("kind");
  const auto kind = kFigureKindNames.find(name);
  if (name == "time" || name == "times") entry.fail("no kind \"" + name + "\": " + kNoTimes);
  if (!kind) throw InputError(entry.where + ": kind", 0, kFigureKindNames.known(), "\"" + name + "\"");
  AcceptedFigure figure = read_kind(entry, *kind);
  figure.kind = *kind;
  const bool is_timeless = !figure.measure.empty() && *kind != FigureKind::kTimeRatio;
  if (is_timeless) refuse_times(entry, figure);
  return figure;
}

}  // namespace

bool is_stability_measure(const std::string& measure) {
  return std::find(kStabilityMeasures.begin(), kStabilityMeasures.end(), measure) != kStabilityMeasures.end();
}

std::string AcceptedFigure::name() const {
  const std::string what = !measure.empty() ? measure : kind == FigureKind::kHash ? "hash" : "outcome";
  if (other_case.empty()) return run_case + " " + what;
  return run_case + (kind == FigureKind::kComparison ? " < " : " / ") + other_case + " " + what;
}

AcceptedFile read_accepted(const std::filesystem::path& path, const std::string& plan) {
  const char* expected = "accepted figures (palpate/accepted/2 or 1)";
  if (!std::filesystem::exists(path)) throw InputError(path.string(), 0, expected, "no such file");
  const std::string text = reference::read_text_file(path, kLargestAccepted);
  AcceptedFile file;
  file.data = reference::parse_ordered_json(text, path.string());
  const ordered_json schema =
      file.data.is_object() ? file.data.value("schema", ordered_json()) : ordered_json();
  const bool has_kinds = schema == "palpate/accepted/2";
  if (!has_kinds && schema != "palpate/accepted/1")
    throw InputError(path.string(), 0, expected, "something else");
  for (const auto& [key, value] : file.data.items()) {
    static const std::vector<std::string> known{"schema", "plan", "figures"};
    if (std::find(known.begin(), known.end(), key) == known.end())
      throw InputError(path.string() + ": unknown key \"" + key + "\"" + nearest_hint(key, known));
  }
  if (file.data.value("plan", ordered_json()) != plan)
    throw InputError(path.string(), 0, "figures of the plan " + plan,
                     file.data.value("plan", ordered_json()).dump());
  if (!file.data.value("figures", ordered_json()).is_array())
    throw InputError(path.string(), 0, "a list \"figures\"", "none");
  std::set<std::tuple<FigureKind, std::string, std::string, std::string>> seen;
  std::size_t number = 0;
  for (const ordered_json& value : file.data.at("figures")) {
    const Entry entry{value, path.string() + ": figure " + std::to_string(++number)};
    AcceptedFigure figure = read_figure(entry, has_kinds);
    if (!seen.insert({figure.kind, figure.run_case, figure.other_case, figure.measure}).second)
      entry.fail("twice");
    file.figures.push_back(std::move(figure));
  }
  return file;
}

}  // namespace palpate::experiments
