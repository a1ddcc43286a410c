#include "experiments/simulation/motion_setup.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>

#include "core/base/error.h"
#include "core/dynamics/spring_engine/plain_engine.h"
#include "core/mesh/geometry.h"
#include "experiments/scene_reader/scene_problem.h"
#include "experiments/text/terminal.h"
#include "reference/springs/model_request.h"

namespace palpate::experiments {
namespace {

using dynamics::IntegratorKind;
using dynamics::MotionModel;
using dynamics::StableStep;

constexpr std::size_t kMostVerticesForEigenvalues = 200'000;
constexpr double kMostSteps = 1e12;

double half_longest_side(const TetMesh& mesh) {
  const BoundingBox box = bounding_box(mesh.points);
  const Vec3 size = box.high - box.low;
  return 0.5 * std::max({size.x, size.y, size.z});
}

/// The model that moves: method, options and elastic model.
struct SceneElastic {
  std::string method;
  dynamics::BuiltModel built;
  reference::Response response;
};

/// The options of the scene's model, without those that only a static solution has.
nlohmann::json dynamic_options(const Scene& scene, const Registry& registry) {
  const MethodEntry entry = find_model(scene, registry);
  const std::string& method = scene.model->method;
  if (!method.starts_with("springs.") && !method.starts_with("smoothed."))
    throw InputError(scene.file.string() + ": model: " + method +
                     " solves static scenes alone; springs and smoothed models move");
  nlohmann::json options = resolve_options(*entry.method, scene.model->set);
  for (const char* key : {"load_steps", "max_iterations", "tolerance", "solver"}) {
    const auto given = scene.model->set.find(key);
    if (given != scene.model->set.end())
      throw InputError(given->second.where + ": " + key + " belongs to a static analysis");
    options.erase(key);
  }
  return options;
}

/// The volume force keeps Table 4.1's constant, whatever springs the scene has in the place of the table's.
void keep_table_volume_force(dynamics::ElasticModel& model) {
  const std::vector<double>& stiffness = model.springs.stiffness_n_per_m;
  const double mean =
      std::accumulate(stiffness.begin(), stiffness.end(), 0.0) / static_cast<double>(stiffness.size());
  if (mean > 0.0) model.volume_force->stiffness_n_per_m3 *= ThesisTable::kStiffnessNPerM / mean;
}

SceneElastic build_elastic(const Scene& scene, const TetMesh& mesh, const Registry& registry) {
  SceneElastic out;
  nlohmann::json options;
  StrainSize strain = scene.strain;
  const bool is_preset = !scene.dynamic.preset.empty();
  if (!is_preset || scene.model) {
    options = dynamic_options(scene, registry);
    out.method = scene.model->method;
  } else {
    out.method = "springs.uniform";
    options = {{"stiffness_n_per_m", ThesisTable::kStiffnessNPerM}};
  }
  if (is_preset) {
    strain = StrainSize::kLarge;
    options["volume"] = "thesis";
    options["volume_force_ratio"] = ThesisTable::kVolumeForceRatio;
  }
  const reference::ModelRequest wanted = reference::take_model_request(out.method, strain, options);
  require(options.empty(), "a model takes all of its options");
  out.built = reference::build_requested_model(mesh, scene.material, wanted, out.response);
  if (is_preset) keep_table_volume_force(out.built.model);
  return out;
}

/// The scene with some of its loads alone; `with_clamps` says whether the clamps are there.
dynamics::Loads loads_of(const Scene& placed, const TetMesh& mesh, const std::vector<std::size_t>& which,
                         bool with_clamps) {
  Scene part = placed;
  part.loads.clear();
  for (const std::size_t k : which) part.loads.push_back(placed.loads[k]);
  if (!with_clamps) part.clamps.clear();
  return dynamics::build_loads(mesh, resolve_problem(part, mesh));
}

MotionModel build_body(const Scene& scene, const TetMesh& mesh, dynamics::ElasticModel elastic) {
  const SceneDynamic& wanted = scene.dynamic;
  MotionModel model;
  model.tets = mesh.tets;
  model.elastic = std::move(elastic);
  model.mass_kg = wanted.mass_per_vertex_kg
                      ? std::vector<double>(mesh.points.size(), *wanted.mass_per_vertex_kg)
                      : dynamics::build_lumped_masses(mesh, scene.material.density_kg_m3);
  model.spring_damping = wanted.spring_damping;
  model.strain_damping_s = wanted.damping_stiffness_s;
  if (wanted.damping_stiffness_s > 0.0 || wanted.damping_spring_n_s_per_m > 0.0) {
    for (const double stiffness : model.elastic.springs.stiffness_n_per_m)
      model.spring_damping_n_s_per_m.push_back(wanted.damping_stiffness_s * stiffness +
                                               wanted.damping_spring_n_s_per_m);
  }
  if (wanted.damping_mass_per_s > 0.0 || wanted.damping_vertex_n_s_per_m > 0.0) {
    for (const double mass : model.mass_kg)
      model.environment_damping_n_s_per_m.push_back(wanted.damping_mass_per_s * mass +
                                                    wanted.damping_vertex_n_s_per_m);
  }
  return model;
}

bool is_there(const SceneLoad& load, double from_s, double to_s) {
  const double middle = 0.5 * (from_s + to_s);
  return load.from_s <= middle && (!load.until_s || *load.until_s >= middle);
}

/// The loads that a phase has, brought to the mesh: first what has no times with the clamps, then each tool.
MotionPhase build_phase(const Scene& placed, const TetMesh& mesh, const MotionModel& body, double from_s,
                        double to_s) {
  MotionPhase phase{body, {}, 0};
  std::vector<std::size_t> still;
  for (std::size_t k = 0; k < placed.loads.size(); ++k) {
    const SceneLoad& load = placed.loads[k];
    if (!is_there(load, from_s, to_s)) continue;
    (load.kind == SceneLoad::Kind::kGravity && !load.profile ? still : phase.loads).push_back(k);
  }
  phase.model.loads.push_back({loads_of(placed, mesh, still, true), {}});
  for (const std::size_t k : phase.loads)
    phase.model.loads.push_back(
        {loads_of(placed, mesh, {k}, false), placed.loads[k].profile.value_or(dynamics::TimeProfile{})});
  return phase;
}

/// The times at which loads come and go, from 0 to the end.
std::vector<double> phase_times(const Scene& scene) {
  std::set<double> times{0.0, scene.dynamic.duration_s};
  for (const SceneLoad& load : scene.loads) {
    for (const double time : {load.from_s, load.until_s.value_or(0.0)}) {
      if (time < scene.dynamic.duration_s) times.insert(time);
    }
  }
  return {times.begin(), times.end()};
}

bool is_implicit(IntegratorKind kind) {
  return kind == IntegratorKind::kImplicitEuler || kind == IntegratorKind::kPrefactored;
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

void choose_step(const Scene& scene, MotionSetup& setup) {
  const SceneDynamic& wanted = scene.dynamic;
  const std::string name = dynamics::integrator_name(setup.integrator.kind);
  const double bound = setup.stable.step_s;
  if (wanted.time_step_s) {
    setup.step_s = *wanted.time_step_s;
    if (setup.step_s > bound) {
      const std::string message = scene.analysis_where + ": a time step of " + short_number(setup.step_s) +
                                  " s is over the bound of " + name + " at rest, " + short_number(bound) +
                                  " s";
      if (!wanted.allow_unstable)
        throw InputError(message + "; \"allow_unstable: true\" takes it all the same");
      setup.notes.push_back(message);
    }
  } else {
    if (!std::isfinite(bound))
      throw InputError(scene.analysis_where + ": time_step_s: " + name +
                       " has no bound to take a step from; expected a number of seconds, found \"auto\"");
    if (!(bound > 0.0))
      throw InputError(scene.analysis_where + ": time_step_s: no step of " + name + " is stable here");
    setup.step_s = wanted.duration_s / std::ceil(wanted.duration_s / (wanted.safety * bound));
  }
  const double steps = std::ceil(wanted.duration_s / setup.step_s * (1.0 - 1e-12));
  if (!(steps <= kMostSteps))
    throw InputError(scene.analysis_where + ": expected at most 1e12 steps, found " +
                     short_number(wanted.duration_s / setup.step_s));
  setup.steps = static_cast<std::uint64_t>(steps);
}

/// Takes the plain engine where the scene allows and the body has no more than it takes.
void choose_engine(const Scene& scene, MotionSetup& setup) {
  const SceneDynamic& wanted = scene.dynamic;
  if (setup.integrator.kind != IntegratorKind::kSymplecticEuler)
    setup.why_general = dynamics::integrator_name(setup.integrator.kind);
  for (const MotionPhase& phase : setup.phases) {
    if (setup.why_general.empty()) setup.why_general = dynamics::find_more_than_plain(phase.model);
  }
  if (wanted.engine == EngineChoice::kPlain && !setup.why_general.empty())
    throw InputError(scene.analysis_where +
                     ": engine: the plain engine takes springs with axial damping at large strain, and "
                     "symplectic_euler; this scene has " +
                     setup.why_general);
  setup.is_plain = wanted.engine != EngineChoice::kGeneral && setup.why_general.empty();
  if (wanted.single_precision && !setup.is_plain)
    throw InputError(scene.analysis_where + ": precision: single is the plain engine's alone; this scene " +
                     (setup.why_general.empty() ? "asks for the general one" : "has " + setup.why_general));
  setup.single_precision = wanted.single_precision;
}

}  // namespace

MotionSetup build_motion(const Scene& placed, const TetMesh& mesh, const Registry& registry, int threads) {
  require(placed.is_dynamic, "a dynamic scene");
  SceneElastic elastic = build_elastic(placed, mesh, registry);
  MotionSetup setup;
  setup.method = elastic.method;
  setup.report = elastic.response.report;
  // A preset's own springs are not meant to be the scene's material; what they lack of it is no news.
  if (placed.dynamic.preset.empty() || placed.model) setup.notes = elastic.response.notes;
  const MotionModel body = build_body(placed, mesh, std::move(elastic.built.model));
  setup.integrator.kind = placed.dynamic.integrator;
  // Prefactored steps are to be solved here; contests ask what few iterations give.
  setup.integrator.iterations = 1000;
  setup.integrator.tolerance = 1e-8;
  setup.integrator.threads = threads;
  setup.integrator.linear.threads = threads;
  if (!placed.dynamic.preset.empty()) {
    setup.integrator.speed_limit_m_s = ThesisTable::kSpeedLimit * half_longest_side(mesh);
  } else {
    setup.integrator.speed_limit_m_s = placed.dynamic.speed_limit_m_s.value_or(0.0);
  }
  const std::vector<double> times = phase_times(placed);
  for (std::size_t k = 0; k + 1 < times.size(); ++k) {
    setup.phases.push_back(build_phase(placed, mesh, body, times[k], times[k + 1]));
    try {
      validate(setup.phases.back().model);
    } catch (const InputError& error) {
      throw InputError(placed.file.string() + ": from " + short_number(times[k]) + " s: " + error.what());
    }
  }
  choose_engine(placed, setup);
  find_bound(setup.phases, mesh.points.size(), threads, setup);
  choose_step(placed, setup);
  for (std::size_t k = 0; k < setup.phases.size(); ++k) {
    const double end = times[k + 1] / setup.step_s;
    setup.phases[k].last_step = k + 1 == setup.phases.size()
                                    ? setup.steps
                                    : std::min(setup.steps, static_cast<std::uint64_t>(std::llround(end)));
  }
  return setup;
}

}  // namespace palpate::experiments
