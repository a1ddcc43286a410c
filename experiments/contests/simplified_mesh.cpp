#include "experiments/contests/simplified_mesh.h"

#include "core/base/error.h"
#include "core/mesh/io/medit.h"
#include "core/simplify/sizing/size_file.h"
#include "experiments/contestants/answer_cache.h"
#include "experiments/files/output_file.h"
#include "experiments/grading/graded_mesh.h"
#include "experiments/judging/judge_record.h"
#include "experiments/plan_reader/plan_contestant.h"

namespace palpate::experiments {
namespace fs = std::filesystem;
namespace {

constexpr double kSimplifierTimeout = 1800.0;  // s
// Simplifiers get millimetres, as in their own contest: VTK's, in single precision, removes nothing from an
// organ in metres.

TetMesh scaled(TetMesh mesh, double factor) {
  for (Vec3& point : mesh.points) point = factor * point;
  return mesh;
}

/// The axis that is the simplifiers' alone.
const SweepAxis* stop_axis(const Plan& plan) {
  for (const SweepAxis& axis : plan.sweep) {
    if (axis.is_stop()) return &axis;
  }
  return nullptr;
}

void read_simplifier_list(const YamlFields& fields, Plan& plan, const Registry& registry) {
  const auto value = fields.find("simplify");
  const SweepAxis* ratio = stop_axis(plan);
  if (!value) {
    if (ratio != nullptr)
      fields.self().fail("the sweep " + ratio->name +
                         " needs the key \"simplify\": what is to be simplified?");
    return;
  }
  std::vector<SweepAxis> own;
  if (ratio != nullptr) own.push_back(*ratio);
  bool has_none = false;
  YamlValue rest = *value;
  const auto items = value->items();
  for (const YamlValue& item : items) {
    if (!item.is_text() || item.text() != kNoSimplifier) continue;
    if (has_none) item.fail("\"none\" twice");
    has_none = true;
  }
  if (has_none) {
    PlanContestant none;
    none.label = kNoSimplifier;
    plan.simplifiers.push_back(none);
    rest = value->without_text(kNoSimplifier);
    if (rest.items().empty()) return;
  }
  for (PlanContestant& simplifier : read_contestants(rest, "simplify", own, registry)) {
    if (simplifier.label == kNoSimplifier) value->fail("the label \"none\" stands for the mesh as it is");
    if (simplifier.stop && simplifier.stop->kind == StopKind::kTetsOf)
      value->fail("simplifiers stop at a count or a ratio, not at the tets of another");
    if (!simplifier.keep.empty() || !simplifier.seeds.empty())
      value->fail("simplifiers take neither \"keep\" nor \"seeds\" here");
    if (simplifier.grade && plan.contest != "deform")
      value->fail("\"grade\" belongs to simplifiers of the contest deform, not of " + plan.contest);
    plan.simplifiers.push_back(std::move(simplifier));
  }
}

/// Puts the sizes that the problem wants beside the mesh and into the task. Returns why there are none.
std::string add_sizes(const GradedBody& body, const PlanContestant& simplifier, const Stop& stop,
                      const fs::path& folder, const ContestSetting& setting, ContestantTask& task,
                      nlohmann::json& facts) {
  try {
    const GradedSizes graded =
        find_graded_sizes(*simplifier.grade, body, tets_after(stop, body.mesh.tets.size()),
                          {setting.registry, folder / "pilot", setting.threads, setting.stop_flag});
    if (!graded.failure.empty()) return simplifier.label + ": " + graded.failure;
    const fs::path sizes = fs::absolute(folder / "sizes.csv");
    simplify::write_sizes(sizes, graded.sizes);
    task.options["sizes"] = sizes.string();
    facts = graded.facts;
    return "";
  } catch (const InputError& error) {  // nothing of a kind that other scenes of the plan have
    return "grading by " + simplifier.label + ": " + error.what();
  }
}

}  // namespace

std::vector<SweepAxis> read_simplifiers(const YamlFields& fields, Plan& plan, const Registry& registry) {
  read_simplifier_list(fields, plan, registry);
  std::vector<SweepAxis> own;  // the ratio is the simplifiers'
  for (const SweepAxis& axis : plan.sweep) {
    if (!axis.is_stop()) own.push_back(axis);
  }
  return own;
}

bool is_simplified(const Plan& plan, const Case& run_case) {
  return run_case.simplifier && !plan.simplifiers[*run_case.simplifier].method.empty();
}

std::string simplified_id(const Plan& plan, const Case& run_case, const std::string& problem_id) {
  std::string id = problem_id + "/simplify=" + plan.simplifiers[*run_case.simplifier].label;
  if (run_case.sweep.contains("tets_removed_ratio"))
    id += "/tets_removed_ratio=" + run_case.sweep.at("tets_removed_ratio").dump();
  return id;
}

SimplifiedMesh simplify_mesh(const TetMesh& whole, const PlanContestant& simplifier, const Stop& stop,
                             const fs::path& folder, const ContestSetting& setting,
                             const BoundaryProblem* problem) {
  SimplifiedMesh simplified;
  create_folder(folder);
  ContestantTask task = start_task(simplifier.method, fs::absolute(folder / "whole_mm.mesh"), setting);
  write_medit(task.mesh_in, scaled(whole, 1.0 / kSimplifierUnitM));
  task.options = resolve_simplifier_options(*task.method.method, simplifier.set);
  task.stop = stop;
  task.timeout_s = kSimplifierTimeout;
  if (simplifier.grade) {
    require(problem != nullptr, "simplify_mesh: graded without a problem");
    simplified.failure =
        add_sizes({whole, *problem, {}}, simplifier, stop, folder, setting, task, simplified.grading);
    if (!simplified.failure.empty()) return simplified;
  }
  bool was_kept = false;
  const ContestantAnswer answer = run_cached(task, was_kept);
  if (answer.outcome != "ok") {
    simplified.failure =
        "simplifying with " + simplifier.label + " ended: " + answer.outcome + ": " + answer.message;
    return simplified;
  }
  simplified.report = answer.report;
  simplified.kernel_s = answer.kernel_s;
  try {
    simplified.mesh = scaled(read_medit(answer.output, ReadOrientation::kKeep).mesh, kSimplifierUnitM);
    if (stop.kind != StopKind::kLimit && simplified.mesh.tets.size() >= whole.tets.size())
      throw InputError("no tetrahedra were removed");
    const Judgement judgement = judge_mesh(simplified.mesh);
    if (!judgement.violations.empty()) throw InputError(judgement.violations.front());
  } catch (const InputError& error) {
    simplified.failure = "on the mesh of " + simplifier.label + ": " + error.what();
  }
  return simplified;
}

}  // namespace palpate::experiments
