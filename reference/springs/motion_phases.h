// A motion problem as bodies that move, phase by phase.
#pragma once

#include <string>
#include <vector>

#include "core/dynamics/integrators/integrator.h"
#include "core/dynamics/motion/motion_model.h"
#include "core/dynamics/stability/lowest_modes.h"
#include "reference/door/motion_problem.h"

namespace palpate::reference {

/// How a body of springs is damped.
///
///   kRayleigh  stiffness_s x k along each spring and of each strain term, mass_per_s x m at each vertex
///   kSprings   one constant c for all springs, mass_per_s x m at each vertex: c damps the first mode as much
///              as stiffness_s would
///   kVertices  one constant for all vertices, and nothing else: it damps the first mode as much as both
///   would
enum class DampingModel { kRayleigh, kSprings, kVertices };

/// A stretch of time in which the same loads are there.
struct MovingPhase {
  LoadPhase time;
  dynamics::MotionModel model;  ///< group 0 of its loads holds the body, group k + 1 is time.loads[k]
};

/// What was made of a problem.
struct MovingPhases {
  std::vector<MovingPhase> phases;
  double spring_damping_n_s_per_m = 0.0;  ///< kSprings: of each spring
  double vertex_damping_n_s_per_m = 0.0;  ///< kVertices: of each vertex
  dynamics::NaturalModes modes;           ///< of the last phase, as many as were asked for
  double modes_s = 0.0;                   ///< time to find them
};

/// Puts masses (a quarter of each tet's at its vertices), damping and loads to a model. Throws: InputError if
/// two loads hold the same, if kSprings meets a model without springs, or if the first mode cannot be damped
/// so (it is a rigid motion).
MovingPhases build_phases(const TetMesh& mesh, const MotionProblem& problem,
                          const dynamics::ElasticModel& elastic, DampingModel damping);

}  // namespace palpate::reference
