#include "experiments/plan_reader/case_list.h"

#include <algorithm>
#include <map>

#include "core/base/error.h"
#include "experiments/plan_reader/case_id.h"
#include "experiments/plan_reader/plan_contestant.h"
#include "experiments/text/nearest_name.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

/// One point of the sweep as it applies to one contestant.
struct Point {
  json sweep = json::object();
  std::map<std::string, GivenOption> set;
  Stop stop;
  std::optional<std::size_t> simplifier;
  Stop simplifier_stop;
};

std::string value_text(const json& value) {
  return value.is_string() ? value.get<std::string>() : value.dump();
}

class CaseBuilder {
 public:
  CaseBuilder(const Plan& plan, const Registry& registry) : plan_(plan), registry_(registry) {
    for (std::size_t i = 0; i < plan.contestants.size(); ++i) place(i);
  }

  std::vector<Case> build() {
    for (const std::string& name : plan_.subjects) {
      first_of_subject_ = cases_.size();
      for (const std::size_t contestant : order_) add_cases(name, contestant);
      ++subject_;
    }
    return std::move(cases_);
  }

 private:
  std::size_t index_of(const std::string& label) const {
    for (std::size_t i = 0; i < plan_.contestants.size(); ++i) {
      if (plan_.contestants[i].label == label) return i;
    }
    throw ContractError("cross_cases: unknown label");
  }

  const std::string* referred_label(std::size_t contestant) const {
    const auto& stop = plan_.contestants[contestant].stop;
    return stop && stop->kind == StopKind::kTetsOf ? &stop->of : nullptr;
  }

  /// Puts a contestant into the order, after the one that it refers to.
  void place(std::size_t contestant) {
    if (std::find(order_.begin(), order_.end(), contestant) != order_.end()) return;
    if (const std::string* label = referred_label(contestant)) place(index_of(*label));
    order_.push_back(contestant);
  }

  /// A short plan may cross its lists to more than any memory holds.
  void check_count(std::size_t cases) const {
    constexpr std::size_t kMostCases = 1'000'000;
    if (cases > kMostCases)
      throw InputError(plan_.file.string(), 0, "at most " + std::to_string(kMostCases) + " cases", "more");
  }

  bool has_free_option(std::size_t contestant, const std::string& option) const {
    const PlanContestant& c = plan_.contestants[contestant];
    const bool seeded = option == "seed" && !c.seeds.empty();
    return !seeded && c.set.count(option) == 0 &&
           registry_.find(c.method)->method->find_option(option) != nullptr;
  }

  /// Whether the axis changes what this contestant does, by itself or through the label it refers to.
  bool applies(std::size_t contestant, const SweepAxis& axis) const {
    if (axis.is_problem()) return true;
    if (axis.is_stop() && !plan_.simplifiers.empty()) return false;  // theirs, see below
    const bool own = axis.is_option() ? has_free_option(contestant, axis.option())
                                      : !plan_.contestants[contestant].stop.has_value();
    if (own) return true;
    const std::string* label = referred_label(contestant);
    return label != nullptr && applies(index_of(*label), axis);
  }

  std::vector<Point> points_of(std::size_t contestant) const {
    const PlanContestant& c = plan_.contestants[contestant];
    Point start;
    start.set = c.set;
    if (c.stop) start.stop = *c.stop;
    std::vector<Point> points{start};
    for (const SweepAxis& axis : plan_.sweep) {
      if (!applies(contestant, axis)) continue;
      check_count(points.size() * axis.values.size());
      std::vector<Point> crossed;
      for (const Point& point : points) {
        for (std::size_t i = 0; i < axis.values.size(); ++i) {
          Point next = point;
          next.sweep[axis.name] = axis.values[i];
          if (axis.is_option()) {
            if (has_free_option(contestant, axis.option())) next.set[axis.option()] = axis.texts[i];
          } else if (axis.is_stop() && !c.stop) {
            next.stop = {axis.stop_kind(), axis.values[i].get<double>(), ""};
          }
          crossed.push_back(std::move(next));
        }
      }
      points = std::move(crossed);
    }
    if (!plan_.simplifiers.empty()) points = cross_simplifiers(points);
    std::erase_if(points, [&](const Point& point) { return !is_at(c, point.sweep); });
    if (points.empty())
      throw InputError(plan_.file.string() + ": \"at\" of \"" + c.label + "\" leaves nothing of the sweep");
    return points;
  }

  /// An axis that a point does not have, such as the ratio of a mesh that is not simplified, excludes
  /// nothing.
  static bool is_at(const PlanContestant& c, const json& sweep) {
    return std::all_of(c.at.begin(), c.at.end(), [&sweep](const auto& place) {
      const std::vector<json>& values = place.second;
      return !sweep.contains(place.first) ||
             std::find(values.begin(), values.end(), sweep.at(place.first)) != values.end();
    });
  }

  /// Each point with each simplifier, and one without a stop of its own with each swept one.
  std::vector<Point> cross_simplifiers(const std::vector<Point>& points) const {
    std::vector<Point> crossed;
    for (const Point& point : points) {
      for (std::size_t i = 0; i < plan_.simplifiers.size(); ++i) {
        const PlanContestant& simplifier = plan_.simplifiers[i];
        Point next = point;
        next.simplifier = i;
        next.sweep["simplify"] = simplifier.label;
        if (simplifier.stop) next.simplifier_stop = *simplifier.stop;
        const bool is_free = !simplifier.method.empty() && !simplifier.stop;
        const auto axis = std::find_if(plan_.sweep.begin(), plan_.sweep.end(),
                                       [](const SweepAxis& a) { return a.is_stop(); });
        if (!is_free || axis == plan_.sweep.end()) {
          crossed.push_back(std::move(next));
          continue;
        }
        for (const json& value : axis->values) {
          next.sweep[axis->name] = value;
          next.simplifier_stop = {axis->stop_kind(), value.get<double>(), ""};
          crossed.push_back(next);
        }
      }
    }
    return crossed;
  }

  /// The case of `label` on this mesh whose sweep values are all among `sweep`.
  std::size_t find_referred(const std::string& label, const json& sweep) const {
    for (std::size_t i = first_of_subject_; i < cases_.size(); ++i) {
      if (plan_.contestants[cases_[i].contestant].label != label) continue;
      const json& own = cases_[i].sweep;
      const bool matches = std::all_of(own.items().begin(), own.items().end(), [&](const auto& item) {
        return sweep.contains(item.key()) && sweep.at(item.key()) == item.value();
      });
      if (matches) return i;
    }
    throw ContractError("cross_cases: tets_of meets no case");
  }

  void add_cases(const std::string& subject, std::size_t contestant) {
    const PlanContestant& c = plan_.contestants[contestant];
    if (!runs_on(c, subject)) return;
    const MethodSpec& method = *registry_.find(c.method)->method;
    for (const Point& point : points_of(contestant)) {
      Case base;
      base.id = safe_part(subject) + "/" + safe_part(c.label);
      base.subject = subject_;
      base.contestant = contestant;
      base.stop = point.stop;
      base.sweep = point.sweep;
      base.simplifier = point.simplifier;
      base.simplifier_stop = point.simplifier_stop;
      for (const auto& [name, value] : point.sweep.items())
        base.id += "/" + case_part(name, value_text(value));
      base.options = resolve_options(method, point.set);
      if (base.stop.kind == StopKind::kTetsOf) base.tets_of = find_referred(base.stop.of, base.sweep);
      check_count(cases_.size() + std::max<std::size_t>(1, c.seeds.size()));
      if (c.seeds.empty()) cases_.push_back(base);
      for (const std::int64_t seed : c.seeds) {
        Case seeded = base;
        seeded.seed = seed;
        seeded.options["seed"] = seed;
        seeded.id += "/seed=" + std::to_string(seed);
        cases_.push_back(std::move(seeded));
      }
    }
  }

  const Plan& plan_;
  const Registry& registry_;
  std::vector<std::size_t> order_;
  std::vector<Case> cases_;
  std::size_t subject_ = 0;
  std::size_t first_of_subject_ = 0;
};

}  // namespace

std::vector<Case> cross_cases(const Plan& plan, const Registry& registry) {
  return CaseBuilder(plan, registry).build();
}

int repeats_of(const RunSettings& run, const Case& c) {
  return c.seed && run.seed_repeats > 0 ? run.seed_repeats : run.repeats;
}

int most_repeats_of(const RunSettings& run, const Case& c) {
  const bool has_own = c.seed && run.seed_repeats > 0;
  return run.until_width && !has_own ? run.most_repeats : repeats_of(run, c);
}

std::vector<std::size_t> with_needed_cases(const std::vector<Case>& cases, std::vector<bool> wanted) {
  for (std::size_t i = cases.size(); i-- > 0;) {
    for (const auto& needed : {cases[i].tets_of, cases[i].coarser}) {
      if (wanted[i] && needed) wanted[*needed] = true;
    }
  }
  std::vector<std::size_t> selected;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    if (wanted[i]) selected.push_back(i);
  }
  return selected;
}

std::vector<std::size_t> select_cases(const std::vector<Case>& cases, const std::string& id) {
  std::vector<bool> wanted(cases.size(), false);
  std::vector<std::string> ids;
  bool found = false;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    ids.push_back(cases[i].id);
    wanted[i] = cases[i].id == id || cases[i].id.rfind(id + "/", 0) == 0;
    found = found || wanted[i];
  }
  if (!found) throw InputError("--case: there is no case \"" + id + "\"" + nearest_hint(id, ids));
  return with_needed_cases(cases, std::move(wanted));
}

}  // namespace palpate::experiments
