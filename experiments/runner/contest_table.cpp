#include "experiments/runner/contest_table.h"

#include <algorithm>
#include <set>

#include "core/base/error.h"
#include "experiments/contests/deform/deform_contest.h"
#include "experiments/contests/engine/engine_contest.h"
#include "experiments/contests/motion/motion_contest.h"
#include "experiments/contests/simplify/simplify_contest.h"
#include "experiments/contests/stability/stability_contest.h"
#include "experiments/contests/verify/verify_contest.h"

namespace palpate::experiments {
namespace {

const ContestKind& contest_of(const Plan& plan) {
  for (const ContestKind* kind : list_contests()) {
    if (kind->name == plan.contest) return *kind;
  }
  throw ContractError("contest_table: unknown contest " + plan.contest);
}

}  // namespace

const std::vector<const ContestKind*>& list_contests() {
  static const std::vector<const ContestKind*> contests{
      &simplify_contest(), &deform_contest(), &motion_contest(),
      &verify_contest(),   &engine_contest(), &stability_contest(),
  };
  return contests;
}

const std::vector<std::string>& keys_of_every_plan() {
  static const std::vector<std::string> keys{
      "schema", "question", "contest", "contestants", "contestant_folders",
      "sweep",  "run",      "measure", "accept"};
  return keys;
}

std::vector<std::string> list_plan_keys() {
  std::vector<std::string> keys = keys_of_every_plan();
  for (const ContestKind* kind : list_contests()) {
    for (const std::string& key : kind->keys) {
      if (std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
    }
  }
  return keys;
}

std::vector<Case> build_cases(const Plan& plan, const Registry& registry) {
  std::vector<Case> cases = contest_of(plan).build_cases(plan, registry);
  std::set<std::string> ids;
  for (const Case& c : cases) {
    if (!ids.insert(c.id).second) throw InputError(plan.file.string() + ": two cases are called " + c.id);
  }
  return cases;
}

std::unique_ptr<Contest> make_contest(const ContestSetting& setting) {
  return contest_of(setting.plan).start(setting);
}

}  // namespace palpate::experiments
