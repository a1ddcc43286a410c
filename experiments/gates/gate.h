// The gate: figures of a run held against accepted ones.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "experiments/gates/accepted_figures.h"
#include "experiments/judging/measure.h"
#include "experiments/records/run_rows.h"

namespace palpate::experiments {

/// One accepted figure and what the run says to it.
struct GateLine {
  AcceptedFigure figure;
  std::optional<double> measured;  ///< median over the repeats that count, or the ratio of two
  std::string measured_word;       ///< the outcome or the hash of all repeats
  std::string problem;             ///< why it fails, empty if it holds
  std::string by;                  ///< how far it is outside, for people; empty where that is no number
  /// How far it is outside, as a share of the accepted value (or of the tolerance, if that is larger);
  /// infinite where nothing of the kind can be said: no figure, another hash. 0 if it holds.
  double shortfall = 0.0;
};

struct GateResult {
  std::string plan;
  std::string run;  ///< its folder
  std::vector<GateLine> lines;
  /// Of the run itself (find_run_problems), or that there is nothing to compare: with one, nothing holds.
  std::vector<std::string> problems;

  bool holds() const;

  /// The lines that fail, farthest outside first.
  std::vector<const GateLine*> failures() const;
};

/// Repeats that a ratio of two times needs of each of its cases.
inline constexpr std::size_t kLeastTimeRepeats = 5;

/// The measures whose figures of a run's records accepted figures are held against, each once.
std::vector<const Measure*> measures_of(const AcceptedFile& accepted);

/// Holds a run, by the rows of its records, against accepted figures (docs/gates.md):
///
///   accuracy    the median over the repeats after warm-up is within [value - lower, value + upper]
///   validity    each repeat has exactly this figure, or ended with this outcome
///   stability   the median is at least value - lower, and at least at_least
///   hash        each repeat, warm-up too, gave this output, to the bit
///   comparison  median of `less` < median of `than` / by_factor
///   time_ratio  median time of a case over that of another is within [value / lower, value upper]; of each
///   at
///               least 5 repeats after warm-up, those with a search left out of wall and processor time
///
/// But for outcomes and hashes, a case with a repeat that is not accepted has no figure, and a missing or
/// null figure fails. An error of a displacement whose row is marked (reference_too_coarse) is never held: it
/// fails, so that the figure is taken out of the file. Without a figure that the run has there is nothing to
/// compare, which is a problem of the run.
/// The rows keep the figures of the file's measures (measures_of).
/// Throws: InputError with the file and the key if the accepted file is not what it has to be.
GateResult hold_against(const RunRows& rows, const std::string& plan,
                        const std::filesystem::path& accepted_file);

/// What holding one figure against the rows gives, which keep its measure's figures.
GateLine hold_figure(const AcceptedFigure& figure, const RunRows& rows);

}  // namespace palpate::experiments
