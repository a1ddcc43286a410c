// A moving body on its mesh: models in motion, phase by phase, and the time step that they take.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/dynamics/motion/motion_model.h"
#include "core/dynamics/stability/stability.h"
#include "reference/door/moving_body.h"

namespace palpate::reference {

/// A stretch of time in which the same loads are there. Where a load ends, its held vertices are let go.
struct MotionPhase {
  dynamics::MotionModel model;
  std::vector<std::size_t> loads;  ///< of each group but the first: its place in the body's list of loads
  std::uint64_t last_step = 0;     ///< steps from the start of the motion to the end of the phase
};

/// What is to be run.
struct MotionSetup {
  std::string method;  ///< "springs.uniform"
  std::vector<MotionPhase> phases;
  std::vector<Index> frozen;  ///< held at rest throughout
  dynamics::IntegratorOptions integrator;
  EngineChoice engine = EngineChoice::kGeneral;  ///< what steps it; never kAuto
  std::string why_general;        ///< what of it a faster engine cannot take; empty if one can take all
  bool single_precision = false;  ///< kPlain and kTets alone
  double step_s = 0.0;
  std::uint64_t steps = 0;
  dynamics::StableStep stable;  ///< the shortest of the phases' bounds
  std::string stable_by;        ///< "eigenvalues" or "row_sums"; "none_needed" for the implicit ones
  nlohmann::json report;        ///< of the model
  std::vector<std::string> notes;
};

/// The laws of a model's strain energies by name, each once, in order.
std::vector<std::string> list_laws(const dynamics::ElasticModel& model);

/// The elastic model that a body asks for. The report and the notes are those of build_requested_model.
/// Throws: InputError for an option that the model does not take, and as build_requested_model does.
dynamics::ElasticModel build_elastic(const MovingBody& body, const TetMesh& mesh, Response& response);

/// The body without loads: elastic model, masses and damping.
dynamics::MotionModel build_free_body(const MovingBody& body, const TetMesh& mesh,
                                      dynamics::ElasticModel elastic);

/// Builds model, masses, damping and phases, and chooses or checks the time step.
///
/// A made step is the predicted bound times `safety`, shortened so that whole steps fill the duration. A
/// given one over the bound is refused with the bound, unless the body allows it: then a note says so. The
/// bound is that of eigenvalues up to 200,000 vertices, of row sums beyond or where the eigenvalues don't
/// converge.
///
/// Throws: InputError for what cannot be stepped so, UnavailableError as the model does.
MotionSetup build_motion(const MovingBody& body, const TetMesh& mesh, int threads);

}  // namespace palpate::reference
