#include "experiments/contests/deform/plan_frontier.h"

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "experiments/plan_reader/plan_report.h"
#include "experiments/text/nearest_name.h"

namespace palpate::experiments {
namespace {

constexpr double kLeastError = 1e-6;
constexpr double kMostError = 10.0;

/// The names of the families. Their labels are checked: each of `entries` belongs to one, in `family_of`.
std::vector<std::string> read_families(const YamlValue& value, const std::vector<PlanContestant>& entries,
                                       std::map<std::string, std::string>& family_of) {
  std::vector<std::string> names;
  for (const auto& [name, members] : value.entries()) {
    names.push_back(name);
    for (const YamlValue& item : members.items()) {
      const std::string label = known_label(item, entries);
      const auto [place, is_new] = family_of.emplace(label, name);
      if (!is_new) item.fail("label \"" + label + "\" is in the family \"" + place->second + "\" already");
    }
    if (members.items().empty()) members.fail_expected("at least one label");
  }
  for (const PlanContestant& entry : entries) {
    if (family_of.count(entry.label) == 0) value.fail("label \"" + entry.label + "\" is in no family");
  }
  return names;
}

/// What the families are of: the plan's contestants, or its simplifiers.
const std::vector<PlanContestant>& read_of(const YamlFields& frontier, const Plan& plan) {
  const auto of = frontier.find("of");
  if (!of || of->text() == "contestants") return plan.contestants;
  if (of->text() != "simplifiers") of->fail_expected("contestants or simplifiers");
  if (plan.simplifiers.empty()) of->fail("families of simplifiers in a plan without the key simplify");
  return plan.simplifiers;
}

void check_family(const YamlValue& value, const std::vector<std::string>& families) {
  const std::string name = value.text();
  if (std::find(families.begin(), families.end(), name) == families.end())
    value.fail("unknown family \"" + name + "\"" + nearest_hint(name, families));
}

}  // namespace

void check_frontier(const YamlFields& fields, Plan& plan) {
  const auto given = fields.find("frontier");
  if (!given) return;
  const YamlFields frontier = given->fields({"of", "families", "against", "at", "targets"});
  const std::vector<PlanContestant>& entries = read_of(frontier, plan);
  const std::vector<std::string> families = read_families(frontier.need("families"), entries, plan.families);
  plan.families_of_simplifiers = &entries == &plan.simplifiers;
  for (const YamlValue& name : frontier.need("against").items()) check_family(name, families);
  const YamlValue errors = frontier.need("at");
  for (const YamlValue& error : errors.items()) error.number(kLeastError, kMostError);
  if (errors.items().empty()) errors.fail_expected("at least one error");
  const auto targets = frontier.find("targets");
  if (!targets) return;
  for (const YamlValue& item : targets->items()) {
    const YamlFields target = item.fields({"work", "against", "at", "factor"});
    const std::string work = target.need("work").text();
    if (work != "first" && work != "further" && work != "second" && work != "second_setup")
      target.need("work").fail_expected("first, further, second or second_setup");
    check_family(target.need("against"), families);
    target.need("at").number(kLeastError, kMostError);
    target.need("factor").number(0.0, 1e9);
  }
}

}  // namespace palpate::experiments
