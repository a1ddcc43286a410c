#include "experiments/plan_reader/plan_scene.h"

#include <algorithm>
#include <set>

#include "experiments/plan_reader/plan_report.h"
#include "experiments/text/nearest_name.h"

namespace palpate::experiments {
namespace {

std::filesystem::path find_scene(const YamlValue& item) {
  const std::string name = item.identifier();
  std::filesystem::path path = scene_path(name);
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    item.fail("unknown scene \"" + name + "\"" + nearest_hint(name, scene_names()));
  return path;
}

PlanScene read_plan_scene(const YamlValue& item, const std::filesystem::path& folder, SceneKind kind,
                          const std::string& contest) {
  PlanScene scene;
  if (item.is_text()) {
    scene.name = item.identifier();
    scene.scene = read_scene(find_scene(item));
  } else {
    const YamlFields fields = item.fields({"name", "file", "tags"});
    scene.name = fields.need("name").identifier();
    scene.tags = read_tags(fields);
    const auto file = fields.find("file");
    scene.scene = read_scene(file ? folder / file->text() : find_scene(fields.need("name")));
  }
  if (scene.scene.is_dynamic && kind == SceneKind::kStatic)
    item.fail("the scene " + scene.name + " is dynamic; the contest " + contest + " takes static ones");
  if (!scene.scene.is_dynamic && kind == SceneKind::kDynamic)
    item.fail("the scene " + scene.name + " is static; the contest " + contest + " takes dynamic ones");
  return scene;
}

}  // namespace

std::vector<PlanScene> read_plan_scenes(const YamlValue& value, const std::filesystem::path& folder,
                                        SceneKind kind, const std::string& contest) {
  std::vector<PlanScene> scenes;
  std::set<std::string> names;
  for (const YamlValue& item : value.items()) {
    scenes.push_back(read_plan_scene(item, folder, kind, contest));
    if (!names.insert(scenes.back().name).second) item.fail("scene \"" + scenes.back().name + "\" twice");
  }
  if (scenes.empty()) value.fail("scenes: expected at least one");
  return scenes;
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
