// palpate envelope: how far a fitted model may be taken.
#pragma once

#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "experiments/envelope/envelope_axes.h"
#include "experiments/envelope/envelope_search.h"
#include "experiments/registry/registry.h"
#include "experiments/text/terminal.h"

namespace palpate::experiments {

struct EnvelopeOptions {
  std::filesystem::path folder;  ///< that palpate fit has written
  double time_limit_s = 1800.0;
  double resolution = kEnvelopeResolution;  ///< of each border
  const volatile std::sig_atomic_t* stop_flag = nullptr;
};

struct EnvelopeResult {
  double at_most = 0.0;   ///< tolerance of the error, the reference's own on top
  std::string measure;    ///< of the error at rest
  EnvelopePlace place;    ///< of the fitted scene; its step as it is run
  nlohmann::json model;   ///< of the fitted scene
  nlohmann::json scene;   ///< the fitted scene: what another is held against
  std::string mesh_hash;  ///< of organ.mesh
  EnvelopeProbe at_one;   ///< the scene as it is
  std::vector<EnvelopeAxis> axes;
  std::vector<EnvelopeBorder> borders;  ///< one an axis; none if it was stopped before the scene as it is
                                        ///< was looked at
  bool is_interrupted = false;
  double wall_s = 0.0;
};

/// Measures the border along each axis (envelope_axes.h). A place holds if
///
///   error at rest + the reference's own + what the step adds <= the fit's tolerance
///
/// and its motion is "completed". At rest: a case of the contest deform on the mesh that was fitted, at large
/// strain along "larger". What the step adds: 4/3 of the difference, over time and at 64 vertices spread over
/// the body, from the same motion in steps of a quarter (an integrator of order 1 leaves as much; one of
/// order 2 less). The step is that of the fitted scene, in seconds, along all axes but "step".
///
/// Throws: InputError for a folder that is no fit's with a choice or has an envelope, and as run_plan and
/// simulate.
EnvelopeResult run_envelope(const EnvelopeOptions& options, const Registry& registry, Progress& progress);

}  // namespace palpate::experiments
