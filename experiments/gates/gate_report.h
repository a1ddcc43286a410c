// What a gate says: to people on a terminal, to a CI that reads JUnit, to its page of the job.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "experiments/gates/accept.h"
#include "experiments/gates/gate.h"

namespace palpate::experiments {

/// What fell short, farthest first, then one line that counts what holds; with `all` a table of that too.
std::string gate_text(const GateResult& result, bool all);

/// The whole outcome; `changes` are those of --update.
nlohmann::json describe_gate(const GateResult& result, const std::vector<AcceptedChange>& changes);

/// JUnit XML: a test case for each figure and each problem of the run. Well-formed whatever names and
/// messages hold: characters that XML has no place for become '?'.
std::string gate_junit(const GateResult& result);

/// A summary in Markdown as the pages of hosted CI show it; `changes` are those of --update.
std::string gate_markdown(const GateResult& result, const std::vector<AcceptedChange>& changes);

}  // namespace palpate::experiments
