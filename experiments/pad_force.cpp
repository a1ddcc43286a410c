#include "experiments/pad_force.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/mesh/refinement.h"
#include "experiments/answer_cache.h"
#include "experiments/deform_input.h"
#include "experiments/scene_problem.h"
#include "reference/deform_problem.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

constexpr double kReferenceTimeout = 7200.0;  // s
constexpr std::size_t kMostTets = 120'000;

void fail(PadForce& force, const std::string& outcome, const std::string& why) {
  force.outcome = outcome;
  force.failure = why;
}

/// The support that is the pad: the last one, as loads come after clamps.
const ElasticSupport& pad_of(const BoundaryProblem& problem) {
  return problem.supports.back();
}

/// Solves one level; false where it failed or was interrupted.
bool solve_level(const ProblemFiles& files, int level, const ContestSetting& setting, PadForce& force) {
  const PlanReference& plan = *setting.plan.reference;
  ContestantTask task;
  task.method = *setting.registry.find(plan.method);
  task.mesh_in = files.mesh_file;
  task.problem_in = files.problem_file;
  task.scratch = fs::absolute(setting.folder.fresh_scratch());
  task.options = resolve_options(*task.method.method, plan.set);
  task.options["refine"] = level;
  task.threads = setting.threads;
  task.timeout_s = kReferenceTimeout;
  task.stop_flag = setting.stop_flag;
  bool was_kept = false;
  const ContestantAnswer answer = run_cached(task, was_kept);
  force.interrupted = answer.outcome == "interrupted";
  if (force.interrupted) return false;
  const std::string which = "level " + std::to_string(level) + " of the reference ended: ";
  if (answer.outcome != "ok") {
    fail(force, answer.outcome, which + answer.message);
    return false;
  }
  const std::string outcome = answer.report.at("outcome").get<std::string>();
  if (outcome != "converged") {
    fail(force, "error", which + outcome);
    return false;
  }
  const EdgeNumbers edges = build_edge_numbers(files.mesh);
  const std::size_t nodes = files.mesh.points.size() + edges.edges.size();
  try {
    const std::vector<Vec3> field =
        reference::read_displacement(answer.output, files.mesh.points.size(), edges.edges.size());
    if (field.size() != nodes) throw InputError("no values at edge midpoints");
    const Vec3 now = measure_pad_force(files.mesh, pad_of(files.problem), field);
    if (level > 0) force.change = length(now - force.force_n) / length(now);
    force.force_n = now;
  } catch (const InputError& error) {
    fail(force, "bad_answer", which + error.what());
    return false;
  }
  force.levels.push_back({{"refine", level},
                          {"kernel_s", *answer.kernel_s},
                          {"from_cache", was_kept},
                          {"force_n", {force.force_n.x, force.force_n.y, force.force_n.z}}});
  return true;
}

}  // namespace

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

PadForce solve_pad_force(const Scene& placed, const TetMesh& mesh, const fs::path& folder,
                         const ContestSetting& setting) {
  PadForce force;
  if (mesh.tets.size() > kMostTets) {
    fail(force, "unavailable", "the mesh has more than 120,000 tetrahedra");
    return force;
  }
  ProblemFiles files;
  files.mesh = mesh;
  files.problem = build_held_problem(placed, mesh);
  write_problem(files, folder);
  std::size_t tets = mesh.tets.size();
  for (int level = 0; level < setting.plan.reference->levels && tets <= kMostTets; ++level, tets *= 8) {
    if (!solve_level(files, level, setting, force)) break;
  }
  return force;
}

}  // namespace palpate::experiments
