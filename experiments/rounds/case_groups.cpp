#include "experiments/rounds/case_groups.h"

#include <algorithm>
#include <map>
#include <numeric>

#include "core/base/error.h"

namespace palpate::experiments {

std::vector<std::size_t> group_cases(const std::vector<Case>& cases, const std::vector<bool>& is_timed) {
  require(is_timed.size() == cases.size(), "group_cases: a mark a case");
  std::vector<std::size_t> group(cases.size());
  std::iota(group.begin(), group.end(), std::size_t{0});
  const auto root = [&group](std::size_t i) {
    while (group[i] != i) i = group[i] = group[group[i]];
    return i;
  };
  const auto join = [&](std::size_t a, std::size_t b) {
    const std::size_t first = std::min(root(a), root(b));
    group[root(a)] = first;
    group[root(b)] = first;
  };
  std::map<std::size_t, std::size_t> timed;  // subject -> its first timed case
  for (std::size_t i = 0; i < cases.size(); ++i) {
    if (cases[i].tets_of) join(i, *cases[i].tets_of);
    if (cases[i].coarser) join(i, *cases[i].coarser);
    if (is_timed[i]) join(i, timed.emplace(cases[i].subject, i).first->second);
  }
  for (std::size_t i = 0; i < cases.size(); ++i) group[i] = root(i);
  return group;
}

std::vector<bool> find_timed(const Plan& plan, const std::vector<Case>& cases) {
  std::vector<bool> timed;
  timed.reserve(cases.size());
  for (const Case& c : cases) timed.push_back(plan.contestants[c.contestant].timed.value_or(plan.run.timed));
  return timed;
}

std::vector<bool> find_free(const std::vector<Case>& cases, const std::vector<bool>& is_timed) {
  std::vector<bool> free(cases.size(), false);
  for (std::size_t i = 0; i < cases.size(); ++i) {  // what a case needs stands before it
    const Case& c = cases[i];
    free[i] = !is_timed[i] && (!c.tets_of || free[*c.tets_of]) && (!c.coarser || free[*c.coarser]);
  }
  return free;
}

}  // namespace palpate::experiments
