#include "reference/engine/motion_setup.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <span>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/dynamics/motion/frozen_part.h"
#include "core/dynamics/spring_engine/plain_engine.h"
#include "core/dynamics/tet_engine/tet_engine.h"
#include "reference/door/request_options.h"
#include "reference/elastic_models/model_request.h"
#include "reference/elastic_models/stepped_motion.h"
#include "reference/linear_systems/factor.h"

namespace palpate::reference {
namespace {

using dynamics::IntegratorKind;
using dynamics::MotionModel;
using dynamics::StableStep;

constexpr std::size_t kMostVerticesForEigenvalues = 200'000;
constexpr double kMostSteps = 1e12;

/// The volume force keeps the stiffness that is asked for, whatever springs the model has.
void scale_volume_force(double stiffness_n_per_m, dynamics::ElasticModel& model) {
  if (!model.volume_force)
    throw InputError("model", 0, "a volume force beside volume_force_of_n_per_m", "none");
  const std::vector<double>& stiffness = model.springs.stiffness_n_per_m;
  const double mean =
      std::accumulate(stiffness.begin(), stiffness.end(), 0.0) / static_cast<double>(stiffness.size());
  if (mean > 0.0) model.volume_force->stiffness_n_per_m3 *= stiffness_n_per_m / mean;
}

/// Gravity that is there as it is, and nothing else: it belongs to the body's own group of loads.
bool is_weight(const MotionLoad& load) {
  const BoundaryProblem& part = load.part;
  const bool is_steady = !load.profile.smooth && load.profile.time_s == std::vector<double>{0.0} &&
                         load.profile.share == std::vector<double>{1.0};
  return is_steady && !load.is_tool() && part.tractions.empty() && part.nodal_forces.empty() &&
         part.body_force_n_m3.empty();
}

/// The loads that a phase has: first what holds the body, with its weight; then each other load by itself.
MotionPhase build_phase(const MovingBody& body, const TetMesh& mesh, const MotionModel& free_body,
                        const LoadPhase& time, std::span<const Index> frozen) {
  MotionPhase phase{free_body, {}, 0};
  BoundaryProblem own = body.motion.body;
  for (const std::size_t k : time.loads) {
    const MotionLoad& load = body.motion.loads[k];
    if (is_weight(load)) {
      own.gravity_m_s2 = own.gravity_m_s2 + load.part.gravity_m_s2;
    } else {
      phase.loads.push_back(k);
    }
  }
  phase.model.loads.push_back({dynamics::build_loads(mesh, own), {}});
  dynamics::hold_frozen(frozen, phase.model.loads.back().loads);
  for (const std::size_t k : phase.loads) {
    const MotionLoad& load = body.motion.loads[k];
    phase.model.loads.push_back({dynamics::build_loads(mesh, load.part), load.profile});
  }
  return phase;
}

void find_bound(const std::vector<MotionPhase>& phases, std::size_t vertices, int threads,
                MotionSetup& setup) {
  setup.stable.step_s = std::numeric_limits<double>::infinity();
  setup.stable_by = "none_needed";
  if (is_implicit(setup.integrator.kind)) return;
  setup.stable_by = vertices <= kMostVerticesForEigenvalues ? "eigenvalues" : "row_sums";
  std::set<std::vector<std::size_t>> seen;
  for (const MotionPhase& phase : phases) {
    if (!seen.insert(phase.loads).second) continue;
    StableStep bound;
    bool is_found = false;
    if (vertices <= kMostVerticesForEigenvalues) {
      bound = dynamics::predict_stable_step(phase.model, setup.integrator.kind, threads);
      is_found = bound.converged;
    }
    if (!is_found) {
      bound = dynamics::bound_stable_step(phase.model, setup.integrator.kind);
      setup.stable_by = "row_sums";
    }
    if (bound.step_s < setup.stable.step_s) setup.stable = bound;
  }
}

void choose_step(const MovingBody& body, MotionSetup& setup) {
  const MotionStepping& wanted = body.stepping;
  const double duration_s = body.motion.duration_s;
  const std::string name = dynamics::integrator_name(setup.integrator.kind);
  const double bound = setup.stable.step_s;
  if (wanted.time_step_s) {
    setup.step_s = *wanted.time_step_s;
    if (setup.step_s > bound) {
      const std::string message = "a time step of " + short_number(setup.step_s) +
                                  " s is over the bound of " + name + " at rest, " + short_number(bound) +
                                  " s";
      if (!wanted.allow_unstable)
        throw InputError(message + "; \"allow_unstable: true\" takes it all the same");
      setup.notes.push_back(message);
    }
  } else {
    if (!std::isfinite(bound))
      throw InputError("time_step_s: " + name +
                       " has no bound to take a step from; expected a number of seconds, found \"auto\"");
    if (!(bound > 0.0)) throw InputError(std::string("time_step_s: no step of ") + name + " is stable here");
    setup.step_s = duration_s / std::ceil(duration_s / (wanted.safety * bound));
  }
  const double steps = std::ceil(duration_s / setup.step_s * (1.0 - 1e-12));
  if (!(steps <= kMostSteps))
    throw InputError("expected at most 1e12 steps, found " + short_number(duration_s / setup.step_s));
  setup.steps = static_cast<std::uint64_t>(steps);
}

/// What of a body an engine cannot take, or an empty string. `find_more` asks for one model.
template <typename FindMore>
std::string find_obstacle(const MotionSetup& setup, const FindMore& find_more) {
  if (setup.integrator.kind != IntegratorKind::kSymplecticEuler)
    return dynamics::integrator_name(setup.integrator.kind);
  for (const MotionPhase& phase : setup.phases) {
    std::string what = find_more(phase.model);
    if (!what.empty()) return what;
  }
  return "";
}

/// Takes the plain engine or the tet engine where the body allows and has no more than it takes.
void choose_engine(const MotionStepping& wanted, MotionSetup& setup) {
  const std::string why_not_plain = find_obstacle(setup, dynamics::find_more_than_plain);
  const std::string why_not_tets = find_obstacle(setup, dynamics::find_more_than_tets);
  if (wanted.engine == EngineChoice::kPlain && !why_not_plain.empty())
    throw InputError(
        "engine: the plain engine takes springs with axial damping at large strain, and "
        "symplectic_euler; this body has " +
        why_not_plain);
  if (wanted.engine == EngineChoice::kTets && !why_not_tets.empty())
    throw InputError(
        "engine: the tet engine takes strain energies without springs, and symplectic_euler; this "
        "body has " +
        why_not_tets);
  setup.engine = wanted.engine;
  if (wanted.engine == EngineChoice::kAuto) {
    setup.engine = EngineChoice::kGeneral;
    if (why_not_tets.empty()) setup.engine = EngineChoice::kTets;
    if (why_not_plain.empty()) setup.engine = EngineChoice::kPlain;
  }
  if (!why_not_tets.empty()) setup.why_general = why_not_plain;
  if (wanted.single_precision && setup.engine == EngineChoice::kGeneral)
    throw InputError("precision: single is for the plain engine and the tet engine; this body " +
                     (setup.why_general.empty() ? "asks for the general one" : "has " + setup.why_general));
  setup.single_precision = wanted.single_precision;
}

}  // namespace

std::vector<std::string> list_laws(const dynamics::ElasticModel& model) {
  std::vector<std::string> laws;
  for (const dynamics::StrainTerm& term : model.strain_terms) {
    const std::string law = dynamics::strain_law_name(term.law);
    if (std::find(laws.begin(), laws.end(), law) == laws.end()) laws.push_back(law);
  }
  return laws;
}

dynamics::ElasticModel build_elastic(const MovingBody& body, const TetMesh& mesh, Response& response) {
  if (body.model.method == kModalModel || body.stepping.is_exponential)
    throw InputError("model", 0, "springs.NAME or smoothed.NAME: modes are stepped by reduced.modal_replay",
                     body.model.method);
  nlohmann::json left = body.model.options;
  const StrainSize strain = body.motion.body.strain;
  const ModelRequest wanted = take_model_request(body.model.method, strain, left);
  require_all_taken(left);
  dynamics::BuiltModel built = build_requested_model(mesh, body.motion.body.material, wanted, response);
  if (body.model.volume_force_of_n_per_m)
    scale_volume_force(*body.model.volume_force_of_n_per_m, built.model);
  return std::move(built.model);
}

MotionModel build_free_body(const MovingBody& body, const TetMesh& mesh, dynamics::ElasticModel elastic) {
  const MotionStepping& own = body.stepping;
  MotionModel model;
  model.tets = mesh.tets;
  model.elastic = std::move(elastic);
  model.mass_kg = own.mass_per_vertex_kg
                      ? std::vector<double>(mesh.points.size(), *own.mass_per_vertex_kg)
                      : dynamics::build_lumped_masses(mesh, body.motion.body.material.density_kg_m3);
  model.spring_damping = own.spring_damping;
  set_damping({body.motion.damping_stiffness_s, body.motion.damping_mass_per_s, own.damping_spring_n_s_per_m,
               own.damping_vertex_n_s_per_m},
              model);
  return model;
}

MotionSetup build_motion(const MovingBody& body, const TetMesh& mesh, int threads) {
  MotionSetup setup;
  Response made;
  const MotionModel free_body = build_free_body(body, mesh, build_elastic(body, mesh, made));
  nlohmann::json options = body.model.options;
  setup.frozen = read_frozen(take_model_request(body.model.method, body.motion.body.strain, options), mesh);
  setup.method = body.model.method;
  setup.report = made.report;
  if (body.model.is_material) setup.notes = made.notes;
  setup.integrator.kind = body.stepping.integrator;
  setup.integrator.solver = body.stepping.solver;
  setup.integrator.substeps = body.stepping.substeps;
  setup.integrator.threads = threads;
  setup.integrator.linear.threads = threads;
  setup.integrator.linear.factor = choose_factor("auto");
  setup.integrator.speed_limit_m_s = body.stepping.speed_limit_m_s.value_or(0.0);
  const std::vector<LoadPhase> times = find_phases(body.motion);
  for (const LoadPhase& time : times) {
    setup.phases.push_back(build_phase(body, mesh, free_body, time, setup.frozen));
    try {
      validate(setup.phases.back().model);
    } catch (const InputError& error) {
      throw InputError("from " + short_number(time.from_s) + " s: " + error.what());
    }
  }
  choose_engine(body.stepping, setup);
  find_bound(setup.phases, mesh.points.size(), threads, setup);
  choose_step(body, setup);
  for (std::size_t k = 0; k < setup.phases.size(); ++k) {
    const double end = times[k].to_s / setup.step_s;
    setup.phases[k].last_step = k + 1 == setup.phases.size()
                                    ? setup.steps
                                    : std::min(setup.steps, static_cast<std::uint64_t>(std::llround(end)));
  }
  return setup;
}

}  // namespace palpate::reference
