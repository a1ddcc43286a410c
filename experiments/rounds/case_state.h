// What earlier repeats of a case left, and whether there are enough of them.
#pragma once

#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "experiments/plan_reader/case_list.h"
#include "experiments/plan_reader/plan.h"

namespace palpate::experiments {

/// An interval of a median by order statistics.
struct MedianInterval {
  double low = 0.0;
  double high = 0.0;
  double coverage = 0.0;  ///< the chance that it holds the true median
};

/// The interval of the median of independent values: from the i-th smallest to the i-th largest, with the
/// greatest i that keeps `level`:
///
///   coverage = 1 - 2 P(B <= i - 1),   B ~ Binomial(n, 1/2),
///
/// exact for every continuous distribution. Returns: nothing if i = 1 does not keep the level either (fewer
/// than 6 values at 95%). Source: report/shared/intervals.py has the same rule.
std::optional<MedianInterval> median_interval(std::vector<double> values, double level = 0.95);

/// (high - low) / median of that interval at 95%; infinite where there is none.
double relative_median_width(const std::vector<double>& values);

/// Measured repeats that a case gets.
struct RepeatBounds {
  int least = 1;
  int most = 1;                 ///< the same as `least` where no width is asked for
  std::optional<double> width;  ///< the relative width of the interval of the median kernel time that ends it
};

/// The bounds that a plan sets for a case.
RepeatBounds repeat_bounds(const RunSettings& run, const Case& c);

/// Why a case is not repeated any more.
enum class RepeatsEnd {
  kNotYet,  ///< it is
  kAll,     ///< it has the plan's number, and no width was asked for
  kNarrow,  ///< the interval of its median kernel time is as narrow as asked for
  kLimit,   ///< it has the most that the plan allows
  kNoTime,  ///< a repeat gave no kernel time: no number of them makes an interval
  kHalved   ///< it cannot be on the plan's frontier any more (rounds/halving.h)
};

/// An answer that a case gave, as far as a later repeat's is held against it.
struct PastAnswer {
  std::string output_hash;
  nlohmann::json ended;             ///< what the contestant said of its end; null where it said nothing
  std::vector<std::uint8_t> judge;  ///< the judge's block as MessagePack: a fifth of what it takes as JSON
};

/// What earlier repeats of a case left: as much as its further repeats need, so that 10^6 of them can be
/// held.
struct CaseState {
  std::set<int> done;
  double wall_s = -1.0;  ///< of the last repeat; below zero: not known
  RepeatsEnd end = RepeatsEnd::kNotYet;
  double width = std::numeric_limits<double>::infinity();  ///< relative_median_width of its kernel times
  std::string halved_by;                                   ///< kHalved: the case that beats it
  std::optional<double> tets;      ///< of the first answer that was judged to have some
  std::optional<double> distance;  ///< of its skin from the input's, two-sided, at most, in the mesh's unit
  nlohmann::json tuned = nlohmann::json::object();  ///< what the first search found
  std::string worst;  ///< outcome of the last repeat that was not accepted, else of the first; empty: not run
  std::string first_failure;  ///< outcome and reason of the first repeat that was not accepted

  /// Takes a record in. `bounds` are the case's.
  void remember(const nlohmann::json& record, const RepeatBounds& bounds);

  /// The answers so far, each once, as records with output_hash, report and judge.
  std::vector<nlohmann::json> earlier_answers() const;

  /// Lets go of the answers: the case is not repeated any more.
  void drop_answers();

  /// Whether an outcome forbids another repeat: it timed out, was refused, could not be had or judged.
  bool is_closed() const;

  /// Whether this repeat (0 is the first warm-up) is to be run.
  bool is_due(int repeat, int warmup, const RepeatBounds& bounds) const;

  /// Repeats that are to be run.
  int count_due(int warmup, const RepeatBounds& bounds) const;

  /// Measured repeats so far.
  int count_measured() const;

 private:
  void remember_answer(const nlohmann::json& record);

  std::vector<PastAnswer> answers_;
  std::vector<double> times_;  ///< kernel times of measured repeats
  int measured_ = 0;
  bool is_closed_ = false;
};

/// "narrow", "limit", "no_time" or "halved"; empty for the others.
const char* repeats_end_name(RepeatsEnd end);

/// States in a provenance how many repeats each case has to have ("repeats_of", for those that have not the
/// plan's number) and, where a width or halving was asked for, why those that ended did ("repeats_ended":
/// reason, repeats, width, and of those that were halved what beats them). A case that has not ended has to
/// have the most, so that a run that is broken off is not taken for whole.
void state_repeats(const RunSettings& run, const std::vector<Case>& cases,
                   const std::vector<CaseState>& states, nlohmann::json& provenance);

}  // namespace palpate::experiments
