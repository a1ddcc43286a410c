// The figures that a record holds: their names, units and directions.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace palpate::experiments {

/// One figure of a record.
struct Measure {
  const char* name;
  const char* unit;     ///< "s", "bytes", "%", "deg", "1" for a plain number
  const char* better;   ///< "higher", "lower" or "" where neither is better
  const char* key;      ///< JSON pointer into a record
  const char* summary;  ///< one line
  bool scalar = true;   ///< false: a list, which bounds and gates cannot use
};

/// All measures, in the order in which people want to read them.
std::span<const Measure> list_measures();

std::vector<std::string> measure_names();

/// The measure of that name, or nothing.
const Measure* find_measure(const std::string& name);

/// Whether a figure comes from a clock or the system, and is another one in every run: times, memory, ticks.
bool is_measured_anew(const Measure& measure);

/// Whether it is a time of a clock, or made of nothing but such.
bool is_clock_time(const Measure& measure);

/// The figure in a record; nothing if it is absent, null or no number. true counts 1, false 0.
std::optional<double> figure_of(const nlohmann::json& record, const Measure& measure);

}  // namespace palpate::experiments
