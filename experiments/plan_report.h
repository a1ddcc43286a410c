// What a plan asks of its report: claim, comparisons, charts.
#pragma once

#include <string>
#include <vector>

#include "experiments/measure.h"
#include "experiments/plan.h"
#include "experiments/yaml_value.h"

namespace palpate::experiments {

/// The measure of that name. Throws: InputError at `at` for an unknown one (with the nearest), or for a list
/// where `scalar` asks for a number.
const Measure& known_measure(const YamlValue& at, const std::string& name, bool scalar);

/// Reads a bound on a measure, {min: ..., max: ...}. Throws: InputError with file and line.
AcceptBound read_bound(const std::string& measure, const YamlValue& value);

/// Reads the claim. Throws: InputError with file and line.
Claim read_claim(const YamlValue& value, const std::vector<PlanContestant>& contestants);

/// Reads the list of comparisons. Throws: InputError with file and line, also where a label is compared with
/// itself, a measure has no better side, a time factor is given without a label to time against, or times are
/// compared in a plan with fewer than 9 repeats or without a warm-up.
std::vector<Comparison> read_comparisons(const YamlValue& value,
                                         const std::vector<PlanContestant>& contestants,
                                         const RunSettings& run);

/// Checks the key `required` of a comparison, a target or a claim. Throws: InputError if it is neither true
/// nor false.
void check_required(const YamlFields& fields);

/// Whether a plan (that was read and is good) has a comparison, a target or a claim with `required: true`:
/// the report then decides the exit code.
bool requires_report(const std::filesystem::path& plan);

/// What is to be said of a plan whose measures hold times that have too few repeats or no warm-up; "" if it
/// has none.
std::string timing_note(const Plan& plan);

/// Reads the list of charts. Throws: InputError with file and line for one that is unknown in this contest
/// (with the nearest).
std::vector<std::string> read_charts(const YamlValue& value, const std::string& contest);

}  // namespace palpate::experiments
