// The gate: figures of a run held against accepted ones.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace palpate::experiments {

/// One accepted figure and what the run says to it.
struct GateLine {
  std::string run_case;
  std::string measure;
  std::string unit;
  std::optional<double> accepted;
  double lower = 0.0;              ///< the figure may be less by this much
  double upper = 0.0;              ///< and more by this much
  std::optional<double> measured;  ///< median over the repeats that count
  std::string problem;             ///< why it fails, empty if it holds
};

struct GateResult {
  std::vector<GateLine> lines;
  std::vector<std::string> problems;  ///< of the run itself (find_run_problems): with one, nothing holds

  bool holds() const;
};

/// Holds a run's records against the accepted figures (palpate/accepted/1). The median over the repeats after
/// warm-up counts; a case with a repeat that is not accepted has no figure, and a missing or null figure
/// fails. An error of a displacement whose row is marked (reference_too_coarse) is never held: it fails, so
/// that the figure is taken out of the file. Throws: InputError with the file and the key if the accepted
/// file is not what it has to be.
GateResult hold_against(const std::vector<nlohmann::json>& records, const std::string& plan,
                        const std::filesystem::path& accepted_file);

/// Puts the measured values into the accepted file, tolerances kept. Figures without a measured value stay.
/// Returns one line for each change.
std::vector<std::string> update_accepted(const GateResult& result,
                                         const std::filesystem::path& accepted_file);

}  // namespace palpate::experiments
