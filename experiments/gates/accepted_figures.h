// The figures that a plan's runs are held against, as results/accepted has them.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/base/enum_names.h"

namespace palpate::experiments {

/// What an accepted figure says of a run (docs/gates.md). A time is no kind: only a ratio of two in one run
/// is.
enum class FigureKind { kAccuracy, kValidity, kStability, kHash, kComparison, kTimeRatio };
inline constexpr EnumNames<FigureKind, 6> kFigureKindNames{
    "a figure's kind", {"accuracy", "validity", "stability", "hash", "comparison", "time_ratio"}};

/// One accepted figure. `measure` is empty for a hash and for a validity that is an outcome.
struct AcceptedFigure {
  FigureKind kind = FigureKind::kAccuracy;
  std::string run_case;    ///< comparison: the case that is to be less
  std::string other_case;  ///< comparison: than this one; time ratio: over this one
  std::string measure;
  std::string unit;
  std::optional<double>
      value;           ///< none yet, or none at all; comparison: what `other_case` was over `run_case`
  std::string word;    ///< the hash or the outcome; empty: none yet
  double lower = 0.0;  ///< may be less by this much; time ratio: by this factor
  double upper = 0.0;  ///< and more by this much; time ratio: by this factor; stability: as much as it likes
  std::optional<double> at_least;  ///< stability: and never less than this, whatever is accepted
  double by_factor = 1.0;          ///< comparison: run_case < other_case / by_factor

  /// Whether it is a word (a hash, an outcome) and no number.
  bool is_word() const { return measure.empty(); }

  /// A name for people: the case or cases, and the measure, "outcome" or "hash".
  std::string name() const;
};

/// Whether a measure is a margin or a step that the kind stability takes: more of it is never worse.
bool is_stability_measure(const std::string& measure);

/// A file of accepted figures: palpate/accepted/2, or palpate/accepted/1, whose figures are all of accuracy.
struct AcceptedFile {
  nlohmann::ordered_json data;  ///< as it was read
  std::vector<AcceptedFigure> figures;
};

/// Reads accepted figures of `plan`. The list may be empty.
/// Throws: InputError with the file, the figure and the key, for one that is not what it has to be: unknown
///         keys and measures (with the nearest), units that are not the measure's, figures twice, a time that
///         is no ratio.
AcceptedFile read_accepted(const std::filesystem::path& path, const std::string& plan);

}  // namespace palpate::experiments
