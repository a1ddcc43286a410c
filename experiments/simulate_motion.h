// simulate for dynamic scenes: runs the phases of a motion and reports.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

#include "experiments/motion_output.h"
#include "experiments/scene.h"

namespace palpate::experiments {

struct SimulateMotionOptions {
  std::filesystem::path out;  ///< a folder that exists
  int threads = 1;
  double timeout_s = 3600.0;
  double most_output_bytes = kMostOutputBytes;
};

/// Runs a dynamic scene, writes frames.pvd, frame_*.vtu, history.csv and summary.json, and returns the
/// summary: outcome ("completed", "diverged", "inverted"), steps, kernel_s (stepping alone), time_step_s,
/// engine ("plain" or "general", with why_general), precision, stable_step_s with stable_by and
/// stability_margin (bound / step; null without a bound), energies at the start and the end, counts
/// (zero_length_springs, speeds_cut, inverted_tets, ...), state_hash, files.
///
/// Throws: InputError as build_motion and require_room do, before anything is written; UnavailableError after
/// timeout_s.
nlohmann::json simulate_motion(const Scene& scene, const SimulateMotionOptions& options);

/// Runs what is set up, of a placed scene on its mesh, and gives the same summary, without files; `output`
/// takes rows and frames. Throws: UnavailableError after timeout_s.
nlohmann::json run_motion_setup(const Scene& placed, const TetMesh& mesh, const MotionSetup& setup,
                                double timeout_s, MotionOutput& output);

}  // namespace palpate::experiments
