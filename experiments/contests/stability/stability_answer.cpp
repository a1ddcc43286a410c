#include "experiments/contests/stability/stability_answer.h"

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "reference/door/json_file.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

constexpr const char* kAnswerSchema = "palpate/stability_answer/1";
constexpr std::size_t kLargestAnswerFile = std::size_t{256} << 20U;
constexpr std::size_t kDepth = 16;
constexpr std::size_t kMostRuns = 16;
constexpr std::size_t kMostRows = 10'000;
constexpr std::size_t kColumns = 12;
constexpr double kMostRounding = 1e-6;  // single precision

[[noreturn]] void fail(const std::string& where, const std::string& expected, const json& found) {
  throw InputError(where, 0, expected, found.dump().substr(0, 80));
}

/// An object with these keys and no others.
const json& object(const json& value, const std::set<std::string>& keys, const std::string& where) {
  if (!value.is_object()) fail(where, "an object", value);
  for (const auto& [name, each] : value.items()) {
    if (keys.count(name) == 0) fail(where, "no key \"" + name + "\"", each);
  }
  for (const std::string& name : keys) {
    if (!value.contains(name)) fail(where, "the key \"" + name + "\"", "none");
  }
  return value;
}

const json& list(const json& value, std::size_t most, const std::string& where) {
  if (!value.is_array() || value.size() > most)
    fail(where, "a list of at most " + std::to_string(most), value);
  return value;
}

double number(const json& value, const std::string& where) {
  if (!value.is_number() || !std::isfinite(value.get<double>())) fail(where, "a finite number", value);
  return value.get<double>();
}

/// null is no number: NaN.
double number_or_none(const json& value, const std::string& where) {
  return value.is_null() ? std::numeric_limits<double>::quiet_NaN() : number(value, where);
}

std::uint64_t whole(const json& value, const std::string& where) {
  if (!value.is_number_integer() || value.get<std::int64_t>() < 0)
    fail(where, "a whole number from 0", value);
  return value.get<std::uint64_t>();
}

bool flag(const json& value, const std::string& where) {
  if (!value.is_boolean()) fail(where, "true or false", value);
  return value.get<bool>();
}

judge::HistoryRow read_row(const json& value, const std::string& where) {
  if (!value.is_array() || value.size() != kColumns)
    fail(where, std::to_string(kColumns) + " columns", value);
  judge::HistoryRow row;
  row.step = whole(value[0], where);
  double* const numbers[] = {&row.time_s,         &row.kinetic_j,    &row.elastic_j,     &row.load_j,
                             &row.most_kinetic_j, &row.most_total_j, &row.least_total_j, &row.farthest_m};
  std::size_t column = 1;
  for (double* each : numbers) *each = number_or_none(value[column++], where);
  row.inverted = whole(value[9], where);
  row.is_finite = flag(value[10], where);
  row.unsolved = whole(value[11], where);
  return row;
}

judge::RunHistory read_run_history(const json& value, const TetMesh& rest, const std::string& where) {
  object(value, {"step_s", "steps", "says_growing", "rows", "displacement_m"}, where);
  judge::RunHistory out;
  out.step_s = number(value.at("step_s"), where + ".step_s");
  out.steps = whole(value.at("steps"), where + ".steps");
  out.says_growing = flag(value.at("says_growing"), where + ".says_growing");
  for (const json& row : list(value.at("rows"), kMostRows, where + ".rows"))
    out.rows.push_back(read_row(row, where + ".rows[" + std::to_string(out.rows.size()) + "]"));
  const std::string place = where + ".displacement_m";
  for (const json& u : list(value.at("displacement_m"), rest.points.size(), place)) {
    if (!u.is_array() || u.size() != 3) fail(place, "three numbers a vertex", u);
    out.displacement_m.push_back(
        {number_or_none(u[0], place), number_or_none(u[1], place), number_or_none(u[2], place)});
  }
  judge::check_history(out, rest, where);
  return out;
}

judge::TrialHistory read_trial_history(const json& value, const std::string& where) {
  object(value, {"step_s", "linear", "start_j", "stretches"}, where);
  judge::TrialHistory out;
  out.step_s = number(value.at("step_s"), where + ".step_s");
  out.is_linear = flag(value.at("linear"), where + ".linear");
  out.start_j = number_or_none(value.at("start_j"), where + ".start_j");
  for (const json& stretch : list(value.at("stretches"), 64, where + ".stretches")) {
    if (!stretch.is_array() || stretch.size() != 3) fail(where + ".stretches", "three columns", stretch);
    out.stretches.push_back(
        {whole(stretch[0], where), number_or_none(stretch[1], where), number_or_none(stretch[2], where)});
  }
  return out;
}

BracketEnd read_end(const json& value, bool is_trial, const TetMesh& rest, const std::string& where) {
  BracketEnd end;
  if (is_trial) {
    end.trial = read_trial_history(value, where);
    end.step_s = end.trial->step_s;
  } else {
    end.run = read_run_history(value, rest, where);
    end.step_s = end.run->step_s;
  }
  if (!(end.step_s > 0.0)) fail(where + ".step_s", "a step above zero", end.step_s);
  return end;
}

}  // namespace

StabilityAnswer read_stability_answer(const std::filesystem::path& file, const TetMesh& rest) {
  const std::string where = file.string();
  const json value = reference::read_json_file(file, {kLargestAnswerFile, kDepth});
  object(value, {"schema", "rounding", "runs", "bracket"}, where);
  if (value.at("schema") != kAnswerSchema) fail(where + ": schema", kAnswerSchema, value.at("schema"));
  StabilityAnswer out;
  out.rounding = number(value.at("rounding"), where + ": rounding");
  if (!(out.rounding > 0.0) || !(out.rounding <= kMostRounding))
    fail(where + ": rounding", "a share above zero, at most 1e-6", value.at("rounding"));
  for (const json& run : list(value.at("runs"), kMostRuns, where + ": runs"))
    out.runs.push_back(
        read_run_history(run, rest, where + ": runs[" + std::to_string(out.runs.size()) + "]"));
  if (out.runs.empty()) fail(where + ": runs", "at least one run", value.at("runs"));
  const json& bracket = value.at("bracket");
  if (bracket.is_null()) return out;
  object(bracket, {"by", "lower", "upper"}, where + ": bracket");
  const json& by = bracket.at("by");
  if (by != "trials" && by != "step_map" && by != "runs")
    fail(where + ": bracket.by", "trials, step_map or runs", by);
  const bool is_trial = by == "trials";
  out.bracket = StabilityBracket{by.get<std::string>(),
                                 read_end(bracket.at("lower"), is_trial, rest, where + ": bracket.lower"),
                                 read_end(bracket.at("upper"), is_trial, rest, where + ": bracket.upper")};
  return out;
}

}  // namespace palpate::experiments
