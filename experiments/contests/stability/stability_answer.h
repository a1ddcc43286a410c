// The answer's file of the contest stability (palpate/stability_answer/1, reference/PROTOCOL.md), as the
// judge reads it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/judge/motion/stability_reading.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::experiments {

/// One end of a bracket: a trial about rest, or a run.
struct BracketEnd {
  double step_s = 0.0;
  std::optional<judge::TrialHistory> trial;  ///< of "trials" alone
  std::optional<judge::RunHistory> run;      ///< of "step_map" and "runs"
};

/// The two steps between which the longest stable one is said to lie.
struct StabilityBracket {
  std::string by;  ///< "trials", "step_map" or "runs"
  BracketEnd lower;
  BracketEnd upper;
};

struct StabilityAnswer {
  double rounding = 0.0;  ///< share of a body's size below which a displacement is rounding
  std::vector<judge::RunHistory> runs;
  std::optional<StabilityBracket> bracket;
};

/// Reads it, with each history held against the body at rest (judge::check_history). Throws: InputError that
/// names the file and the place in it.
StabilityAnswer read_stability_answer(const std::filesystem::path& file, const TetMesh& rest);

}  // namespace palpate::experiments
