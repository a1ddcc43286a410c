#include "experiments/contests/stability/plan_stability.h"

#include <algorithm>
#include <set>

#include "experiments/plan_reader/case_id.h"
#include "experiments/plan_reader/plan_contestant.h"
#include "experiments/plan_reader/plan_mesh.h"
#include "experiments/text/nearest_name.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

/// The places of names in `known`; all of them if the list is absent.
std::vector<std::size_t> read_names(const std::optional<YamlValue>& value, const char* what,
                                    const std::vector<std::string>& known) {
  std::vector<std::size_t> places;
  if (!value) {
    for (std::size_t k = 0; k < known.size(); ++k) places.push_back(k);
    return places;
  }
  for (const YamlValue& item : value->items()) {
    const auto found = std::find(known.begin(), known.end(), item.text());
    if (found == known.end())
      item.fail(std::string("unknown ") + what + " \"" + item.text() + "\"" +
                nearest_hint(item.text(), known));
    const auto place = static_cast<std::size_t>(found - known.begin());
    if (std::find(places.begin(), places.end(), place) != places.end())
      item.fail(std::string(what) + " \"" + item.text() + "\" twice");
    places.push_back(place);
  }
  if (places.empty()) value->fail_expected(std::string("at least one ") + what);
  return places;
}

std::vector<std::string> labels_of(const std::vector<PlanContestant>& contestants) {
  std::vector<std::string> labels;
  labels.reserve(contestants.size());
  for (const PlanContestant& contestant : contestants) labels.push_back(contestant.label);
  return labels;
}

GivenOption given(const YamlValue& value) {
  return {value.text(), value.file() + ":" + std::to_string(value.line())};
}

/// Checks an option's value against every contestant of the extreme.
void check_option(const PlanExtreme& extreme, const Plan& plan, const Registry& registry,
                  const std::string& name, const GivenOption& option) {
  for (const std::size_t contestant : extreme.contestants)
    resolve_options(*registry.find(plan.contestants[contestant].method)->method, {{name, option}});
}

PlanExtreme read_extreme(const YamlValue& value, const Plan& plan, const Registry& registry) {
  const YamlFields fields = value.fields({"name", "meshes", "contestants", "simplify", "set", "sweep"});
  PlanExtreme extreme;
  extreme.name = fields.need("name").identifier();
  extreme.meshes = read_names(fields.find("meshes"), "mesh", plan.subjects);
  extreme.contestants = read_names(fields.find("contestants"), "label", labels_of(plan.contestants));
  if (const auto simplify = fields.find("simplify")) {
    const std::vector<std::string> known = labels_of(plan.simplifiers);
    const auto found = std::find(known.begin(), known.end(), simplify->text());
    if (found == known.end())
      simplify->fail("unknown simplifier \"" + simplify->text() + "\"" +
                     nearest_hint(simplify->text(), known));
    extreme.simplifier = static_cast<std::size_t>(found - known.begin());
  }
  if (const auto set = fields.find("set")) {
    for (const auto& [name, option] : set->entries()) {
      extreme.set[name] = given(option);
      check_option(extreme, plan, registry, name, extreme.set[name]);
    }
  }
  if (const auto sweep = fields.find("sweep")) {
    for (const auto& [name, list] : sweep->entries()) {
      if (extreme.set.count(name) > 0) list.fail("\"" + name + "\" is set already");
      SweepAxis axis;
      axis.name = name;
      for (const YamlValue& item : list.items()) {
        axis.values.push_back(item.json());
        axis.texts.push_back(given(item));
        check_option(extreme, plan, registry, name, axis.texts.back());
      }
      if (axis.values.empty()) list.fail_expected("at least one value");
      extreme.sweep.push_back(std::move(axis));
    }
  }
  return extreme;
}

std::string value_text(const GivenOption& value) {
  return value.text;
}

std::vector<PlanExtreme> read_extremes(const YamlValue& value, const Plan& plan, const Registry& registry) {
  std::vector<PlanExtreme> extremes;
  std::set<std::string> names;
  for (const YamlValue& item : value.items()) {
    extremes.push_back(read_extreme(item, plan, registry));
    if (!names.insert(extremes.back().name).second)
      item.fail("extreme \"" + extremes.back().name + "\" twice");
  }
  if (extremes.empty()) value.fail("extremes: expected at least one");
  return extremes;
}

}  // namespace

void read_stability_plan(const YamlFields& fields, Plan& plan, const Registry& registry) {
  plan.meshes = read_meshes(fields.need("meshes"), plan.file.parent_path());
  plan.subjects = names_of(plan.meshes);
  if (const auto simplify = fields.find("simplify"))
    plan.simplifiers = read_contestants(*simplify, "simplify", {}, registry);
  plan.contestants = read_contestants(fields.need("contestants"), "stability", {}, registry);
  auto part = std::make_shared<StabilityPart>();
  part->extremes = read_extremes(fields.need("extremes"), plan, registry);
  plan.part = std::move(part);
}

std::vector<Case> build_stability_cases(const Plan& plan, const Registry& registry) {
  std::vector<Case> cases;
  const auto add = [&](const PlanExtreme& extreme, std::size_t mesh, std::size_t contestant) {
    const PlanContestant& who = plan.contestants[contestant];
    const MethodSpec& method = *registry.find(who.method)->method;
    Case base;
    base.id = safe_part(plan.meshes[mesh].name) + "/" + safe_part(who.label) + "/" + safe_part(extreme.name);
    base.subject = mesh;
    base.contestant = contestant;
    base.sweep = {{"extreme", extreme.name}};
    base.simplifier = extreme.simplifier;
    if (extreme.simplifier && plan.simplifiers[*extreme.simplifier].stop)
      base.simplifier_stop = *plan.simplifiers[*extreme.simplifier].stop;
    std::map<std::string, GivenOption> start = who.set;
    for (const auto& [name, option] : extreme.set) start[name] = option;
    std::vector<std::pair<Case, std::map<std::string, GivenOption>>> points{{base, start}};
    for (const SweepAxis& axis : extreme.sweep) {
      std::vector<std::pair<Case, std::map<std::string, GivenOption>>> crossed;
      for (const auto& [point, set] : points) {
        for (std::size_t k = 0; k < axis.values.size(); ++k) {
          auto next = std::pair{point, set};
          next.first.sweep[axis.name] = axis.values[k];
          next.first.id += "/" + case_part(axis.name, value_text(axis.texts[k]));
          next.second[axis.name] = axis.texts[k];
          crossed.push_back(std::move(next));
        }
      }
      points = std::move(crossed);
    }
    for (auto& [point, set] : points) {
      point.options = resolve_options(method, set);
      cases.push_back(std::move(point));
    }
  };
  for (const PlanExtreme& extreme : part_of<StabilityPart>(plan).extremes) {
    for (const std::size_t mesh : extreme.meshes) {
      for (const std::size_t contestant : extreme.contestants) add(extreme, mesh, contestant);
    }
  }
  return cases;
}

}  // namespace palpate::experiments
