#include "reference/springs/motion_phases.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/stopwatch.h"
#include "reference/elastic_models/stepped_motion.h"

namespace palpate::reference {
namespace {

using dynamics::MotionModel;

MotionModel build_body(const TetMesh& mesh, const MotionProblem& problem,
                       const dynamics::ElasticModel& elastic) {
  MotionModel model;
  if (problem.body.strain == StrainSize::kLarge) model.tets = mesh.tets;
  model.elastic = elastic;
  model.mass_kg = dynamics::build_lumped_masses(mesh, problem.body.material.density_kg_m3);
  return model;
}

/// The first mode's shape decides what constants do.
dynamics::ModeShares measure_first(const MotionModel& model, const dynamics::NaturalModes& modes) {
  require(!modes.modes.empty(), "a first mode to damp");
  return measure_mode(model, modes.modes.front());
}

double quotient(double of, double by) {
  if (!(by > 1e-12 * of) || !std::isfinite(of / by))
    throw InputError("damping", 0, "a first mode that strains springs", "one that moves as a rigid body");
  return of / by;
}

}  // namespace

MovingPhases build_phases(const TetMesh& mesh, const MotionProblem& problem,
                          const dynamics::ElasticModel& elastic, DampingModel damping) {
  MovingPhases made;
  const MotionModel body = build_body(mesh, problem, elastic);
  for (const LoadPhase& time : find_phases(problem)) {
    MovingPhase phase{time, body};
    phase.model.loads.push_back({dynamics::build_loads(mesh, problem.body), {}});
    for (const std::size_t k : time.loads) {
      const MotionLoad& load = problem.loads[k];
      phase.model.loads.push_back({dynamics::build_loads(mesh, load.part), load.profile});
    }
    validate(phase.model);
    made.phases.push_back(std::move(phase));
  }
  const bool matches = damping != DampingModel::kRayleigh;
  const std::size_t modes = std::max<std::size_t>(problem.frequencies, matches ? 1 : 0);
  if (modes > 0) {
    const Stopwatch watch;
    made.modes = find_lowest_modes(made.phases.back().model, modes);
    made.modes_s = watch.seconds();
    if (!made.modes.converged) throw UnavailableError("the lowest frequencies did not converge");
  }
  DampingShares shares{problem.damping_stiffness_s, problem.damping_mass_per_s};
  if (damping == DampingModel::kSprings) {
    if (elastic.springs.springs.empty())
      throw InputError("damping", 0, "rayleigh or vertices for a model without springs", "springs");
    const dynamics::ModeShares first = measure_first(made.phases.back().model, made.modes);
    if (problem.damping_stiffness_s > 0.0)
      made.spring_damping_n_s_per_m = quotient(problem.damping_stiffness_s * first.stiffness, first.springs);
    shares = {0.0, problem.damping_mass_per_s, made.spring_damping_n_s_per_m};
  } else if (damping == DampingModel::kVertices) {
    const dynamics::ModeShares first = measure_first(made.phases.back().model, made.modes);
    made.vertex_damping_n_s_per_m =
        (problem.damping_stiffness_s * first.stiffness + problem.damping_mass_per_s) / first.vertices;
    shares = {0.0, 0.0, 0.0, made.vertex_damping_n_s_per_m};
  }
  for (MovingPhase& phase : made.phases) set_damping(shares, phase.model);
  made.modes.frequency_hz.resize(problem.frequencies);
  return made;
}

}  // namespace palpate::reference
