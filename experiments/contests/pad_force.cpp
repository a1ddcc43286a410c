#include "experiments/contests/pad_force.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/number_text.h"
#include "core/mesh/subdivision/refinement.h"
#include "core/mesh/topology.h"
#include "experiments/contestants/solution.h"
#include "experiments/contests/problem_files.h"
#include "experiments/scene_reader/scene_problem.h"
#include "experiments/text/terminal.h"
#include "reference/door/deform_problem.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kMostTets = 120'000;
/// Share of a force or an energy that the solver may leave open: it stops at 1e-10 of the force out of
/// balance, a sum over 1e6 unknowns of which is at most 1e-7 of the force.
constexpr double kSolverRounding = 1e-6;

void fail_force(PadForce& force, const std::string& outcome, const std::string& why) {
  force.outcome = outcome;
  force.failure = why;
}

/// The support that is the pad: the last one, as loads come after clamps.
const ElasticSupport& pad_of(const BoundaryProblem& problem) {
  return problem.supports.back();
}

/// Is the pad all that moves the body? Then the energies of its problem are known in advance.
bool is_pad_alone(const BoundaryProblem& problem) {
  const auto is_still = [](const auto& each) { return each.by_m == Vec3{}; };
  return problem.gravity_m_s2 == Vec3{} && problem.tractions.empty() && problem.nodal_forces.empty() &&
         problem.body_force_n_m3.empty() && problem.held_field_m.empty() &&
         std::all_of(problem.held.begin(), problem.held.end(), is_still) &&
         std::all_of(problem.supports.begin(), problem.supports.end() - 1, is_still);
}

/// Forces and energies of a quadratic field on the mesh that it was solved on.
PadLevel measure_level(const ProblemFiles& files, std::span<const Vec3> field, const nlohmann::json& report) {
  PadLevel level;
  const ElasticSupport& pad = pad_of(files.problem);
  level.force_n = measure_pad_force(files.mesh, pad, field);
  for (const ElasticSupport& support : files.problem.supports) {
    if (&support != &pad) level.reaction_n = level.reaction_n + measure_pad_force(files.mesh, support, field);
  }
  level.by_force_j = dot(pad.by_m, level.force_n);
  level.potential_j = report.at("energy_j").get<double>() + report.at("support_energy_j").get<double>();
  return level;
}

nlohmann::json describe_level(const PadLevel& level, int refine, const ContestantAnswer& answer,
                              bool was_kept) {
  return {{"refine", refine},
          {"kernel_s", *answer.kernel_s},
          {"from_cache", was_kept},
          {"force_n", {level.force_n.x, level.force_n.y, level.force_n.z}},
          {"reaction_n", {level.reaction_n.x, level.reaction_n.y, level.reaction_n.z}},
          {"by_force_j", level.by_force_j},
          {"potential_j", level.potential_j}};
}

/// Solves the problem on these files' mesh; false where that failed or was interrupted.
bool solve_pad_level(const ProblemFiles& files, int refine, const ContestSetting& setting, PadForce& force,
                     std::vector<PadLevel>& levels) {
  const PlanReference& plan = *setting.plan.reference;
  ContestantTask task = start_task(plan.method, files.mesh_file, setting);
  task.problem_in = files.problem_file;
  task.options = resolve_options(*task.method.method, plan.set);
  task.timeout_s = kReferenceTimeout;
  const Solution solution = solve(task, "converged");
  force.interrupted = solution.interrupted;
  if (solution.interrupted) return false;
  const std::string which = "level " + std::to_string(refine) + " of the reference ";
  if (!solution.failure.empty()) {
    fail_force(force, solution.outcome, which + solution.failure);
    return false;
  }
  const ContestantAnswer& answer = solution.answer;
  const std::size_t vertices = files.mesh.points.size();
  const std::size_t edges = build_edges(files.mesh).size();
  try {
    const std::vector<Vec3> field = reference::read_displacement(answer.output, vertices, edges);
    if (field.size() != vertices + edges) throw InputError("no values at edge midpoints");
    levels.push_back(measure_level(files, field, answer.report));
  } catch (const InputError& error) {
    fail_force(force, "bad_answer", which + "cannot be read: " + error.what());
    return false;
  } catch (const nlohmann::json::exception&) {
    fail_force(force, "bad_answer", which + "has no energies (energy_j, support_energy_j)");
    return false;
  }
  force.levels.push_back(describe_level(levels.back(), refine, answer, solution.was_kept));
  return true;
}

/// Mesh and problem refined once, as files below `folder`.
ProblemFiles refine_files(const ProblemFiles& files, const fs::path& folder) {
  ProblemFiles fine;
  fine.mesh = refine_uniformly(files.mesh);
  fine.problem = refine_problem(files.problem, files.mesh, fine.mesh);
  write_problem(fine, folder);
  return fine;
}

void add_level_faults(const PadLevel& before, const PadLevel& level, std::size_t k,
                      std::vector<std::string>& faults) {
  const auto must_fall = [&](const char* what, double was, double is) {
    if (is <= was * (1.0 + kSolverRounding)) return;
    faults.push_back("refinement " + std::to_string(k) + " raised " + what + " from " + short_number(was) +
                     " J to " + short_number(is) + " J; nested spaces must lower it");
  };
  must_fall("the least energy", before.potential_j, level.potential_j);
  must_fall("by . F of the pad", before.by_force_j, level.by_force_j);
}

}  // namespace

bool is_moved(const ElasticSupport& support) {
  return length_sq(support.by_m) > 0.0;
}

double relative_force_error(std::span<const Vec3> force, std::span<const Vec3> truth) {
  require(force.size() == truth.size(), "relative_force_error: sizes differ");
  double off = 0.0;
  double whole = 0.0;
  for (std::size_t k = 0; k < force.size(); ++k) {
    off += length_sq(force[k] - truth[k]);
    whole += length_sq(truth[k]);
  }
  return std::sqrt(off / whole);
}

BoundaryProblem build_held_problem(const Scene& placed, const TetMesh& mesh) {
  Scene held = placed;
  held.is_dynamic = false;
  std::size_t tools = 0;
  for (SceneLoad& load : held.loads) {
    if (load.until_s) throw InputError(load.where, 0, "a load that stays", "one that goes");
    if (load.profile) load.vector = load.profile->share.back() * load.vector;
    load.profile.reset();
    load.from_s = 0.0;
    if (load.kind != SceneLoad::Kind::kDisplace) continue;
    ++tools;
    if (!load.elastic_pa_per_m)
      throw InputError(load.where, 0, "an elastic pad, whose force can be measured", "a hard one");
  }
  if (tools != 1) throw InputError(placed.file.string(), 0, "one tool (displace)", std::to_string(tools));
  return build_problem(held, mesh);
}

Vec3 measure_pad_force(const TetMesh& mesh, const ElasticSupport& pad, std::span<const Vec3> field) {
  const EdgeNumbers edges = build_edge_numbers(mesh);
  require(field.size() == mesh.points.size() + edges.edges.size(), "one value a vertex and an edge");
  Vec3 sum;
  for (std::size_t k = 0; k < pad.patch.faces.size(); ++k) {
    const auto [a, b, c] = pad.patch.faces[k];
    const double area = 0.5 * length(cross(mesh.points[b] - mesh.points[a], mesh.points[c] - mesh.points[a]));
    Vec3 mean;
    for (const auto& [p, q] : {std::pair{a, b}, std::pair{b, c}, std::pair{c, a}})
      mean = mean + (1.0 / 3.0) * field[mesh.points.size() + edges.of(p, q)];
    sum = sum + (pad.stiffness_pa_per_m * pad.patch.weight[k] * area) * (pad.by_m - mean);
  }
  return sum;
}

std::vector<std::string> find_pad_faults(const BoundaryProblem& problem, std::span<const PadLevel> levels) {
  std::vector<std::string> faults;
  if (!is_pad_alone(problem)) return faults;
  for (std::size_t k = 0; k < levels.size(); ++k) {
    const PadLevel& level = levels[k];
    const std::string which = "level " + std::to_string(k) + ": ";
    const double size = length(level.force_n);
    const double left = length(level.force_n + level.reaction_n);
    if (problem.held.empty() && !(left <= kSolverRounding * size))
      faults.push_back(which + "the supports' reactions leave " + short_number(left) + " N of the pad's " +
                       short_number(size) + " N");
    const double twice = 2.0 * level.potential_j;
    if (problem.strain == StrainSize::kSmall &&
        !(std::abs(level.by_force_j - twice) <= kSolverRounding * std::abs(twice)))
      faults.push_back(which + "by . F is " + short_number(level.by_force_j) +
                       " J; twice the energy of a linear body is " + short_number(twice) + " J");
    if (k > 0) add_level_faults(levels[k - 1], level, k, faults);
  }
  return faults;
}

PadForce solve_pad_force(const Scene& placed, const TetMesh& mesh, const fs::path& folder,
                         const ContestSetting& setting) {
  PadForce force;
  if (mesh.tets.size() > kMostTets) {
    fail_force(force, "unavailable", "the mesh has more than 120,000 tetrahedra");
    return force;
  }
  ProblemFiles files;
  files.mesh = mesh;
  files.problem = build_held_problem(placed, mesh);
  write_problem(files, folder);
  std::vector<PadLevel> levels;
  for (int k = 0; k < setting.plan.reference->levels; ++k) {
    if (k > 0 && 8 * files.mesh.tets.size() > kMostTets) break;
    if (k > 0) files = refine_files(files, folder / ("refined_" + std::to_string(k)));
    if (!solve_pad_level(files, k, setting, force, levels)) return force;
  }
  force.force_n = levels.back().force_n;
  if (levels.size() > 1)
    force.change = length(force.force_n - levels[levels.size() - 2].force_n) / length(force.force_n);
  force.faults = find_pad_faults(files.problem, levels);
  if (!force.faults.empty())
    fail_force(force, "rejected", "the reference contradicts itself: " + force.faults.front());
  return force;
}

}  // namespace palpate::experiments
