// The inputs of a contest of motions: each dynamic scene as a problem on its mesh, and its reference.
#pragma once

#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "experiments/contests/contest.h"
#include "experiments/contests/problem_files.h"
#include "experiments/plan_reader/plan.h"
#include "reference/door/motion_problem.h"

namespace palpate::experiments {

/// How many of the lowest natural frequencies a contest of motions compares.
inline constexpr std::size_t kComparedFrequencies = 10;

/// A dynamic scene as the door has it: the clamps hold the body, each load is a problem of its own.
///
/// Throws: InputError for what the contest cannot ask of all contestants alike: a preset, large strain,
/// damping by absolute constants or of the isotropic kind, masses a vertex, a speed limit, no probe; and as
/// resolve_problem does.
reference::MotionProblem build_compared_problem(const Scene& placed, const TetMesh& mesh);

/// The stretch of time in which a probe's oscillation is fitted: from the last change of the loads to the
/// end, or, where that is less than a fifth of the motion (loads that never rest), its second half.
std::array<double, 2> judging_window(const reference::MotionProblem& problem);

/// One problem of a run, written for the requests.
struct MotionInput {
  std::string failure;               ///< of a simplified one: why there is none; empty if there is
  std::optional<double> simplify_s;  ///< of a simplified one: what the simplifier took
  std::string id;                    ///< "plucked_bar", then "/vertices=1503" where it is swept
  std::string scene;
  nlohmann::json sweep = nlohmann::json::object();
  Scene placed;
  reference::MotionProblem problem;
  ProblemFiles files;  ///< its `problem` stays empty: what is written is the motion's
};

/// Makes the mesh, places the scene on it and writes both below `folder`.
MotionInput build_motion_input(const PlanScene& scene, const nlohmann::json& sweep,
                               const std::filesystem::path& folder);

/// The same problem on a mesh that a simplifier made of `whole`'s. A mesh without a vertex where each probe
/// of the whole one is has nothing to compare, which is its failure.
MotionInput simplify_motion_input(const MotionInput& whole, const Case& run_case, const std::string& id,
                                  const ContestSetting& setting);

/// A history with what the judge needs of it.
struct JudgedMotion {
  reference::MotionHistory history;
  std::vector<double> frequencies_hz;
};

/// Errors of a motion against another one of the same problem, by the judge: frequency_errors (signed,
/// relative), frequency_first, frequency_mean and frequency_worst (of their sizes), probe_l2, force_l2 (of
/// the worst tool; absent without one), and of the oscillation of the first probe along its main direction
/// amplitude_error, phase_error_deg, oscillation_error, damping_ratio_error and decay_error (absent where
/// there is none, or where the fit of one of the two explains too little), with oscillation_hz and
/// unexplained.
nlohmann::json compare_motions(const reference::MotionProblem& problem, const JudgedMotion& found,
                               const JudgedMotion& truth);

/// The motion that a contestant's body has if its solver leaves nothing.
struct OwnLimit {
  std::string failure;  ///< why there is none; empty if there is
  reference::MotionHistory history;
  nlohmann::json run;  ///< what the solution reports, with its times
  bool interrupted = false;
};

/// Solves it: the method of the case with the options of its plan's `own_limit` set over its own. What an
/// earlier run solved is taken from the cache.
OwnLimit solve_own_limit(const MotionInput& input, const Case& run_case, const ContestSetting& setting);

/// What came of the reference: its finest level, and estimates of its own errors.
struct MotionReference {
  std::string failure;  ///< why there is none; empty if there is
  std::string outcome = "accepted";
  JudgedMotion truth;
  std::filesystem::path history_file;
  /// By the names of compare_motions: what the next coarser level is off, over 2^p - 1 if the plan states an
  /// order p of convergence (else all of it, a bound), plus a third of what twice the time step changes (the
  /// error of time, of second order).
  nlohmann::json own_error = nlohmann::json::object();
  std::vector<nlohmann::json> runs;  ///< what each solution reports, with its times
  bool interrupted = false;
};

/// Solves the reference; what an earlier run solved is taken from the cache.
MotionReference solve_motion_reference(const MotionInput& input, const ContestSetting& setting);

}  // namespace palpate::experiments
