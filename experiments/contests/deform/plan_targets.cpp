#include "experiments/contests/deform/plan_targets.h"

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "experiments/plan_reader/plan_report.h"
#include "experiments/text/nearest_name.h"

namespace palpate::experiments {
namespace {

void check_known(const YamlValue& value, const char* what, const std::vector<std::string>& known) {
  const std::string name = value.text();
  if (std::find(known.begin(), known.end(), name) == known.end())
    value.fail(std::string("unknown ") + what + " \"" + name + "\"" + nearest_hint(name, known));
}

/// The entries of a list, or the value itself.
std::vector<YamlValue> one_or_more(const YamlValue& value) {
  return value.is_list() ? value.items() : std::vector<YamlValue>{value};
}

/// Names of the sets, which are checked.
std::vector<std::string> read_scene_sets(const YamlValue& value, const std::vector<std::string>& scenes) {
  std::vector<std::string> names;
  for (const auto& [name, members] : value.entries()) {
    if (std::find(scenes.begin(), scenes.end(), name) != scenes.end())
      members.fail("\"" + name + "\" is a scene: a set needs a name of its own");
    std::set<std::string> seen;
    const std::vector<YamlValue> items = members.items();
    for (const YamlValue& scene : items) {
      check_known(scene, "scene", scenes);
      if (!seen.insert(scene.text()).second) scene.fail("scene \"" + scene.text() + "\" twice");
    }
    if (items.empty()) members.fail_expected("at least one scene");
    names.push_back(name);
  }
  return names;
}

/// `at` picks values that the sweep has.
void check_place(const YamlValue& at, const Plan& plan) {
  std::vector<std::string> names;
  std::vector<const SweepAxis*> axes;
  for (const SweepAxis& axis : plan.sweep) {
    if (!axis.is_problem()) continue;
    names.push_back(axis.name);
    axes.push_back(&axis);
  }
  for (const auto& [name, value] : at.entries()) {
    const auto place = std::find(names.begin(), names.end(), name);
    if (place == names.end())
      value.fail("\"" + name + "\" is not swept in this plan" + nearest_hint(name, names));
    const SweepAxis* axis = axes[static_cast<std::size_t>(place - names.begin())];
    for (const YamlValue& item : one_or_more(value)) {
      const double wanted = item.number();
      const bool has = std::any_of(axis->values.begin(), axis->values.end(),
                                   [&](const nlohmann::json& v) { return v.get<double>() == wanted; });
      if (!has) item.fail(name + " " + item.text() + " is not a value of the sweep");
    }
  }
}

}  // namespace

void check_targets(const YamlFields& fields, const Plan& plan) {
  const std::vector<std::string> scenes = plan.subjects;
  std::vector<std::string> places = scenes;
  if (const auto sets = fields.find("scene_sets")) {
    const std::vector<std::string> names = read_scene_sets(*sets, scenes);
    places.insert(places.end(), names.begin(), names.end());
  }
  const auto targets = fields.find("targets");
  if (!targets) return;
  std::vector<std::string> labels;
  labels.reserve(plan.contestants.size());
  for (const PlanContestant& contestant : plan.contestants) labels.push_back(contestant.label);
  for (const YamlValue& item : targets->items()) {
    const YamlFields target =
        item.fields({"text", "labels", "scenes", "at", "measure", "at_most", "required"});
    if (target.need("text").text().empty()) target.need("text").fail_expected("what is to be reached");
    target.need("at_most").number(0.0, 1e6);
    check_required(target);
    const YamlValue named = target.need("labels");
    const std::vector<YamlValue> own = one_or_more(named);
    for (const YamlValue& label : own) check_known(label, "label", labels);
    if (own.empty()) named.fail_expected("at least one label");
    if (const auto given = target.find("scenes")) {
      for (const YamlValue& scene : one_or_more(*given)) check_known(scene, "scene or set", places);
    }
    if (const auto at = target.find("at")) check_place(*at, plan);
    if (const auto measure = target.find("measure"))
      check_known(*measure, "error",
                  {"displacement_l2", "displacement_deformation", "displacement_max", "displacement_energy",
                   "displacement_energy_whole", "pad_force"});
  }
}

}  // namespace palpate::experiments
