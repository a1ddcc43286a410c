// The integrators of a fit on the fitted scene's own motion: errors against finer steps, and measured times.
#pragma once

#include <csignal>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "experiments/registry/registry.h"
#include "experiments/trials/fit_stepping.h"

namespace palpate::experiments {

/// A fitted scene whose motion is to be stepped.
struct SteppingTask {
  nlohmann::json scene;                         ///< as build_fitted_scene makes it
  std::filesystem::path mesh;                   ///< in m
  nlohmann::json probes_m;                      ///< where motions are held against each other
  double most_error = 0.0;                      ///< that a step may leave
  double time_limit_s = 100.0;                  ///< of the clock, for all of it
  std::optional<std::uint64_t> memory_bytes{};  ///< that a run may take
  std::filesystem::path folder;                 ///< is made; the runs go there
  const volatile std::sig_atomic_t* stop_flag = nullptr;
};

/// Tries each integrator on the motion, by find_step: explicit ones from nine tenths of the predicted bound
/// on, implicit ones from a twentieth of the duration down to twice that. What a step leaves of the motion is
/// bounded by
///
///   |u - v| + |u_h - v| / 3,   v explicit steps of h / 4 in double precision, u_h those of h,
///
/// each relative to v, over the whole time and all probes; where v would take more than two fifths of the
/// time, by 4/3 of the difference from the same integrator in steps of a quarter. Verified ones are run
/// three times. An integrator is not looked at any further once it is dearer than the cheapest that is
/// verified and its error still too large, or once a run of it takes more memory than there may be.
///
/// Returns: one a stepping, in their order. Throws: as simulate, but for what an integrator cannot take.
std::vector<SteppingTry> try_steppings(const SteppingTask& task, const std::vector<FitStepping>& steppings,
                                       const Registry& registry);

}  // namespace palpate::experiments
