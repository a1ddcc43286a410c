// Successive halving: which cases of a plan with a frontier need no more repeats, since they cannot be on it.
#pragma once

#include <cstddef>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "experiments/plan_reader/case_list.h"

namespace palpate::experiments {

/// Between what an error lies: the judged one, less and more the reference's own.
struct ErrorSpan {
  double low = 0.0;
  double high = std::numeric_limits<double>::infinity();
};

/// What a case has shown so far.
struct HalvingFigures {
  std::string group;                        ///< scene and family: cases of one stand for each other
  std::map<std::string, ErrorSpan> errors;  ///< by measure
  std::map<std::string, std::vector<double>> times_s;  ///< by work: one a repeat
};

/// The cases of `is_open` that get no more repeats. In each group, for each work, the dearer half of the open
/// cases by their medians is looked at; such a case is left where for each of its works and errors
///
///   - it is in the dearer half of that work, and
///   - some case of the group, open or not, took less in all of its repeats than it in any, and has an error
///     that is no greater whatever the references' own errors are (its high <= the other's low).
///
/// A group is a family of the frontier on one scene, at one Poisson's ratio: what beats a case stands in its
/// family's place, so the fastest of each family at each error keeps all its repeats.
///
/// So no case is left for its error, and none that is alone with a figure. Two equal cases of n repeats each
/// part so by chance once in (2n)! / (n! n!): 20 at 3, 924 at 6. Cost: quadratic in the cases of a group.
///
/// Returns: for each case the other that beats it (of the first work and error), or nothing. Deterministic.
std::vector<std::optional<std::size_t>> find_halved(const std::vector<HalvingFigures>& cases,
                                                    const std::vector<bool>& is_open);

/// Whether so many measured repeats end a rung: first, 2 first, 4 first, ...
bool is_rung(int measured, int first);

/// The figures of a run's cases, from its records (contest deform).
class HalvingRecords {
 public:
  HalvingRecords(const Plan& plan, const std::vector<Case>& cases);

  /// Takes in a record of the reference.
  void add_reference(const nlohmann::json& record);
  /// Takes in a record of a case, warm-ups too, which count for nothing.
  void add(std::size_t index, const nlohmann::json& record);
  /// The figures of all cases by their first `measured` repeats.
  std::vector<HalvingFigures> figures(int warmup, int measured) const;

 private:
  struct Repeat {
    int number = 0;
    std::map<std::string, double> times_s;
  };
  struct Own {
    std::string group;
    std::string problem;
    std::map<std::string, double> errors;
    std::vector<Repeat> repeats;
  };

  std::vector<Own> cases_;
  std::map<std::string, std::map<std::string, double>> reference_errors_;  ///< problem -> measure -> error
};

}  // namespace palpate::experiments
