#include "experiments/contests/motion/motion_input.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/mesh/geometry.h"
#include "experiments/contestants/solution.h"
#include "experiments/contests/simplified_mesh.h"
#include "experiments/files/output_file.h"
#include "experiments/scene_reader/scene_motion.h"
#include "experiments/scene_reader/scene_problem.h"
#include "experiments/scene_reader/swept_scene.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;
using reference::MotionLoad;
using reference::MotionProblem;

constexpr double kMotionTimeout = 14400.0;  // s

/// What the door has no words for.
void check_scene(const Scene& scene) {
  const SceneDynamic& dynamic = scene.dynamic;
  const auto refuse = [&](const std::string& what) {
    throw InputError(scene.analysis_where + ": the contest motion takes " + what);
  };
  if (!dynamic.preset.empty()) refuse("no preset");
  if (scene.strain != StrainSize::kSmall) refuse("small strain, as its reference has it");
  if (dynamic.damping_spring_n_s_per_m > 0.0 || dynamic.damping_vertex_n_s_per_m > 0.0)
    refuse("damping by stiffness_s and mass_per_s, which all contestants can have");
  if (dynamic.spring_damping != dynamics::SpringDamping::kAxial) refuse("axial damping of springs");
  if (dynamic.mass_per_vertex_kg) refuse("the material's masses");
  if (dynamic.speed_limit_m_s) refuse("no speed limit");
  if (dynamic.probes_m.empty()) refuse("at least one of probes_m");
}

/// One solution of the reference.
struct ReferenceRun {
  int refine = 0;
  double time_step_s = 0.0;
};

/// Solves it. What goes wrong is put into `reference`.
JudgedMotion solve_run(const MotionInput& input, const ReferenceRun& run, const ContestSetting& setting,
                       MotionReference& reference, fs::path& file) {
  const PlanReference& plan = *setting.plan.reference;
  ContestantTask task = start_task(plan.method, input.files.mesh_file, setting);
  task.problem_in = input.files.problem_file;
  task.options = resolve_options(*task.method.method, plan.set);
  task.options["refine"] = run.refine;
  task.options["time_step_s"] = run.time_step_s;
  task.timeout_s = kMotionTimeout;
  const Solution solution = solve(task, "completed");
  const std::string which = "the reference at level " + std::to_string(run.refine) + " ";
  const auto fail = [&](const std::string& outcome, const std::string& why) {
    reference.outcome = outcome;
    reference.failure = which + why;
    return JudgedMotion{};
  };
  reference.interrupted = solution.interrupted;
  if (solution.interrupted) return {};
  if (solution.answer.outcome == "ok") reference.runs.push_back(describe_solution(solution, run.refine));
  if (!solution.failure.empty()) return fail(solution.outcome, solution.failure);
  const ContestantAnswer& answer = solution.answer;
  try {
    file = answer.output;
    return {reference::read_history(answer.output, input.problem),
            answer.report.at("frequencies_hz").get<std::vector<double>>()};
  } catch (const InputError& error) {
    return fail("bad_answer", std::string("cannot be read: ") + error.what());
  }
}

/// Adds `factor` times the size of each error in `errors` to `own`.
void add_errors(const json& errors, double factor, json& own) {
  for (const char* name :
       {"frequency_first", "frequency_mean", "frequency_worst", "probe_l2", "force_l2", "amplitude_error",
        "phase_error_deg", "oscillation_error", "damping_ratio_error", "decay_error"}) {
    if (errors.contains(name))
      own[name] = own.value(name, 0.0) + factor * std::fabs(errors.at(name).get<double>());
  }
}

/// Histories are compared probe by probe: each has to be the same point of the body.
void check_probes(const MotionInput& whole, const MotionInput& simplified) {
  constexpr double kSamePoint = 1e-6;  // of the longest side
  const double most = kSamePoint * longest_side(bounding_box(whole.files.mesh.points));
  for (std::size_t k = 0; k < whole.problem.probes.size(); ++k) {
    const Vec3& there = whole.files.mesh.points[whole.problem.probes[k]];
    const double off = length(simplified.files.mesh.points[simplified.problem.probes[k]] - there);
    if (off > most)
      throw InputError("probe " + std::to_string(k) + " has no vertex left: the nearest is " +
                       short_number(1e3 * off) + " mm away");
  }
}

}  // namespace

MotionProblem build_compared_problem(const Scene& placed, const TetMesh& mesh) {
  check_scene(placed);
  MotionProblem problem = build_motion_problem(placed, mesh);
  problem.frequencies = kComparedFrequencies;
  return problem;
}

std::array<double, 2> judging_window(const MotionProblem& problem) {
  constexpr double kLeastShare = 0.2;
  const double end = problem.duration_s;
  double last = 0.0;
  for (const MotionLoad& load : problem.loads) {
    const double gone = load.until_s.value_or(end);
    last = std::max(last, load.from_s);
    if (load.until_s && *load.until_s < end) last = std::max(last, *load.until_s);
    if (load.profile.time_s.size() > 1)
      last = std::max(last, std::min({load.profile.time_s.back(), gone, end}));
  }
  return {end - last >= kLeastShare * end ? last : 0.5 * end, end};
}

MotionInput build_motion_input(const PlanScene& scene, const json& sweep, const fs::path& folder) {
  MotionInput input;
  input.scene = scene.name;
  input.sweep = problem_sweep(sweep);
  input.id = problem_id(scene.name, sweep);
  SweptScene swept = place_swept_scene(scene.scene, input.sweep);
  input.files.mesh = std::move(swept.mesh);
  input.placed = std::move(swept.placed);
  input.problem = build_compared_problem(input.placed, input.files.mesh);
  write_problem(input.files, reference::motion_to_json(input.problem), folder);
  return input;
}

MotionInput simplify_motion_input(const MotionInput& whole, const Case& run_case, const std::string& id,
                                  const ContestSetting& setting) {
  const PlanContestant& simplifier = setting.plan.simplifiers[*run_case.simplifier];
  const fs::path folder = setting.folder.paths().problem(id);
  SimplifiedMesh made =
      simplify_mesh(whole.files.mesh, simplifier, run_case.simplifier_stop, folder, setting);
  MotionInput input;
  input.id = id;
  input.scene = whole.scene;
  input.sweep = whole.sweep;
  input.failure = made.failure;
  input.simplify_s = made.kernel_s;
  if (!input.failure.empty()) return input;
  input.files.mesh = std::move(made.mesh);
  try {
    input.problem = build_compared_problem(on_whole(whole.placed, whole.files.mesh), input.files.mesh);
    check_probes(whole, input);
    write_problem(input.files, reference::motion_to_json(input.problem), folder);
  } catch (const InputError& error) {
    input.failure = "on the mesh of " + simplifier.label + ": " + error.what();
  }
  return input;
}

OwnLimit solve_own_limit(const MotionInput& input, const Case& run_case, const ContestSetting& setting) {
  const PlanContestant& contestant = setting.plan.contestants[run_case.contestant];
  ContestantTask task = start_task(contestant.method, input.files.mesh_file, setting);
  task.problem_in = input.files.problem_file;
  task.options = run_case.options;
  const json over = resolve_options(*task.method.method, contestant.own_limit);
  for (const auto& [name, given] : contestant.own_limit) task.options[name] = over.at(name);
  task.timeout_s = kMotionTimeout;
  const Solution solution = solve(task, "completed");
  OwnLimit limit;
  limit.interrupted = solution.interrupted;
  limit.failure = solution.failure;
  if (solution.interrupted || !solution.failure.empty()) return limit;
  limit.run = describe_solution(solution, 0);
  try {
    limit.history = reference::read_history(solution.answer.output, input.problem);
  } catch (const InputError& error) {
    limit.failure = std::string("cannot be read: ") + error.what();
  }
  return limit;
}

MotionReference solve_motion_reference(const MotionInput& input, const ContestSetting& setting) {
  const PlanReference& plan = *setting.plan.reference;
  const json options = resolve_options(*setting.registry.find(plan.method)->method, plan.set);
  const double step = options.at("time_step_s").get<double>();
  const int coarse = plan.levels - 2;
  MotionReference reference;
  fs::path file;
  fs::path ignored;
  reference.truth = solve_run(input, {plan.levels - 1, step}, setting, reference, file);
  const auto ended = [&] { return reference.interrupted || !reference.failure.empty(); };
  if (ended()) return reference;
  reference.history_file = setting.folder.paths().history(input.id + "/reference");
  create_folder(reference.history_file.parent_path());
  reference::write_history(reference.history_file, reference.truth.history);
  const JudgedMotion coarser = solve_run(input, {coarse, step}, setting, reference, ignored);
  if (ended()) return reference;
  const double of_space = plan.stated_order ? 1.0 / (std::exp2(*plan.stated_order) - 1.0) : 1.0;
  add_errors(compare_motions(input.problem, coarser, reference.truth), of_space, reference.own_error);
  const JudgedMotion slower = solve_run(input, {coarse, 2.0 * step}, setting, reference, ignored);
  if (ended()) return reference;
  add_errors(compare_motions(input.problem, slower, coarser), 1.0 / 3.0, reference.own_error);
  return reference;
}

}  // namespace palpate::experiments
