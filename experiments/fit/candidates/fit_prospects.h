// What of a search is worth a check on more loads, and in which order.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "experiments/fit/candidates/fit_points.h"

namespace palpate::experiments {

/// What a candidate that may be looked at on more loads is expected to come to: none of it decides anything
/// but the order.
struct FitProspect {
  FitCandidate candidate;
  double cost_s = 0.0;
  double expected_error = 0.0;  ///< relative, the worst on all loads; infinity: nothing is known of it
  bool is_likely = true;        ///< what is known of its model on other loads does not speak against it
  bool is_between = false;      ///< it is a share between two, which the search has not run
};

/// How many times a model's worst error over all loads (of a confirmed point, the estimated one) is that on
/// the scene itself: the most of what was checked of it, at least 1; 1 where nothing was.
double growth_on_loads(const std::vector<FitPoint>& searched, const std::vector<FitPoint>& checked,
                       const std::string& model);

/// What a point costs: no more than what was checked or searched of its model and simplifier with no more
/// removed. A model on fewer tetrahedra is expected to cost no more than on more: one time of the search
/// alone may be that of a busy machine, and would leave out what is cheap. Seconds.
double lowered_cost(const FitPoint& point, const std::vector<FitPoint>& searched,
                    const std::vector<FitPoint>& checked);

/// What is worth a check on all loads, the likely ones first, the cheapest of each first, and those that
/// cost the same within noise (kSameCost times the cheapest of them at most) the most accurate and the
/// cheapest by turns: points of the search that meet all on the scene itself, and, where one share of a
/// simplifier meets it and the next one up does not, or both miss the tolerance and one of them by less than
/// a twentieth of it, the share in the middle (down to steps of kLeastShareStep; above the greatest share,
/// half of what is left). Costs in the middle are read off the line between both, and fewer tetrahedra are
/// expected to cost no more. Left out: what was checked, graded meshes (their sizes are for one share), and
/// what is expected to cost `most_cost_s` or more.
std::vector<FitProspect> list_prospects(const std::vector<FitPoint>& searched,
                                        const std::vector<FitPoint>& checked, const FitCandidates& candidates,
                                        const SceneRequirement& require, double most_cost_s);

/// The next `count` of them to check. Where nothing is verified yet (`has_choice` false), the first half of
/// them are points of the search, which are surer than what lies between.
std::vector<FitCandidate> take_prospects(const std::vector<FitProspect>& prospects, std::size_t count,
                                         bool has_choice);

/// Shares closer than that are not told apart.
inline constexpr double kLeastShareStep = 0.02;

}  // namespace palpate::experiments
