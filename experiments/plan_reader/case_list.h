// The cases of a plan: one a mesh, label, sweep value and seed, in an order in which each finds what it
// needs.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "experiments/plan_reader/plan.h"

namespace palpate::experiments {

/// One thing to run, some times over.
struct Case {
  std::string id;              ///< "kidney/sequential_random/tets_removed_ratio=0.1/seed=3"
  std::size_t subject = 0;     ///< index into Plan::meshes (simplify, stability), Plan::scenes (deform) or
                               ///< Plan::known_cases (verify)
  std::size_t contestant = 0;  ///< index into Plan::contestants
  Stop stop;
  nlohmann::json options;  ///< every option, typed
  nlohmann::json sweep = nlohmann::json::object();
  std::optional<std::int64_t> seed;
  std::optional<std::size_t> tets_of;     ///< index of the case whose tets are matched; always an earlier one
  std::optional<std::size_t> coarser;     ///< contest verify: index of the case on the next coarser mesh
  std::optional<std::size_t> simplifier;  ///< index into Plan::simplifiers, where the plan has some
  Stop simplifier_stop;
};

/// Builds the cases, meshes or scenes outermost. A contestant without a stop of its own is crossed with the
/// sweep's stop, one that has a swept option free with that option, and one with `tets_of` follows the label
/// that it names through that label's sweep. Each is crossed with the problems' axes (poisson_ratio,
/// vertices) and, where the plan has simplifiers, with them ("simplify=LABEL").
std::vector<Case> cross_cases(const Plan& plan, const Registry& registry);

/// Measured repeats of a case: those of the plan, or, where it is one of several seeds, its `seed_repeats`.
int repeats_of(const RunSettings& run, const Case& c);

/// The most measured repeats of a case: `most_repeats` where the plan asks for a width of intervals, but for
/// one of several seeds that have a number of their own; otherwise repeats_of.
int most_repeats_of(const RunSettings& run, const Case& c);

/// The indices of the cases that are wanted and of those that they need, in order.
std::vector<std::size_t> with_needed_cases(const std::vector<Case>& cases, std::vector<bool> wanted);

/// The indices of the cases that `id` names, themselves or by a leading part ("kidney",
/// "kidney/hierarchical_87"), with the cases that they need, in order.
/// Throws: InputError if there is none, with the nearest.
std::vector<std::size_t> select_cases(const std::vector<Case>& cases, const std::string& id);

}  // namespace palpate::experiments
