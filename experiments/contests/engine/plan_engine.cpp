#include "experiments/contests/engine/plan_engine.h"

#include <algorithm>

#include "experiments/plan_reader/plan_contestant.h"
#include "experiments/plan_reader/plan_reference.h"
#include "experiments/plan_reader/plan_scene.h"
#include "experiments/text/nearest_name.h"

namespace palpate::experiments {
namespace {

bool has_vertices(const Plan& plan, const PlanContestant& contestant) {
  const auto set = contestant.set.find("vertices");
  if (set != contestant.set.end()) return set->second.text != "0";
  return std::any_of(plan.sweep.begin(), plan.sweep.end(),
                     [](const SweepAxis& axis) { return axis.name == "option.vertices"; });
}

void check_scenes_of_contestants(const YamlValue& at, const Plan& plan) {
  const std::vector<std::string>& known = plan.subjects;
  for (const PlanContestant& contestant : plan.contestants) {
    for (const std::string& name : contestant.scenes) {
      if (std::find(known.begin(), known.end(), name) == known.end())
        at.fail(contestant.label + ": unknown scene \"" + name + "\"" + nearest_hint(name, known));
    }
    for (const PlanScene& scene : plan.scenes) {
      if (runs_on(contestant, scene.name) && !scene.scene.mesh.shape && has_vertices(plan, contestant))
        at.fail("the scene " + scene.name + " has its mesh from a file: " + contestant.label +
                " cannot ask for other vertices");
    }
  }
}

}  // namespace

void read_engine_plan(const YamlFields& fields, Plan& plan, const Registry& registry) {
  plan.scenes =
      read_plan_scenes(fields.need("scenes"), plan.file.parent_path(), SceneKind::kDynamic, plan.contest);
  plan.subjects = names_of(plan.scenes);
  if (const auto sweep = fields.find("sweep")) plan.sweep = read_sweep(*sweep, {});
  plan.contestants = read_contestants(fields.need("contestants"), "engine", plan.sweep, registry);
  check_scenes_of_contestants(fields.need("contestants"), plan);
  if (const auto reference = fields.find("reference"))
    plan.reference = read_reference(*reference, "deform", registry);
}

}  // namespace palpate::experiments
