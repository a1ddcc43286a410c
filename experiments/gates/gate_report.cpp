#include "experiments/gates/gate_report.h"

#include <algorithm>
#include <string_view>

#include "core/base/number_text.h"
#include "experiments/text/terminal.h"
#include "reference/door/json_file.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

constexpr std::size_t kShownProblems = 50;  // of a run, on a terminal and in a summary

std::string number_text(const std::optional<double>& value) {
  return value ? short_number(*value) : "none";
}

std::string accepted_text(const AcceptedFigure& figure) {
  if (figure.is_word()) return figure.word.empty() ? "none" : figure.word;
  if (figure.kind == FigureKind::kComparison)
    return figure.by_factor == 1.0 ? "less" : "less by " + short_number(figure.by_factor) + " times";
  return number_text(figure.value);
}

std::string measured_text(const GateLine& line) {
  const bool is_comparison = line.figure.kind == FigureKind::kComparison;
  if (line.figure.is_word()) return line.measured_word.empty() ? "none" : line.measured_word;
  return number_text(line.measured) + (is_comparison && line.measured ? " times" : "");
}

std::string tolerance_text(const AcceptedFigure& figure) {
  switch (figure.kind) {
    case FigureKind::kAccuracy:
      return "-" + short_number(figure.lower) + " +" + short_number(figure.upper);
    case FigureKind::kStability:
      return "-" + short_number(figure.lower) +
             (figure.at_least ? ", at least " + short_number(*figure.at_least) : "");
    case FigureKind::kTimeRatio:
      return "/" + short_number(figure.lower) + " x" + short_number(figure.upper);
    case FigureKind::kValidity:
    case FigureKind::kHash:
    case FigureKind::kComparison:
      break;
  }
  return "exact";
}

std::string unit_text(const AcceptedFigure& figure) {
  return figure.unit == "1" ? "" : figure.unit;
}

/// "short: above the upper bound by 3 s (2%), 1.5 tolerances"
std::string reason_text(const GateLine& line) {
  return line.problem + (line.by.empty() ? "" : " by " + line.by);
}

/// "41 of 43 figures hold: 30 of 32 of accuracy, 11 of validity"
std::string count_text(const GateResult& result) {
  std::string kinds;
  std::size_t holding = 0;
  for (std::size_t at = 0; at < kFigureKindNames.names.size(); ++at) {
    std::size_t all = 0;
    std::size_t good = 0;
    for (const GateLine& line : result.lines) {
      if (static_cast<std::size_t>(line.figure.kind) != at) continue;
      ++all;
      good += line.problem.empty() ? 1 : 0;
    }
    if (all == 0) continue;
    holding += good;
    kinds += (kinds.empty() ? ": " : ", ") + std::to_string(good) +
             (good == all ? "" : " of " + std::to_string(all)) + " of " + kFigureKindNames.names[at];
  }
  return std::to_string(holding) + " of " + std::to_string(result.lines.size()) + " figures hold" + kinds;
}

/// What the gate says as a whole, with where it comes from.
std::string verdict_text(const GateResult& result) {
  return std::string(result.holds() ? "holds" : "fails") + (result.plan.empty() ? "" : ": " + result.plan);
}

bool is_control(unsigned char byte) {
  return byte < 0x20 && byte != '\t' && byte != '\n' && byte != '\r';
}

/// Text that is valid UTF-8, without characters that XML cannot hold (C0, U+FFFE, U+FFFF).
std::string xml_characters(const std::string& text) {
  const std::string valid =
      json::parse(json(text).dump(-1, ' ', false, json::error_handler_t::replace)).get<std::string>();
  std::string kept;
  for (std::size_t i = 0; i < valid.size(); ++i) {
    const bool is_no_character =
        valid.compare(i, 3, "\xEF\xBF\xBE") == 0 || valid.compare(i, 3, "\xEF\xBF\xBF") == 0;
    kept += is_no_character || is_control(static_cast<unsigned char>(valid[i])) ? '?' : valid[i];
    if (is_no_character) i += 2;
  }
  return kept;
}

/// An attribute's value in quotes, or an element's text.
std::string escape_xml(const std::string& text) {
  std::string escaped;
  for (const char c : xml_characters(text)) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '>':
        escaped += "&gt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      case '\t':
      case '\n':
      case '\r':
        escaped += "&#" + std::to_string(static_cast<int>(c)) + ";";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

std::string test_case(const std::string& group, const std::string& name, const std::string& failure,
                      const std::string& details) {
  std::string text =
      "    <testcase classname=\"" + escape_xml(group) + "\" name=\"" + escape_xml(name) + "\" time=\"0\"";
  if (failure.empty()) return text + "/>\n";
  return text + ">\n      <failure message=\"" + escape_xml(failure) + "\">" + escape_xml(details) +
         "</failure>\n    </testcase>\n";
}

std::string details_of(const GateLine& line) {
  const std::string unit = unit_text(line.figure);
  return "accepted " + accepted_text(line.figure) + ", measured " + measured_text(line) + ", tolerance " +
         tolerance_text(line.figure) + (unit.empty() ? "" : ", in " + unit);
}

/// Text in a cell of a table, as it is.
std::string markdown_cell(const std::string& text) {
  std::string escaped;
  for (const char c : xml_characters(text)) {
    const bool breaks = c == '\n' || c == '\r' || c == '\t';
    if (std::string_view("\\`*_{}[]<>#|~&").find(c) != std::string_view::npos) escaped += '\\';
    escaped += breaks ? ' ' : c;
  }
  return escaped;
}

std::string markdown_row(const std::vector<std::string>& cells) {
  std::string row = "|";
  for (const std::string& cell : cells) row += " " + markdown_cell(cell) + " |";
  return row + "\n";
}

std::string problems_markdown(const GateResult& result) {
  std::string text;
  for (std::size_t i = 0; i < std::min(result.problems.size(), kShownProblems); ++i)
    text += "- **the run:** " + markdown_cell(result.problems[i]) + "\n";
  if (result.problems.size() > kShownProblems)
    text +=
        "- and " + std::to_string(result.problems.size() - kShownProblems) + " more problems of the run\n";
  return text.empty() ? "" : text + "\n";
}

}  // namespace

std::string gate_text(const GateResult& result, bool all) {
  std::string text;
  for (std::size_t i = 0; i < std::min(result.problems.size(), kShownProblems); ++i)
    text += colored("FAILS", Color::kRed) + ": " + result.problems[i] + '\n';
  if (result.problems.size() > kShownProblems)
    text += "and " + std::to_string(result.problems.size() - kShownProblems) + " more problems of the run\n";
  const std::vector<const GateLine*> failing = result.failures();
  TextTable table({"kind", "figure", "accepted", "measured", "tolerance", "unit", ""}, "llrrrll");
  const auto add = [&](const GateLine& line) {
    const bool holds = line.problem.empty();
    table.add(
        {kFigureKindNames.of(line.figure.kind), line.figure.name(), accepted_text(line.figure),
         measured_text(line), tolerance_text(line.figure), unit_text(line.figure),
         holds ? colored("holds", Color::kGreen) : colored("FAILS", Color::kRed) + ": " + reason_text(line)});
  };
  for (const GateLine* line : failing) add(*line);
  for (const GateLine& line : result.lines) {
    if (all && line.problem.empty()) add(line);
  }
  if (!failing.empty() || (all && !result.lines.empty())) text += table.text();
  const bool is_good = result.holds();
  return text + (is_good ? colored("holds", Color::kGreen) : colored("FAILS", Color::kRed)) + ": " +
         count_text(result) + '\n';
}

json describe_gate(const GateResult& result, const std::vector<AcceptedChange>& changes) {
  const auto or_null = [](const std::optional<double>& value) { return value ? json(*value) : json(); };
  json lines = json::array();
  for (const GateLine& line : result.lines) {
    const AcceptedFigure& figure = line.figure;
    json entry = {{"kind", kFigureKindNames.of(figure.kind)},
                  {"case", figure.run_case},
                  {"measure", figure.measure},
                  {"unit", figure.unit},
                  {"accepted", figure.is_word() ? json(figure.word) : or_null(figure.value)},
                  {"measured", figure.is_word() ? json(line.measured_word) : or_null(line.measured)},
                  {"lower", figure.lower},
                  {"upper", figure.upper},
                  {"holds", line.problem.empty()},
                  {"problem", line.problem},
                  {"by", line.by},
                  {"shortfall", reference::number_or_null(line.shortfall)}};
    if (!figure.other_case.empty()) entry["other_case"] = figure.other_case;
    if (figure.kind == FigureKind::kComparison) entry["by_factor"] = figure.by_factor;
    if (figure.at_least) entry["at_least"] = *figure.at_least;
    lines.push_back(std::move(entry));
  }
  json changed = json::array();
  for (const AcceptedChange& change : changes)
    changed.push_back(
        {{"figure", change.name}, {"from", change.from}, {"to", change.to}, {"share", change.share}});
  return {{"holds", result.holds()},     {"plan", result.plan},         {"run", result.run},
          {"problems", result.problems}, {"figures", std::move(lines)}, {"changes", std::move(changed)}};
}

std::string gate_junit(const GateResult& result) {
  const std::string plan = result.plan.empty() ? "run" : result.plan;
  const std::size_t failures = result.failures().size() + result.problems.size();
  const std::string counts = " tests=\"" + std::to_string(result.lines.size() + result.problems.size()) +
                             "\" failures=\"" + std::to_string(failures) +
                             "\" errors=\"0\" skipped=\"0\" time=\"0\"";
  std::string text =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"palpate gate\"" + counts + ">\n";
  text += "  <testsuite name=\"" + escape_xml(plan) + "\"" + counts + ">\n";
  for (const std::string& problem : result.problems)
    text += test_case(plan + ".run", problem, problem, problem);
  for (const GateLine& line : result.lines)
    text += test_case(plan + "." + kFigureKindNames.of(line.figure.kind), line.figure.name(),
                      line.problem.empty() ? "" : reason_text(line), details_of(line));
  return text + "  </testsuite>\n</testsuites>\n";
}

std::string gate_markdown(const GateResult& result, const std::vector<AcceptedChange>& changes) {
  std::string text =
      "## palpate gate " + markdown_cell(verdict_text(result)) + "\n\n" + problems_markdown(result);
  const std::vector<const GateLine*> failing = result.failures();
  if (!failing.empty()) {
    text +=
        "| what fell short | kind | accepted | measured | tolerance | unit | why "
        "|\n|---|---|--:|--:|--:|---|---|\n";
    for (const GateLine* line : failing)
      text += markdown_row({line->figure.name(), kFigureKindNames.of(line->figure.kind),
                            accepted_text(line->figure), measured_text(*line), tolerance_text(line->figure),
                            unit_text(line->figure), reason_text(*line)});
    text += "\n";
  }
  text += count_text(result) + ".\n";
  if (!result.run.empty()) text += "\nRun: " + markdown_cell(result.run) + "\n";
  if (changes.empty()) return text;
  text += "\n| newly accepted | before | now | change |\n|---|--:|--:|--:|\n";
  for (const AcceptedChange& change : changes)
    text += markdown_row({change.name, change.from, change.to, change.share});
  return text;
}

}  // namespace palpate::experiments
