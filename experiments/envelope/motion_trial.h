// A fitted scene in motion, at one place on an axis: how it ends, and what its step adds to the motion.
#pragma once

#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "experiments/contestants/contestant.h"
#include "experiments/envelope/fitted_folder.h"

namespace palpate::experiments {

/// Displacements of the probes over time.
struct ProbeHistory {
  std::vector<double> time_s;
  std::vector<std::vector<double>> row;  ///< a component of a probe each
};

inline constexpr double kTrialSeconds = 120.0;

/// One run as `simulate` would do it.
struct MotionTrial {
  std::string outcome;  ///< "completed", "diverged", "inverted", "unsolved", "timed_out"
  double step_s = 0.0;
  ProbeHistory history;
};

/// The columns time_s and probe_* of an engine's answer (palpate/engine/1). What is no number is NaN. Throws:
/// InputError with the file for one that is not as it should be.
ProbeHistory read_probe_history(const std::filesystem::path& file);

/// sqrt(sum over the rows and components of `coarse` of (c - f)^2 / sum of f^2), f between two rows of `fine`
/// by a straight line; rows past the end of `fine` are left out. 0 where neither moves; infinite where only
/// `coarse` does, or it has something that is no number. Cost: linear.
double history_difference(const ProbeHistory& coarse, const ProbeHistory& fine);

/// Runs the scene, which is written below `folder` (made), for at most kTrialSeconds of the clock. Throws: as
/// simulate.
MotionTrial run_motion_trial(const nlohmann::json& scene, const FittedFolder& fitted,
                             const Registry& registry, const std::filesystem::path& folder,
                             const volatile std::sig_atomic_t* stop_flag);

}  // namespace palpate::experiments
