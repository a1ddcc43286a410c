#include "experiments/scene_reader/scene_motion.h"

#include <algorithm>
#include <limits>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/mesh/geometry.h"
#include "core/mesh/topology.h"
#include "experiments/scene_reader/scene_problem.h"

namespace palpate::experiments {
namespace {

/// The scene with one of its loads alone, or with its clamps alone.
BoundaryProblem resolve_part(const Scene& placed, const TetMesh& mesh, const SceneLoad* load) {
  Scene part = placed;
  part.loads.clear();
  if (load != nullptr) {
    part.clamps.clear();
    part.loads.push_back(*load);
  }
  return resolve_problem(part, mesh);
}

/// Whether a step is solved by iterations: that of all implicit integrators but implicit_euler is.
bool iterates(const SceneDynamic& dynamic) {
  return !dynamic.is_exponential && dynamics::is_implicit(dynamic.integrator) &&
         dynamic.integrator != dynamics::IntegratorKind::kImplicitEuler;
}

/// The time up to which a profile has no share at all; infinite if it never has any.
double rises_at(const dynamics::TimeProfile& profile) {
  for (std::size_t k = 0; k < profile.share.size(); ++k) {
    if (profile.share[k] == 0.0) continue;
    return k == 0 ? -std::numeric_limits<double>::infinity() : profile.time_s[k - 1];
  }
  return std::numeric_limits<double>::infinity();
}

double longest_edge(const TetMesh& mesh) {
  double longest = 0.0;
  for (const Edge& edge : build_edges(mesh))
    longest = std::max(longest, length(mesh.points[edge[1]] - mesh.points[edge[0]]));
  return longest;
}

/// Of modes: what neither they nor their exact steps can take.
void check_modal(const Scene& scene) {
  const SceneDynamic& dynamic = scene.dynamic;
  const auto refuse = [&](const std::string& expected, const std::string& found) {
    throw InputError(scene.analysis_where + ": " + reference::kModalModel, 0, expected, found);
  };
  if (scene.strain == StrainSize::kLarge) refuse("small strain: modes are linear", "strain: large");
  if (!dynamic.is_exponential)
    refuse(std::string("integrator: ") + reference::kExponential + ", the exact steps of modes",
           dynamics::integrator_name(dynamic.integrator));
  if (!dynamic.time_step_s) refuse("time_step_s: a number of seconds, as no exact step is too long", "auto");
  if (dynamic.engine != reference::EngineChoice::kAuto || dynamic.single_precision)
    refuse("no engine and double precision", dynamic.single_precision
                                                 ? "precision: single"
                                                 : std::string("engine: ") + engine_name(dynamic.engine));
  if (dynamic.mass_per_vertex_kg) refuse("the material's masses", "mass_per_vertex_kg");
  if (dynamic.speed_limit_m_s) refuse("no speed limit", "speed_limit_m_s");
  if (dynamic.damping_spring_n_s_per_m > 0.0 || dynamic.damping_vertex_n_s_per_m > 0.0 ||
      dynamic.spring_damping != dynamics::SpringDamping::kAxial)
    refuse("damping by stiffness_s and mass_per_s", "damping of springs or vertices");
}

/// The scene's own model, without the options that only a static solution has.
reference::MovingModel read_moving_model(const Scene& scene, const Registry& registry) {
  const MethodEntry entry = find_model(scene, registry);
  reference::MovingModel model;
  model.method = scene.model->method;
  const bool is_modal = model.method == reference::kModalModel;
  if (!model.method.starts_with("springs.") && !model.method.starts_with("smoothed.") && !is_modal)
    throw InputError(scene.file.string() + ": model: " + model.method +
                     " solves static scenes alone; springs, smoothed models and " + reference::kModalModel +
                     " move");
  if (is_modal) check_modal(scene);
  if (scene.dynamic.is_exponential && !is_modal)
    throw InputError(scene.analysis_where + ": integrator", 0,
                     "one that steps " + model.method + "; " + reference::kExponential + " steps " +
                         reference::kModalModel + " alone",
                     reference::kExponential);
  model.options = resolve_options(*entry.method, scene.model->set);
  for (const char* key : kStaticOptions) {
    const auto given = scene.model->set.find(key);
    if (given != scene.model->set.end())
      throw InputError(given->second.where + ": " + key + " belongs to a static analysis");
    model.options.erase(key);
  }
  return model;
}

/// What the preset sets of the model and of the speed limit: Table 4.1, on this mesh.
void write_out_preset(const Scene& placed, const TetMesh& mesh, reference::MovingBody& body) {
  if (!placed.model) {
    body.model.method = "springs.uniform";
    body.model.options = {{"stiffness_n_per_m", ThesisTable::kStiffnessNPerM}};
    body.model.is_material = false;
  }
  body.model.options["volume"] = "thesis";
  body.model.options["volume_force_ratio"] = ThesisTable::kVolumeForceRatio;
  body.model.volume_force_of_n_per_m = ThesisTable::kStiffnessNPerM;
  body.stepping.speed_limit_m_s = ThesisTable::kSpeedLimit * 0.5 * longest_side(bounding_box(mesh.points));
}

}  // namespace

reference::MotionProblem build_motion_problem(const Scene& placed, const TetMesh& mesh) {
  require(placed.is_dynamic, "a dynamic scene");
  reference::MotionProblem problem;
  problem.body = resolve_part(placed, mesh, nullptr);
  for (const SceneLoad& load : placed.loads) {
    reference::MotionLoad part;
    part.part = resolve_part(placed, mesh, &load);
    part.profile = load.profile.value_or(dynamics::TimeProfile{});
    part.from_s = load.from_s;
    part.until_s = load.until_s;
    problem.loads.push_back(std::move(part));
  }
  problem.damping_stiffness_s = placed.dynamic.damping_stiffness_s;
  problem.damping_mass_per_s = placed.dynamic.damping_mass_per_s;
  problem.duration_s = placed.dynamic.duration_s;
  problem.samples = placed.dynamic.samples;
  for (const Vec3& probe : placed.dynamic.probes_m)
    problem.probes.push_back(nearest_point(mesh.points, probe));
  return problem;
}

std::vector<std::string> check_moving_scene(const Scene& placed, const TetMesh& mesh) {
  const SceneDynamic& dynamic = placed.dynamic;
  const std::string duration = short_number(dynamic.duration_s) + " s";
  if (dynamic.time_step_s && *dynamic.time_step_s > dynamic.duration_s)
    throw InputError(placed.analysis_where + ": time_step_s", 0, "at most the duration of " + duration,
                     short_number(*dynamic.time_step_s) + " s");
  const double longest = longest_edge(mesh);
  for (const Vec3& probe : dynamic.probes_m) {
    const double away = length(mesh.points[nearest_point(mesh.points, probe)] - probe);
    if (away > longest)
      throw InputError(placed.analysis_where + ": probes_m", 0, "points of the body",
                       "one whose nearest vertex is " + short_number(1000.0 * away) + " mm away");
  }
  std::vector<std::string> useless;
  for (const SceneLoad& load : placed.loads) {
    if (load.from_s >= dynamic.duration_s) {
      useless.push_back(load.where + ": this load begins at " + short_number(load.from_s) +
                        " s, and the motion ends at " + duration);
    } else if (load.profile && rises_at(*load.profile) >= dynamic.duration_s) {
      useless.push_back(load.where + ": this load's profile is 0 until the motion ends at " + duration);
    }
  }
  if (dynamic.has_safety && dynamic.time_step_s)
    useless.push_back(placed.analysis_where + ": safety has no use: time_step_s is given, and is no auto");
  if (placed.model && !placed.model->method.starts_with("springs.")) {
    const std::string none = " has no use: " + placed.model->method + " has no springs";
    if (dynamic.damping_spring_n_s_per_m > 0.0)
      useless.push_back(placed.analysis_where + ": damping: spring_n_s_per_m" + none);
    if (dynamic.spring_damping != dynamics::SpringDamping::kAxial)
      useless.push_back(placed.analysis_where + ": damping: springs" + none);
  }
  if (dynamic.has_solver && !iterates(dynamic))
    useless.push_back(placed.analysis_where + ": solver has no use: the integrator iterates nothing");
  const bool divides = dynamic.integrator == dynamics::IntegratorKind::kXpbd ||
                       dynamic.integrator == dynamics::IntegratorKind::kVbd;
  if (dynamic.substeps > 1 && iterates(dynamic) && !divides)
    useless.push_back(placed.analysis_where + ": substeps have no use but with xpbd and vbd");
  return useless;
}

reference::MovingBody build_moving_body(const Scene& placed, const TetMesh& mesh, const Registry& registry) {
  const bool is_preset = !placed.dynamic.preset.empty();
  Scene scene = placed;
  if (is_preset) scene.strain = StrainSize::kLarge;
  reference::MovingBody body;
  body.stepping = static_cast<const reference::MotionStepping&>(scene.dynamic);
  if (!is_preset || scene.model) body.model = read_moving_model(scene, registry);
  if (is_preset) write_out_preset(scene, mesh, body);
  body.motion = build_motion_problem(scene, mesh);
  return body;
}

}  // namespace palpate::experiments
