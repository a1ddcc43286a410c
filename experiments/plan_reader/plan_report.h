// What a plan asks of its report: measures, bounds, charts, tags, repeats enough for its times.
#pragma once

#include <string>
#include <vector>

#include "experiments/judging/measure.h"
#include "experiments/plan_reader/plan.h"
#include "experiments/text/yaml_value.h"

namespace palpate::experiments {

/// The measure of that name. Throws: InputError at `at` for an unknown one (with the nearest), or for a list
/// where `scalar` asks for a number.
const Measure& known_measure(const YamlValue& at, const std::string& name, bool scalar);

/// Reads a bound on a measure, {min: ..., max: ...}. Throws: InputError with file and line.
AcceptBound read_bound(const std::string& measure, const YamlValue& value);

/// The label of one of the contestants. Throws: InputError for an unknown one (with the nearest).
std::string known_label(const YamlValue& value, const std::vector<PlanContestant>& contestants);

/// Appends a name. Throws: InputError if it is there already.
void add_once(const YamlValue& at, const char* what, std::string name, std::vector<std::string>& names);

/// The tags of a contestant, a mesh or a scene: the words below its key "tags"; none without that key.
/// Throws: InputError with file and line for one that is no identifier, or there twice.
std::vector<std::string> read_tags(const YamlFields& fields);

/// Whether a clock gives the measure, so that it differs from repeat to repeat.
bool is_clock_time(const std::string& measure);

/// Throws: InputError for a comparison of times that has too few repeats to end in anything but "open".
void require_repeats(const YamlValue& at, const RunSettings& run);

/// Checks the key `required` of a comparison, a target or a claim. Throws: InputError if it is neither true
/// nor false.
void check_required(const YamlFields& fields);

/// Whether a plan (that was read and is good) has a comparison, a target or a claim with `required: true`:
/// the report then decides the exit code.
bool requires_report(const std::filesystem::path& plan);

/// What is to be said of a plan whose measures hold times that have too few repeats or no warm-up; "" if it
/// has none.
std::string timing_note(const Plan& plan);

/// Reads the list of charts, of those that the contest knows. Throws: InputError with file and line for one
/// that is unknown (with the nearest), or there twice.
std::vector<std::string> read_charts(const YamlValue& value, const std::vector<std::string>& known);

}  // namespace palpate::experiments
