#include "experiments/contests/verify/plan_verify.h"

#include <algorithm>
#include <set>

#include "experiments/plan_reader/case_id.h"
#include "experiments/plan_reader/plan_contestant.h"
#include "experiments/plan_reader/plan_report.h"
#include "experiments/text/nearest_name.h"
#include "reference/closed_form/known_cases.h"

namespace palpate::experiments {
namespace {

constexpr std::int64_t kMostCells = 400;

std::vector<std::string> known_case_names() {
  std::vector<std::string> names;
  for (const auto& info : reference::list_known_cases()) names.push_back(info.name);
  return names;
}

std::vector<int> read_cells(const YamlValue& value) {
  std::vector<int> cells;
  for (const YamlValue& item : value.items()) {
    const auto next = static_cast<int>(item.integer(1, kMostCells));
    if (!cells.empty() && next <= cells.back()) item.fail_expected("more cells than before");
    cells.push_back(next);
  }
  if (cells.empty()) value.fail_expected("at least one number of cells");
  return cells;
}

std::vector<std::string> read_labels(const YamlValue& value, const std::vector<PlanContestant>& contestants,
                                     std::set<std::string>& taken) {
  std::vector<std::string> known;
  known.reserve(contestants.size());
  for (const PlanContestant& contestant : contestants) known.push_back(contestant.label);
  std::vector<std::string> labels;
  for (const YamlValue& item : value.items()) {
    const std::string label = item.text();
    if (std::find(known.begin(), known.end(), label) == known.end())
      item.fail("unknown label \"" + label + "\"" + nearest_hint(label, known));
    if (!taken.insert(label).second) item.fail("the label \"" + label + "\" twice in one case");
    labels.push_back(label);
  }
  if (labels.empty()) value.fail_expected("at least one label");
  return labels;
}

KnownCaseExpectation read_expectation(const YamlValue& value, const std::vector<PlanContestant>& contestants,
                                      std::size_t meshes, std::set<std::string>& taken) {
  KnownCaseExpectation expectation;
  for (const auto& [name, entry] : value.entries()) {
    if (name == "contestants") {
      expectation.labels = read_labels(entry, contestants, taken);
      continue;
    }
    if (name == "solution_order" && meshes < 2) entry.fail("solution_order needs two meshes or more");
    expectation.bounds.push_back(read_bound(name, entry));
  }
  if (expectation.labels.empty()) value.fail("expected the key \"contestants\"");
  if (expectation.bounds.empty()) value.fail("expected a bound, such as solution_l2: {max: 1.0e-10}");
  return expectation;
}

PlanKnownCase read_known_case(const YamlValue& value, const std::vector<PlanContestant>& contestants) {
  const YamlFields fields = value.fields({"case", "cells", "expect"});
  PlanKnownCase known;
  const YamlValue name = fields.need("case");
  known.name = name.identifier();
  const std::vector<std::string> names = known_case_names();
  if (std::find(names.begin(), names.end(), known.name) == names.end())
    name.fail("unknown case \"" + known.name + "\"" + nearest_hint(known.name, names));
  known.cells = read_cells(fields.need("cells"));
  std::set<std::string> taken;
  const YamlValue expect = fields.need("expect");
  for (const YamlValue& item : expect.items()) {
    known.expect.push_back(read_expectation(item, contestants, known.cells.size(), taken));
  }
  if (known.expect.empty()) expect.fail_expected("at least one expectation");
  return known;
}

std::vector<PlanKnownCase> read_known_cases(const YamlValue& value,
                                            const std::vector<PlanContestant>& contestants) {
  std::vector<PlanKnownCase> cases;
  std::set<std::string> names;
  for (const YamlValue& item : value.items()) {
    cases.push_back(read_known_case(item, contestants));
    if (!names.insert(cases.back().name).second) item.fail("case \"" + cases.back().name + "\" twice");
  }
  if (cases.empty()) value.fail("cases: expected at least one");
  for (const PlanContestant& contestant : contestants) {
    if (!contestant.seeds.empty())
      value.fail(contestant.label + " has seeds, which the contest verify does not take");
    const bool is_used = std::any_of(cases.begin(), cases.end(), [&](const PlanKnownCase& known) {
      return find_expectation(known, contestant.label) != nullptr;
    });
    if (!is_used) value.fail("nothing is expected of " + contestant.label);
  }
  return cases;
}

}  // namespace

void read_verify_plan(const YamlFields& fields, Plan& plan, const Registry& registry) {
  plan.contestants = read_contestants(fields.need("contestants"), "deform", {}, registry);
  auto part = std::make_shared<VerifyPart>();
  part->known_cases = read_known_cases(fields.need("cases"), plan.contestants);
  plan.subjects = names_of(part->known_cases);
  plan.part = std::move(part);
}

std::vector<Case> build_verify_cases(const Plan& plan, const Registry& registry) {
  const std::vector<PlanKnownCase>& known_cases = part_of<VerifyPart>(plan).known_cases;
  std::vector<Case> cases;
  for (std::size_t subject = 0; subject < known_cases.size(); ++subject) {
    const PlanKnownCase& known = known_cases[subject];
    for (std::size_t contestant = 0; contestant < plan.contestants.size(); ++contestant) {
      const PlanContestant& who = plan.contestants[contestant];
      if (find_expectation(known, who.label) == nullptr) continue;
      for (const int cells : known.cells) {
        Case next;
        next.id = safe_part(known.name) + "/" + safe_part(who.label) + "/cells=" + std::to_string(cells);
        next.subject = subject;
        next.contestant = contestant;
        next.options = resolve_options(*registry.find(who.method)->method, who.set);
        next.sweep = {{"cells", cells}};
        if (cells != known.cells.front()) next.coarser = cases.size() - 1;
        cases.push_back(std::move(next));
      }
    }
  }
  return cases;
}

const KnownCaseExpectation* find_expectation(const PlanKnownCase& known, const std::string& label) {
  for (const KnownCaseExpectation& expectation : known.expect) {
    if (std::find(expectation.labels.begin(), expectation.labels.end(), label) != expectation.labels.end())
      return &expectation;
  }
  return nullptr;
}

}  // namespace palpate::experiments
