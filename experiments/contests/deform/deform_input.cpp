#include "experiments/contests/deform/deform_input.h"

#include <algorithm>
#include <cmath>

#include "core/base/atomic_file.h"
#include "core/base/error.h"
#include "core/mesh/topology.h"
#include "experiments/contestants/solution.h"
#include "experiments/contests/pad_force.h"
#include "experiments/contests/simplified_mesh.h"
#include "experiments/files/file_hash.h"
#include "experiments/files/output_file.h"
#include "experiments/meshes/mesh_source.h"
#include "experiments/scene_reader/scene_problem.h"
#include "experiments/scene_reader/swept_scene.h"
#include "reference/door/deform_problem.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

constexpr int kLevelsOfAll = 2;  // that every reference has

void fail(DeformReference& reference, const std::string& outcome, const std::string& why) {
  reference.outcome = outcome;
  reference.failure = why;
}

Vec3 read_force(const json& force) {
  const bool is_vector = force.is_array() && force.size() == 3 && force[0].is_number() &&
                         force[1].is_number() && force[2].is_number();
  if (!is_vector) throw InputError("support_forces_n", 0, "three finite numbers a support", force.dump());
  return {force[0].get<double>(), force[1].get<double>(), force[2].get<double>()};
}

/// The pads' forces of a level, as its report has them: integrated on its own mesh, which no other has. The
/// order is at least 1 (twice that of the energy norm), so a level is no farther off than the one before is
/// from it.
void add_pad_force(const DeformInput& input, const json& report, DeformReference& reference) {
  const std::vector<ElasticSupport>& supports = input.own.problem.supports;
  if (!report.contains("support_forces_n") || report.at("support_forces_n").size() != supports.size()) return;
  std::vector<Vec3> now;
  for (std::size_t k = 0; k < supports.size(); ++k) {
    if (!is_moved(supports[k])) continue;
    now.push_back(read_force(report.at("support_forces_n").at(k)));
  }
  if (!reference.pad_force_n.empty())
    reference.pad_force_error = relative_force_error(reference.pad_force_n, now);
  reference.pad_force_n = std::move(now);
}

/// The displacement of one level at the vertices and edge midpoints of the problem's own mesh. What goes
/// wrong is put into `reference`.
std::vector<Vec3> solve_level(const DeformInput& input, int level, const ContestSetting& setting,
                              std::span<const fs::path> companions, DeformReference& reference) {
  const PlanReference& plan = *setting.plan.reference;
  ContestantTask task = start_task(plan.method, input.own.mesh_file, setting);
  task.problem_in = input.own.problem_file;
  task.options = resolve_options(*task.method.method, plan.set);
  task.options["refine"] = level;
  task.timeout_s = kReferenceTimeout;
  const Solution solution = solve(task, "converged", companions);
  const std::string which = "level " + std::to_string(level) + " of the reference ";
  reference.interrupted = solution.interrupted;
  if (solution.interrupted) return {};
  if (solution.answer.outcome == "ok") reference.levels.push_back(describe_solution(solution, level));
  if (!solution.failure.empty()) {
    fail(reference, solution.outcome, which + solution.failure);
    return {};
  }
  const ContestantAnswer& answer = solution.answer;
  const std::size_t vertices = input.own.mesh.points.size();
  try {
    add_pad_force(input, answer.report, reference);
    return judge::with_midpoints(
        input.own.mesh,
        reference::read_displacement(answer.output, vertices, build_edges(input.own.mesh).size()));
  } catch (const InputError& error) {
    fail(reference, "bad_answer", which + "cannot be read: " + error.what());
    return {};
  }
}

/// Fills in what is judged by from the levels so far, coarsest first. Throws: InputError where they judge
/// nothing.
void estimate_from(const DeformInput& input, const PlanReference& plan,
                   const std::vector<std::vector<Vec3>>& levels, DeformReference& reference) {
  const Material& material = input.own.problem.material;
  const std::size_t vertices = input.own.mesh.points.size();
  std::vector<std::vector<Vec3>> at_vertices = levels;
  for (std::vector<Vec3>& level : at_vertices) level.resize(vertices);
  const auto estimate = [&](std::span<const std::vector<Vec3>> given,
                            const std::optional<judge::ChosenPoints>& chosen) {
    return judge::estimate_reference(input.own.mesh, given, material.lambda_pa(), material.mu_pa(),
                                     {plan.stated_order, chosen});
  };
  reference.estimate = estimate(at_vertices, input.chosen);
  const std::vector<Vec3>& field = reference.estimate.field;
  if (input.chosen)
    judge::compare_chosen(input.own.mesh, field, field, *input.chosen);  // does it move there?
  const judge::ReferenceEstimate whole = estimate(levels, std::nullopt);
  reference.whole_energy = whole.error.relative_energy;
  reference.field = reference.estimate.field;
  reference.field.insert(reference.field.end(), whole.field.begin() + static_cast<std::ptrdiff_t>(vertices),
                         whole.field.end());
}

/// Where the scene's requirement asks for its error: the vertices of regions by their volume, those of probes
/// alike.
std::optional<judge::ChosenPoints> choose_points(const Scene& placed, const TetMesh& mesh) {
  if (!placed.require || placed.require->places.empty()) return std::nullopt;
  judge::ChosenPoints chosen;
  chosen.vertex = find_error_points(*placed.require, mesh);
  const bool are_probes = placed.require->places.front().probe.has_value();
  const std::vector<double> share = judge::volume_shares(mesh, mesh.points.size());
  for (const std::size_t vertex : chosen.vertex) chosen.weight.push_back(are_probes ? 1.0 : share[vertex]);
  return chosen;
}

/// Whether no further level is asked for: the reference is good enough, and so it is where a scene asks for
/// its error.
bool is_enough(const DeformInput& input, const PlanReference& plan, const judge::ReferenceError& error) {
  if (!plan.enough || !error.relative_l2 || *error.relative_l2 > *plan.enough) return false;
  if (!input.chosen) return true;
  return error.chosen_l2 && *error.chosen_l2 <= *plan.enough && error.chosen_deformation &&
         *error.chosen_deformation <= *plan.enough;
}

/// Two levels are always solved; whether a third one is, each problem's own coarser ones tell. Those were
/// solved along, and are in the cache.
bool is_asked_for(const DeformInput& input, int level, const ContestSetting& setting) {
  const PlanReference& plan = *setting.plan.reference;
  if (level < kLevelsOfAll || !plan.enough) return true;
  DeformReference reference;
  std::vector<std::vector<Vec3>> levels;
  for (int coarser = 0; coarser < level; ++coarser) {
    levels.push_back(solve_level(input, coarser, setting, {}, reference));
    if (reference.interrupted || !reference.failure.empty()) return false;
  }
  try {
    estimate_from(input, plan, levels, reference);
  } catch (const InputError&) {
    return false;  // is said when it is its turn
  }
  return !is_enough(input, plan, reference.estimate.error);
}

}  // namespace

DeformInput build_input(const PlanScene& scene, const json& sweep, const fs::path& folder) {
  DeformInput input;
  input.scene = scene.name;
  input.sweep = problem_sweep(sweep);
  input.id = problem_id(scene.name, sweep);
  SweptScene swept = place_swept_scene(scene.scene, input.sweep);
  input.own.mesh = std::move(swept.mesh);
  input.placed = std::move(swept.placed);
  input.own.problem = build_problem(input.placed, input.own.mesh);
  input.chosen = choose_points(input.placed, input.own.mesh);
  write_problem(input.own, folder);
  return input;
}

std::string stiffness_name(const ProblemFiles& files) {
  const BoundaryProblem& problem = files.problem;
  const bool is_moved_hard = std::any_of(problem.held.begin(), problem.held.end(),
                                         [](const HeldFaces& held) { return length_sq(held.by_m) > 0.0; });
  if (problem.strain != StrainSize::kSmall || is_moved_hard || !problem.held_field_m.empty()) return "";
  BoundaryProblem bare = problem;
  bare.material.density_kg_m3 = 0.0;
  bare.gravity_m_s2 = {};
  bare.tractions.clear();
  bare.nodal_forces.clear();
  bare.body_force_n_m3.clear();
  for (ElasticSupport& support : bare.supports) support.by_m = {};
  return hash_bytes(files.mesh_hash + reference::problem_to_json(bare).dump());
}

DeformReference solve_reference(const DeformInput& input, const ContestSetting& setting,
                                std::span<const DeformInput* const> companions) {
  const PlanReference& plan = *setting.plan.reference;
  DeformReference reference;
  std::vector<std::vector<Vec3>> levels;
  for (int level = 0; level < plan.levels; ++level) {
    std::vector<fs::path> along;
    for (const DeformInput* companion : companions) {
      if (is_asked_for(*companion, level, setting)) along.push_back(companion->own.problem_file);
    }
    levels.push_back(solve_level(input, level, setting, along, reference));
    if (reference.interrupted || !reference.failure.empty()) return reference;
    try {
      estimate_from(input, plan, levels, reference);
    } catch (const InputError& error) {
      fail(reference, "bad_answer", std::string("the reference judges nothing: ") + error.what());
      return reference;
    }
    if (is_enough(input, plan, reference.estimate.error)) break;
  }
  return reference;
}

SimplifiedInput simplify_input(const DeformInput& input, const PlanContestant& simplifier, const Stop& stop,
                               const fs::path& folder, const ContestSetting& setting) {
  SimplifiedMesh made = simplify_mesh(input.own.mesh, simplifier, stop, folder, setting, &input.own.problem);
  SimplifiedInput simplified;
  simplified.failure = made.failure;
  simplified.kernel_s = made.kernel_s;
  simplified.grading = made.grading;
  if (!made.failure.empty()) return simplified;
  simplified.files.mesh = std::move(made.mesh);
  try {
    simplified.files.problem = build_problem(on_whole(input.placed, input.own.mesh), simplified.files.mesh);
    write_problem(simplified.files, folder);
  } catch (const InputError& error) {
    simplified.failure = "on the mesh of " + simplifier.label + ": " + error.what();
  }
  return simplified;
}

}  // namespace palpate::experiments
