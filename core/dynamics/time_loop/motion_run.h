// The time loop: steps a body to the end, watches it, and says what happened.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "core/dynamics/integrators/integrator.h"

namespace palpate::dynamics {

/// How a run ended.
enum class MotionOutcome {
  kCompleted,  ///< all steps taken, no tet inverted at the end
  kInverted,   ///< all steps taken, but tets are not positive at the end
  kDiverged,   ///< stopped at the first state that is not finite or has left the bounds
  kUnsolved,   ///< all steps taken, none inverted, but a solver did not come to its tolerance in some
  kStopped,    ///< should_stop said so
};

/// "completed", "inverted", "diverged", "unsolved" or "stopped".
const char* motion_outcome_name(MotionOutcome outcome);

/// How long a run goes, who looks on, and what ends it.
struct MotionRunOptions {
  double step_s = 0.0;
  std::uint64_t steps = 0;
  /// A displacement beyond so many times the longest side of the rest shape's box ends the run as diverged.
  double escape_ratio = 1000.0;
  std::uint64_t observe_every =
      0;  ///< steps between calls of the observer; 0: at the start and the end alone
  /// Asked before each step; true ends the run. May be empty. The plain engine takes steps for up to some 10
  /// ms before it asks again. The motion is the same whether it is asked or not.
  std::function<bool()> should_stop = nullptr;
};

/// What happened in a run. Nothing of it is hidden by a limit: what a speed limit cuts is counted.
struct MotionReport {
  MotionOutcome outcome = MotionOutcome::kCompleted;
  std::uint64_t steps = 0;                ///< taken, the one that diverged too
  std::uint64_t zero_length_springs = 0;  ///< over all force evaluations
  std::uint64_t speeds_cut = 0;           ///< vertices times steps
  std::uint64_t steps_with_cuts = 0;
  std::uint64_t solver_iterations = 0;
  std::uint64_t steps_unsolved = 0;  ///< whose solver did not come to its tolerance
  /// Largest share of the forces out of balance that a solver left, of the steps in which it was measured.
  std::optional<double> residual_worst;
  double peak_speed_m_s = 0.0;         ///< after cutting
  std::size_t inverted_tets = 0;       ///< at the end
  std::size_t inverted_tets_most = 0;  ///< at the worst of the observed times
  double first_inversion_s = -1.0;     ///< first observed time with an inverted tet; -1: never
  Index first_bad_vertex = kNoIndex;   ///< kDiverged: the first vertex that is not finite or has escaped
  bool is_finite = true;               ///< of the last state
  std::uint64_t state_hash = 0;        ///< hash_state of the last state
};

/// What the end of a run is called: by a state that is good or not, what stopped it, and its counts.
MotionOutcome name_end(const MotionReport& report, bool is_good, bool is_stopped);

/// Called at the start, every observe_every steps and at the end, wherever that is, for states that are
/// finite; once for each.
using MotionObserver = std::function<void(std::uint64_t step, const MotionState& state)>;

/// Takes `options.steps` steps from `state`, which becomes the last one. Inverted tets are counted when the
/// observer is called. Throws: InputError for a step that is not a finite number above zero.
MotionReport run_motion(Integrator& integrator, MotionState& state, const MotionRunOptions& options,
                        const MotionObserver& observer = {});

}  // namespace palpate::dynamics
