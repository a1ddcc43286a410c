// simulate for dynamic scenes: runs the phases of a motion and reports.
#pragma once

#include <csignal>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "experiments/scene_reader/scene.h"
#include "experiments/simulation/motion_output.h"

namespace palpate::experiments {

/// What ends a run before its time. It is looked at before each step; the plain engine takes steps for up to
/// some 10 ms in between.
struct MotionStops {
  double timeout_s = std::numeric_limits<double>::infinity();
  const volatile std::sig_atomic_t* stop_flag = nullptr;  ///< ends it when it turns non-zero; may be null
};

struct SimulateMotionOptions {
  std::filesystem::path out;  ///< a folder that exists
  int threads = 1;
  MotionStops stops{3600.0, nullptr};  ///< the time-out counts from the call on; setting up is not stopped
  double most_output_bytes = kMostOutputBytes;
};

/// Runs a dynamic scene, writes frames.pvd, frame_*.vtu, history.csv and summary.json, and returns the
/// summary: outcome ("completed", "inverted", "unsolved", "diverged", "timed_out" or "interrupted"), steps
/// and steps_planned, kernel_s (stepping alone), time_step_s, engine ("plain" or "general", with
/// why_general), precision, stable_step_s with stable_by and stability_margin (bound / step; null without a
/// bound), energies at the start and the end, counts (zero_length_springs, speeds_cut, inverted_tets, ...),
/// state_hash, files. However a run ends, the last state is in history, frames and summary, unless it is not
/// finite.
///
/// Results of an earlier run in the folder are removed first (remove_earlier_results).
///
/// Throws: InputError as build_motion and require_room do, before anything is written.
nlohmann::json simulate_motion(const Scene& scene, const SimulateMotionOptions& options);

/// Runs what is set up, of a placed scene on its mesh, and gives the same summary, without files; `output`
/// takes rows and frames. Of single precision it has rounding_gain_j (core/dynamics/time_loop/plain_run.h)
/// and rounding_gain_over_kinetic, over the greatest kinetic energy of the history; else both are null.
nlohmann::json run_motion_setup(const Scene& placed, const TetMesh& mesh, const MotionSetup& setup,
                                const MotionStops& stops, MotionOutput& output);

}  // namespace palpate::experiments
