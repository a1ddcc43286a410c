#include "experiments/plan_deform.h"

#include <algorithm>
#include <set>

#include "experiments/nearest_name.h"
#include "experiments/plan_contestant.h"

namespace palpate::experiments {
namespace {

constexpr std::int64_t kMostLevels = 4;

std::filesystem::path find_scene(const YamlValue& item) {
  const std::string name = item.identifier();
  std::filesystem::path path = scene_path(name);
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    item.fail("unknown scene \"" + name + "\"" + nearest_hint(name, scene_names()));
  return path;
}

PlanScene read_plan_scene(const YamlValue& item, const std::filesystem::path& folder,
                          const std::string& contest) {
  PlanScene scene;
  if (item.is_text()) {
    scene.name = item.identifier();
    scene.scene = read_scene(find_scene(item));
  } else {
    const YamlFields fields = item.fields({"name", "file"});
    scene.name = fields.need("name").identifier();
    const YamlValue file = fields.need("file");
    scene.scene = read_scene(folder / file.text());
  }
  if (scene.scene.is_dynamic && contest == "deform")
    item.fail("the scene " + scene.name + " is dynamic; the contest deform takes static ones");
  if (!scene.scene.is_dynamic && contest == "motion")
    item.fail("the scene " + scene.name + " is static; the contest motion takes dynamic ones");
  return scene;
}

/// The axis that is the simplifiers' alone.
const SweepAxis* stop_axis(const Plan& plan) {
  for (const SweepAxis& axis : plan.sweep) {
    if (axis.is_stop()) return &axis;
  }
  return nullptr;
}

}  // namespace

std::vector<PlanScene> read_plan_scenes(const YamlValue& value, const std::filesystem::path& folder,
                                        const std::string& contest) {
  std::vector<PlanScene> scenes;
  std::set<std::string> names;
  for (const YamlValue& item : value.items()) {
    scenes.push_back(read_plan_scene(item, folder, contest));
    if (!names.insert(scenes.back().name).second) item.fail("scene \"" + scenes.back().name + "\" twice");
  }
  if (scenes.empty()) value.fail("scenes: expected at least one");
  return scenes;
}

PlanReference read_reference(const YamlValue& value, const std::string& contest, const Registry& registry) {
  const YamlFields fields = value.fields({"method", "levels", "enough", "stated_order", "set"});
  if (contest == "motion") {
    if (const auto extra = fields.find("enough"))
      extra->fail("\"enough\" belongs to the contest deform, not to motion");
  }
  PlanReference reference;
  const YamlValue method = fields.need("method");
  reference.method = method.text();
  const MethodEntry entry = find_method(method, reference.method, contest, registry);
  const OptionSpec* refine = entry.method->find_option("refine");
  if (refine == nullptr || refine->type != OptionType::kInteger)
    method.fail("method " + reference.method + " has no integer option \"refine\", as a reference needs");
  if (contest == "motion" && entry.method->find_option("time_step_s") == nullptr)
    method.fail("method " + reference.method + " has no option \"time_step_s\", as a reference needs");
  if (const auto set = fields.find("set")) reference.set = read_set(*set, *entry.method);
  if (reference.set.count("refine") > 0) value.fail("the option \"refine\" follows from \"levels\"");
  if (const auto levels = fields.find("levels"))
    reference.levels = static_cast<int>(levels->integer(contest == "motion" ? 2 : 1, kMostLevels));
  if (const auto enough = fields.find("enough")) reference.enough = enough->number(1e-12, 1.0);
  if (const auto order = fields.find("stated_order")) reference.stated_order = order->number(1.0, 4.0);
  return reference;
}

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

void check_reserved_labels(const YamlValue& contestants, const Plan& plan) {
  for (const PlanContestant& contestant : plan.contestants) {
    if (contestant.label == "reference")
      contestants.fail("the label \"reference\" stands for the reference itself");
  }
}

void check_vertices_sweep(const YamlFields& fields, const Plan& plan) {
  const bool swept = std::any_of(plan.sweep.begin(), plan.sweep.end(),
                                 [](const SweepAxis& axis) { return axis.name == "vertices"; });
  if (!swept) return;
  for (const PlanScene& scene : plan.scenes) {
    if (!scene.scene.mesh.shape)
      fields.need("sweep").fail("the scene " + scene.name +
                                " has its mesh from a file: its vertices cannot be swept");
  }
}

}  // namespace palpate::experiments
