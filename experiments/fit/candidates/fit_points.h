// What the runs of a fit found, candidate by candidate, and which of them it takes.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "experiments/fit/candidates/fit_plan.h"
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
  /// Numbers of the loads that it was run on and nothing was chosen by; their errors are the last ones.
  std::vector<std::size_t> confirmed_on{};
  std::size_t looked_at = 0;  ///< loads that they are the worst of, as far as a coarse look tells

  bool is_confirmed() const { return !confirmed_on.empty(); }
  double cost() const;
  /// The largest of error + own_error, and what the step leaves of the motion on top: no more than this is
  /// certain.
  double worst_error() const;
  /// What is not exceeded on loads like those that it was run on, with a certainty of nine in ten: the
  /// largest error plus (10^(1 / (n - 1)) - 1) times their range, the upper confidence bound for n errors
  /// spread evenly between two unknown bounds. n counts loads that a coarse look found harmless too.
  /// worst_error() of a single load.
  double estimated_error() const;
  /// What is known of all loads like those: the estimated one of a confirmed point, else the worst.
  double known_error() const;
};

/// Errors of a run's records by the plan's scenes, of the candidate and without the reference's own; null
/// where it was not run or not accepted.
std::vector<std::optional<double>> read_errors(const std::vector<nlohmann::json>& records,
                                               const FitPlan& plan, const SceneRequirement& require,
                                               const FitCandidate& candidate);

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

/// One that was refused on further loads, of the same model as a point that was not run on them, and no worse
/// on those that both were run on, if the point is over the tolerance too once further loads add to its error
/// what they added to that one's; on meshes by another simplifier by a twentieth, since they may add less
/// there. Null: none.
const FitPoint* find_better_refused(const FitPoint& point, const std::vector<FitPoint>& checked,
                                    const SceneRequirement& require);

/// Those that do, cheapest first.
std::vector<const FitPoint*> choose_cheapest(const std::vector<FitPoint>& points,
                                             const SceneRequirement& require);

/// Candidates within so many times of each other's cost cost the same: a table of compliances was timed at 40
/// to 54 us again and again.
inline constexpr double kSameCost = 1.25;

/// Of what meets everything on all loads that it was run on and costs the same as `point`, the one that is
/// the least off: the safer choice where no time is left to confirm any. `point` itself if none is less off.
const FitPoint* find_safest(const FitPoint& point, const std::vector<FitPoint>& checked,
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

/// Where nothing does: the one that comes closest, by the product of how many times it is over the tolerance
/// (a confirmed one by its estimated error) and over the budget; of equals the cheapest. Null without any
/// figure.
const FitPoint* find_nearest(const std::vector<FitPoint>& points, const SceneRequirement& require);

/// The point with that candidate, or null.
const FitPoint* find_point(const std::vector<FitPoint>& points, const std::string& label,
                           const std::string& simplifier, std::optional<double> ratio);
const FitPoint* find_point(const std::vector<FitPoint>& points, const FitCandidate& candidate);

}  // namespace palpate::experiments
