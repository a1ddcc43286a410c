#include "experiments/plan_engine.h"

#include <algorithm>
#include <set>

#include "experiments/nearest_name.h"

namespace palpate::experiments {
namespace {

PlanScene read_entry(const YamlValue& item, const std::filesystem::path& folder) {
  PlanScene scene;
  if (item.is_text()) {
    scene.name = item.identifier();
    const std::filesystem::path path = scene_path(scene.name);
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error))
      item.fail("unknown scene \"" + scene.name + "\"" + nearest_hint(scene.name, scene_names()));
    scene.scene = read_scene(path);
  } else {
    const YamlFields fields = item.fields({"name", "file"});
    scene.name = fields.need("name").identifier();
    scene.scene = read_scene(folder / fields.need("file").text());
  }
  if (!scene.scene.is_dynamic)
    item.fail("the scene " + scene.name + " is static; the contest engine takes dynamic ones");
  return scene;
}

bool has_vertices(const Plan& plan, const PlanContestant& contestant) {
  const auto set = contestant.set.find("vertices");
  if (set != contestant.set.end()) return set->second.text != "0";
  return std::any_of(plan.sweep.begin(), plan.sweep.end(),
                     [](const SweepAxis& axis) { return axis.name == "option.vertices"; });
}

}  // namespace

std::vector<PlanScene> read_dynamic_scenes(const YamlValue& value, const std::filesystem::path& folder) {
  std::vector<PlanScene> scenes;
  std::set<std::string> names;
  for (const YamlValue& item : value.items()) {
    scenes.push_back(read_entry(item, folder));
    if (!names.insert(scenes.back().name).second) item.fail("scene \"" + scenes.back().name + "\" twice");
  }
  if (scenes.empty()) value.fail("scenes: expected at least one");
  return scenes;
}

void check_scenes_of_contestants(const YamlValue& at, const Plan& plan) {
  std::vector<std::string> known;
  for (const PlanScene& scene : plan.scenes) known.push_back(scene.name);
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

bool runs_on(const PlanContestant& contestant, const std::string& scene) {
  return contestant.scenes.empty() ||
         std::find(contestant.scenes.begin(), contestant.scenes.end(), scene) != contestant.scenes.end();
}

}  // namespace palpate::experiments
