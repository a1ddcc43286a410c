#include "experiments/contests/motion/plan_motion.h"

#include "experiments/contests/simplified_mesh.h"
#include "experiments/plan_reader/plan_contestant.h"
#include "experiments/plan_reader/plan_reference.h"
#include "experiments/plan_reader/plan_scene.h"
#include "experiments/text/nearest_name.h"

namespace palpate::experiments {

void read_motion_plan(const YamlFields& fields, Plan& plan, const Registry& registry) {
  plan.scenes =
      read_plan_scenes(fields.need("scenes"), plan.file.parent_path(), SceneKind::kDynamic, plan.contest);
  plan.subjects = names_of(plan.scenes);
  if (const auto sweep = fields.find("sweep"))
    plan.sweep = read_sweep(*sweep, {"poisson_ratio", "vertices", "tets_removed_ratio"});
  const std::vector<SweepAxis> own = read_simplifiers(fields, plan, registry);
  plan.contestants = read_contestants(fields.need("contestants"), "motion", own, registry);
  check_reserved_labels(fields.need("contestants"), plan);
  plan.reference = read_reference(fields.need("reference"), plan.contest, registry);
  check_vertices_sweep(fields, plan);
}

}  // namespace palpate::experiments
