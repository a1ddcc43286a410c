// What the runs of a fit found, candidate by candidate, and which of them it takes.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "experiments/fit/fit_plan.h"
#include "experiments/trials/fit_stepping.h"

namespace palpate::experiments {

/// What a candidate reached.
struct FitPoint {
  FitCandidate candidate;
  std::string case_id;  ///< on the scene itself
  std::string mesh;     ///< its problem's folder below the run
  std::size_t vertices = 0;
  std::size_t tets = 0;
  std::vector<double> error;  ///< on each scene of its plan that it was judged on, in their order; relative
  std::vector<double> own_error;  ///< of the reference, on the same
  std::vector<double> cost_s;     ///< of the scene itself, one a repeat
  std::optional<double> explicit_step_s;
  std::optional<double> answer_s;  ///< of a back-substitution, where the plan asks for it
  std::uint64_t memory_bytes = 0;
  std::string failure;                    ///< why it has no figure; empty if it has
  std::vector<SteppingTry> steppings{};   ///< on the scene's own motion
  std::optional<SteppingTry> stepping{};  ///< the one that is taken; its cost is the point's then
  bool is_confirmed = false;              ///< run on loads that nothing was chosen by

  double cost() const;
  /// The largest of error + own_error, and what the step leaves of the motion on top: no more than this is
  /// certain.
  double worst_error() const;
  /// What that is estimated to be at most on all loads like those that it was run on: the largest plus the
  /// range over their number less one, which is right on average for errors spread evenly between two bounds
  /// (the UMVU estimate of the upper one). worst_error() of a single load.
  double estimated_error() const;
  /// What is known of all loads like those: the estimated one of a confirmed point, else the worst.
  double known_error() const;
};

/// The points of a run's records, in the order of the plan's candidates.
std::vector<FitPoint> read_fit_points(const std::vector<nlohmann::json>& records, const FitPlan& plan,
                                      const SceneRequirement& require);

/// Why a point does not do, empty if it does: it failed, is over the tolerance (a confirmed one by its
/// estimated error), the budget or the memory.
std::string why_not(const FitPoint& point, const SceneRequirement& require);

/// Why a checked point is not chosen: why_not, or one of its model that is no worse on the loads that both
/// were run on was refused on further ones.
std::string why_not_chosen(const FitPoint& point, const std::vector<FitPoint>& checked,
                           const SceneRequirement& require);

/// Those that do, cheapest first.
std::vector<const FitPoint*> choose_cheapest(const std::vector<FitPoint>& points,
                                             const SceneRequirement& require);

/// Takes the next `count` finalists out of `good` (cheapest first): the cheapest, and in the last one's place
/// the one with the least `answer_s`, unless it is among them. Steps of implicit integrators come to a
/// back-substitution each, so that one whose explicit steps are dear may still be the cheapest to move.
std::vector<const FitPoint*> take_finalists(std::vector<const FitPoint*>& good, std::size_t count);

/// Whether a candidate is one of modes.
bool is_modal(const FitCandidate& candidate);

/// Takes one of modes out of `good` (cheapest first) as a finalist: the cheapest whose error at rest is at
/// most half of what is allowed, so that its motion may have the other half; where there is none, the one
/// with the least error. What was not taken stays. Null if there is none of modes.
const FitPoint* take_modal_finalist(std::vector<const FitPoint*>& good, double at_most);

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

/// What is worth a check on all loads, the likely ones first, the cheapest of each first, and of those that
/// cost the same within noise (1.25 times the cheapest of them at most) the most accurate first: points of
/// the search that meet all on the scene itself, and, where one share of a simplifier meets it and the next
/// one up does not, or both miss the tolerance and one of them by less than a twentieth of it, the share in
/// the middle (down to steps of kLeastShareStep; above the greatest share, half of what is left). Costs in
/// the middle are read off the line between both, and fewer tetrahedra are expected to cost no more. Left
/// out: what was checked, graded meshes (their sizes are for one share), and what is expected to cost
/// `most_cost_s` or more.
std::vector<FitProspect> list_prospects(const std::vector<FitPoint>& searched,
                                        const std::vector<FitPoint>& checked, const FitCandidates& candidates,
                                        const SceneRequirement& require, double most_cost_s);

/// The next `count` of them to check. Where nothing is verified yet (`has_choice` false), the first half of
/// them are points of the search, which are surer than what lies between.
std::vector<FitCandidate> take_prospects(const std::vector<FitProspect>& prospects, std::size_t count,
                                         bool has_choice);

/// Shares closer than that are not told apart.
inline constexpr double kLeastShareStep = 0.02;

/// Where nothing does: the one that comes closest, by the product of how many times it is over the tolerance
/// (a confirmed one by its estimated error) and over the budget; of equals the cheapest. Null without any
/// figure.
const FitPoint* find_nearest(const std::vector<FitPoint>& points, const SceneRequirement& require);

/// The point with that candidate, or null.
const FitPoint* find_point(const std::vector<FitPoint>& points, const std::string& label,
                           const std::string& simplifier, std::optional<double> ratio);

}  // namespace palpate::experiments
