// Taking figures of a run as accepted.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "experiments/gates/gate.h"

namespace palpate::experiments {

/// One accepted value that changed.
struct AcceptedChange {
  std::string name;  ///< of the figure, with its unit
  std::string from;  ///< "none" where there was none
  std::string to;
  std::string share;  ///< "+1.5%"; empty where there is none to tell

  /// "kidney/a tets: 383 -> 384 (+0.26%)"
  std::string text() const;
};

/// Puts the measured values into the accepted file, tolerances kept. Figures without a measured value stay;
/// a comparison takes the ratio that it has, which decides nothing. The result is of this very file.
std::vector<AcceptedChange> update_accepted(const GateResult& result,
                                            const std::filesystem::path& accepted_file);

/// Kinds that a new file takes unless others are asked for: all that can be read off a run. Comparisons and
/// ratios of times are for their author to write.
std::vector<FigureKind> default_kinds();

/// The measures that propose_accepted looks for in the rows of a run with this provenance.
std::vector<const Measure*> measures_to_propose(const nlohmann::json& provenance);

/// Accepted figures (palpate/accepted/2) for a run that has none yet, without values (update_accepted puts
/// them in) and with tolerances of 0 for their author to widen. Of every accepted case and input, of the
/// measures that its plan names under `measure` and `accept`, without times and memory:
///
///   accuracy   each, but for those below
///   stability  those that are margins or steps
///   validity   those of validity, and each case's outcome if all its repeats have one
///   hash       where a case has at least two repeats, and all gave one output
///
/// Throws: InputError if the run has no such figure, or a kind is one that cannot be read off a run.
nlohmann::ordered_json propose_accepted(const std::filesystem::path& folder, const RunRows& rows,
                                        const std::string& plan, const std::vector<FigureKind>& kinds);

}  // namespace palpate::experiments
