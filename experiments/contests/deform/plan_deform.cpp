#include "experiments/contests/deform/plan_deform.h"

#include <algorithm>

#include "experiments/contests/deform/plan_frontier.h"
#include "experiments/contests/deform/plan_targets.h"
#include "experiments/plan_reader/plan_contestant.h"
#include "experiments/plan_reader/plan_reference.h"
#include "experiments/plan_reader/plan_report.h"
#include "experiments/plan_reader/plan_scene.h"

namespace palpate::experiments {
namespace {

/// The axis that is the simplifiers' alone.
const SweepAxis* stop_axis(const Plan& plan) {
  for (const SweepAxis& axis : plan.sweep) {
    if (axis.is_stop()) return &axis;
  }
  return nullptr;
}

/// Reads `simplify`: simplifiers as in a contest of their own, and "none" for the mesh as it is. The sweep
/// tets_removed_ratio is theirs.
void read_simplifiers(const YamlFields& fields, Plan& plan, const Registry& registry) {
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
    plan.simplifiers.push_back(std::move(simplifier));
  }
}

}  // namespace

void read_deform_plan(const YamlFields& fields, Plan& plan, const Registry& registry) {
  plan.scenes =
      read_plan_scenes(fields.need("scenes"), plan.file.parent_path(), SceneKind::kStatic, plan.contest);
  plan.subjects = names_of(plan.scenes);
  if (const auto sweep = fields.find("sweep"))
    plan.sweep = read_sweep(*sweep, {"poisson_ratio", "vertices", "tets_removed_ratio"});
  read_simplifiers(fields, plan, registry);
  std::vector<SweepAxis> own;  // the ratio is the simplifiers'
  for (const SweepAxis& axis : plan.sweep) {
    if (!axis.is_stop()) own.push_back(axis);
  }
  plan.contestants = read_contestants(fields.need("contestants"), "deform", own, registry);
  check_reserved_labels(fields.need("contestants"), plan);
  plan.reference = read_reference(fields.need("reference"), plan.contest, registry);
  check_vertices_sweep(fields, plan);
  check_targets(fields, plan);
  check_frontier(fields, plan);
  if (const auto beside = fields.find("beside"))
    known_label(*beside, plan.contestants);  // the report reads it
}

}  // namespace palpate::experiments
