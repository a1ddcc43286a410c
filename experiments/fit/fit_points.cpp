#include "experiments/fit/fit_points.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>

#include "core/base/number_text.h"
#include "experiments/plan_reader/plan.h"
#include "experiments/records/record_file.h"
#include "experiments/text/terminal.h"
#include "reference/door/moving_body.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

constexpr double kNone = std::numeric_limits<double>::infinity();
constexpr double kNearMiss = 1.05;  // of the tolerance
constexpr double kSameCost = 1.25;  // times: a table of compliances was timed at 40 to 54 us again and again

std::optional<double> number_at(const json& record, const std::string& pointer) {
  const json::json_pointer at(pointer);
  if (!record.contains(at) || !record.at(at).is_number()) return std::nullopt;
  const double value = record.at(at).get<double>();
  return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

/// Where the reference's record has its own error in a measure.
std::string own_error_key(const std::string& measure) {
  if (measure == "displacement_l2") return "/judge/reference_error";
  if (measure == "displacement_deformation") return "/judge/reference_error_deformation";
  if (measure == "displacement_energy") return "/judge/reference_error_energy";
  if (measure == "displacement_max") return "/judge/reference_error_max";
  if (measure == "displacement_l2_at") return "/judge/reference_error_l2_at";
  if (measure == "displacement_deformation_at") return "/judge/reference_error_deformation_at";
  if (measure == "displacement_max_at") return "/judge/reference_error_max_at";
  return "/judge/reference_error_pad_force";
}

std::optional<double> cost_of(const json& record, FitWork work) {
  if (work == FitWork::kFurther) return number_at(record, "/report/answer_s");
  if (work == FitWork::kSecond) return number_at(record, "/report/simulated_second_s");
  const auto kernel = number_at(record, "/kernel_s");
  if (!kernel) return std::nullopt;
  return *kernel + number_at(record, "/solved_on/simplify_s").value_or(0.0);
}

bool is_same(const FitCandidate& a, const FitCandidate& b) {
  return plan_label(a) == plan_label(b);
}

const FitPoint* find_same(const std::vector<FitPoint>& points, const FitCandidate& candidate) {
  return find_point(points, candidate.model.label, candidate.simplifier, candidate.ratio);
}

/// A share of one model and simplifier, as far as it is known.
struct KnownShare {
  const FitPoint* point;
  bool meets;      ///< on all loads where it was checked, on the scene itself else
  bool is_likely;  ///< it meets all on other loads too, as far as its model is known
  double cost_s;
  double expected;  ///< the worst error on all loads: as it was checked, else that on the scene times its
                    ///< model's growth
};

/// A model on fewer tetrahedra is expected to cost no more than on more: one time of the search alone may be
/// that of a busy machine, and would leave out what is cheap.
void lower_costs(std::vector<KnownShare>& shares, std::vector<FitProspect>& found) {
  double least = kNone;
  for (KnownShare& share : shares) {
    least = std::min(least, share.cost_s);
    if (std::isfinite(share.cost_s)) share.cost_s = least;
    for (FitProspect& each : found) {
      if (is_same(each.candidate, share.point->candidate)) each.cost_s = share.cost_s;
    }
  }
}

/// Whether what lies above a share may meet all, and cost less than it or than what does: it meets all and
/// the next one up does not, or both miss it and one of them by little (errors need not grow with the share).
bool is_worth_halving(const KnownShare& low, const KnownShare* high, double at_most) {
  if (high == nullptr || high->meets) return high == nullptr && low.meets;
  return low.meets || std::min(low.expected, high->expected) <= kNearMiss * at_most;
}

/// What a share above the greatest one costs: by its tetrahedra, or by how the cost fell from the share
/// below, if that is more. A table of compliances costs the same on whatever mesh.
double cost_above(const KnownShare& low, const KnownShare* below, double kept_ratio, double step) {
  const double by_tets = low.cost_s * kept_ratio;
  if (below == nullptr || !std::isfinite(below->cost_s)) return by_tets;
  const double from = below->point->candidate.removed();
  const double slope = (below->cost_s - low.cost_s) / (low.point->candidate.removed() - from);
  return std::max(by_tets, low.cost_s - slope * step);
}

/// The middle between a share and the next one up, `below` the one before it (null: none); null: nothing is
/// there.
std::optional<FitProspect> prospect_above(const KnownShare* below, const KnownShare& low,
                                          const KnownShare* high, const std::string& simplifier) {
  constexpr double kAll = 1.0;  // no mesh is left there
  const double from = low.point->candidate.removed();
  const double to = high == nullptr ? kAll : high->point->candidate.removed();
  if (to - from < 2.0 * kLeastShareStep) return std::nullopt;
  constexpr double kThousandth = 1000.0;  // names of shares have so many digits
  const double middle = std::round(kThousandth * 0.5 * (from + to)) / kThousandth;
  FitProspect found;
  found.candidate = low.point->candidate;
  found.candidate.simplifier = simplifier;
  found.candidate.ratio = middle;
  const double cost = low.cost_s;
  const bool is_between = high != nullptr && std::isfinite(high->cost_s);
  found.cost_s = is_between ? cost + (high->cost_s - cost) * (middle - from) / (to - from)
                            : cost_above(low, below, (kAll - middle) / (kAll - from), middle - from);
  found.expected_error = high == nullptr
                             ? kNone
                             : low.expected + (high->expected - low.expected) * (middle - from) / (to - from);
  found.is_likely = low.meets && low.is_likely;
  found.is_between = true;
  return found;
}

/// The likely ones first, the cheapest of each first; of what costs the same within noise as the cheapest
/// that is left, the most accurate.
void sort_prospects(std::vector<FitProspect>& found) {
  std::stable_sort(found.begin(), found.end(), [](const FitProspect& a, const FitProspect& b) {
    return a.is_likely != b.is_likely ? a.is_likely : a.cost_s < b.cost_s;
  });
  for (auto from = found.begin(); from != found.end();) {
    const auto to = std::find_if(from, found.end(), [&](const FitProspect& each) {
      return each.is_likely != from->is_likely || each.cost_s > kSameCost * from->cost_s;
    });
    std::stable_sort(from, to, [](const FitProspect& a, const FitProspect& b) {
      return a.expected_error < b.expected_error;
    });
    from = to;
  }
}

std::string scene_of(const json& record) {
  return record.value("/scene/name"_json_pointer, std::string());
}

/// Errors by scene: records stand in the order in which they were run.
using ErrorsByScene = std::map<std::string, double>;

/// Adds a repeat of the candidate on one scene.
void add_record(const json& record, const FitPlan& plan, const SceneRequirement& require,
                ErrorsByScene& errors, FitPoint& point) {
  const std::string scene = scene_of(record);
  const bool is_own = scene == "scene_0";
  if (record.value("outcome", "") != "accepted") {
    point.failure = record.value("outcome", "") + ": " + record.value("message", "");
    return;
  }
  if (is_own) {
    const json& mesh = record.contains("solved_on") ? record.at("solved_on") : record.at("mesh");
    point.case_id = record.at("case").get<std::string>();
    point.mesh = record.contains("solved_on") ? mesh.at("name").get<std::string>() : scene;
    point.vertices = mesh.at("vertices").get<std::size_t>();
    point.tets = mesh.at("tets").get<std::size_t>();
    point.memory_bytes = static_cast<std::uint64_t>(number_at(record, "/peak_rss_bytes").value_or(0.0));
    point.explicit_step_s = number_at(record, "/report/explicit_step_s");
    point.answer_s = number_at(record, "/report/answer_s");
    if (const auto cost = cost_of(record, plan.work); cost && !record.value("warmup", false))
      point.cost_s.push_back(*cost);
  }
  const auto error = number_at(record, "/judge/" + require.measure);
  if (error && record.value("repeat", 0) == 0) errors.emplace(scene, *error);
}

/// The largest error on the first `count` loads, with the reference's own.
double worst_of_first(const FitPoint& point, std::size_t count) {
  double worst = 0.0;
  for (std::size_t k = 0; k < count; ++k) worst = std::max(worst, point.error[k] + point.own_error[k]);
  return worst;
}

/// One that was refused on further loads, of the same model, that is no worse on those that both were run on;
/// null: none.
const FitPoint* find_better_refused(const FitPoint& point, const std::vector<FitPoint>& checked,
                                    const SceneRequirement& require) {
  if (point.is_confirmed) return nullptr;
  for (const FitPoint& other : checked) {
    if (!other.is_confirmed || other.candidate.model.label != point.candidate.model.label) continue;
    const std::size_t both = std::min(point.error.size(), other.error.size());
    if (worst_of_first(other, both) <= worst_of_first(point, both) && !why_not(other, require).empty())
      return &other;
  }
  return nullptr;
}

}  // namespace

double FitPoint::cost() const {
  if (stepping) return stepping->cost();
  return cost_s.empty() ? kNone : median(cost_s);
}

double FitPoint::worst_error() const {
  double worst = error.empty() ? kNone : 0.0;
  for (std::size_t k = 0; k < error.size(); ++k) worst = std::max(worst, error[k] + own_error[k]);
  return worst + (stepping ? stepping->error.value_or(kNone) : 0.0);
}

double FitPoint::estimated_error() const {
  if (error.size() < 2 || !std::isfinite(worst_error())) return worst_error();
  std::vector<double> certain = error;
  for (std::size_t k = 0; k < error.size(); ++k) certain[k] += own_error[k];
  const auto [least, most] = std::minmax_element(certain.begin(), certain.end());
  return worst_error() + (*most - *least) / static_cast<double>(error.size() - 1);
}

double FitPoint::known_error() const {
  return is_confirmed ? estimated_error() : worst_error();
}

std::vector<FitPoint> read_fit_points(const std::vector<json>& records, const FitPlan& plan,
                                      const SceneRequirement& require) {
  ErrorsByScene own_errors;
  std::map<std::string, ErrorsByScene> errors;
  std::map<std::string, FitPoint> points;
  for (const FitCandidate& candidate : plan.candidates) points[plan_label(candidate)].candidate = candidate;
  for (const json& record : records) {
    const std::string label = record.value("label", "");
    if (label == "reference") {
      const auto own = number_at(record, own_error_key(require.measure));
      own_errors[scene_of(record)] = own.value_or(kNone);
    }
    if (const auto at = points.find(label); at != points.end())
      add_record(record, plan, require, errors[label], at->second);
  }
  std::vector<FitPoint> found;
  for (const FitCandidate& candidate : plan.candidates) {
    FitPoint& point = points.at(plan_label(candidate));
    const ErrorsByScene& own = errors[plan_label(candidate)];
    for (std::size_t k = 0; k < plan.scenes.size(); ++k) {
      const std::string scene = "scene_" + std::to_string(k);
      const auto error = own.find(scene);
      if (error == own.end()) continue;
      const auto own_error = own_errors.find(scene);
      point.error.push_back(error->second);
      point.own_error.push_back(own_error == own_errors.end() ? kNone : own_error->second);
    }
    if (point.failure.empty() && point.error.empty()) point.failure = "not run";
    if (point.failure.empty() && point.cost_s.empty()) point.failure = "its cost could not be measured";
    if (point.failure.empty() && point.error.size() < plan.scenes.size())
      point.failure = "not run on all scenes";
    found.push_back(std::move(point));
  }
  return found;
}

std::string why_not(const FitPoint& point, const SceneRequirement& require) {
  if (!point.failure.empty()) return point.failure;
  std::string why;
  const auto add = [&](const std::string& text) { why += (why.empty() ? "" : "; ") + text; };
  if (point.worst_error() > require.at_most)
    add("error up to " + three_digits(100.0 * point.worst_error()) + "%");
  else if (point.is_confirmed && point.estimated_error() > require.at_most)
    add("error estimated to reach " + three_digits(100.0 * point.estimated_error()) +
        "% on loads like these (up to " + three_digits(100.0 * point.worst_error()) + "% seen)");
  if (point.cost() > budget_of(require))
    add("takes " + time_text(point.cost()) + " of " + time_text(budget_of(require)));
  if (require.memory_bytes && point.memory_bytes > *require.memory_bytes)
    add("takes " + std::to_string(point.memory_bytes) + " bytes, over " +
        std::to_string(*require.memory_bytes));
  return why;
}

std::string why_not_chosen(const FitPoint& point, const std::vector<FitPoint>& checked,
                           const SceneRequirement& require) {
  std::string why = why_not(point, require);
  if (!why.empty()) return why;
  const FitPoint* refused = find_better_refused(point, checked, require);
  return refused == nullptr ? ""
                            : "no better than " + refused->candidate.name() + ", which further loads refused";
}

std::vector<const FitPoint*> choose_cheapest(const std::vector<FitPoint>& points,
                                             const SceneRequirement& require) {
  std::vector<const FitPoint*> good;
  for (const FitPoint& point : points) {
    if (why_not(point, require).empty()) good.push_back(&point);
  }
  std::stable_sort(good.begin(), good.end(),
                   [](const FitPoint* a, const FitPoint* b) { return a->cost() < b->cost(); });
  return good;
}

std::vector<const FitPoint*> take_finalists(std::vector<const FitPoint*>& good, std::size_t count) {
  if (good.empty() || count == 0) return {};
  const auto answer = [](const FitPoint* point) { return point->answer_s.value_or(kNone); };
  const auto least = std::min_element(
      good.begin(), good.end(), [&](const FitPoint* a, const FitPoint* b) { return answer(a) < answer(b); });
  const auto last = good.begin() + static_cast<std::ptrdiff_t>(std::min(count, good.size()));
  if (least > last - 1 && std::isfinite(answer(*least))) std::rotate(last - 1, least, least + 1);
  std::vector<const FitPoint*> taken(good.begin(), last);
  good.erase(good.begin(), last);
  return taken;
}

bool is_modal(const FitCandidate& candidate) {
  return candidate.model.method == reference::kModalModel;
}

const FitPoint* take_modal_finalist(std::vector<const FitPoint*>& good, double at_most) {
  constexpr double kRestHalf = 0.5;  // of the tolerance
  auto taken = good.end();
  for (auto at = good.begin(); at != good.end(); ++at) {
    if (!is_modal((*at)->candidate)) continue;
    if ((*at)->worst_error() <= kRestHalf * at_most) {
      taken = at;
      break;
    }
    if (taken == good.end() || (*at)->worst_error() < (*taken)->worst_error()) taken = at;
  }
  if (taken == good.end()) return nullptr;
  const FitPoint* found = *taken;
  good.erase(taken);
  return found;
}

double growth_on_loads(const std::vector<FitPoint>& searched, const std::vector<FitPoint>& checked,
                       const std::string& model) {
  double growth = 1.0;
  for (const FitPoint& point : checked) {
    if (point.candidate.model.label != model || point.error.empty()) continue;
    const FitPoint* own = find_same(searched, point.candidate);
    const double alone = own != nullptr && !own->error.empty()
                             ? own->worst_error()
                             : point.error.front() + point.own_error.front();
    if (alone > 0.0 && std::isfinite(point.known_error()))
      growth = std::max(growth, point.known_error() / alone);
  }
  return growth;
}

std::vector<FitProspect> list_prospects(const std::vector<FitPoint>& searched,
                                        const std::vector<FitPoint>& checked, const FitCandidates& candidates,
                                        const SceneRequirement& require, double most_cost_s) {
  std::vector<FitProspect> found;
  // By model, all that is known of it: a check says more than the search.
  std::map<std::string, std::vector<KnownShare>> known;
  for (const FitPoint& point : checked) {
    const FitPoint* refused = find_better_refused(point, checked, require);
    const bool meets = refused == nullptr && why_not(point, require).empty();
    const double expected =
        refused == nullptr ? point.known_error() : std::max(point.worst_error(), refused->known_error());
    known[point.candidate.model.label].push_back({&point, meets, true, point.cost(), expected});
  }
  for (const FitPoint& point : searched) {
    if (find_same(checked, point.candidate) != nullptr) continue;
    const std::string& model = point.candidate.model.label;
    const bool meets = why_not(point, require).empty();
    const double expected = point.worst_error() * growth_on_loads(searched, checked, model);
    const bool is_likely = meets && expected <= require.at_most;
    known[model].push_back({&point, meets, is_likely, point.cost(), expected});
    if (meets) found.push_back({point.candidate, point.cost(), expected, is_likely, false});
  }
  for (auto& [model, shares] : known) {
    std::stable_sort(shares.begin(), shares.end(), [](const KnownShare& a, const KnownShare& b) {
      return a.point->candidate.removed() < b.point->candidate.removed();
    });
    for (const FitSimplifier& simplifier : candidates.simplifiers) {
      if (simplifier.grade) continue;
      std::vector<KnownShare> own;
      std::copy_if(shares.begin(), shares.end(), std::back_inserter(own), [&](const KnownShare& share) {
        const FitCandidate& candidate = share.point->candidate;
        return !candidate.ratio || candidate.simplifier == simplifier.label;
      });
      lower_costs(own, found);
      for (std::size_t k = 0; k < own.size(); ++k) {
        const KnownShare* below = k > 0 ? &own[k - 1] : nullptr;
        const KnownShare* next = k + 1 < own.size() ? &own[k + 1] : nullptr;
        if (!is_worth_halving(own[k], next, require.at_most)) continue;
        if (const auto middle = prospect_above(below, own[k], next, simplifier.label))
          found.push_back(*middle);
      }
    }
  }
  const auto is_out = [&](const FitProspect& each) {
    return !(each.cost_s < most_cost_s) || find_same(checked, each.candidate) != nullptr;
  };
  found.erase(std::remove_if(found.begin(), found.end(), is_out), found.end());
  sort_prospects(found);
  return found;
}

std::vector<FitCandidate> take_prospects(const std::vector<FitProspect>& prospects, std::size_t count,
                                         bool has_choice) {
  std::vector<FitCandidate> taken;
  const auto take = [&](std::size_t most, bool between) {
    for (const FitProspect& each : prospects) {
      const bool is_new = std::none_of(taken.begin(), taken.end(), [&](const FitCandidate& other) {
        return is_same(other, each.candidate);
      });
      if (taken.size() < most && is_new && (between || !each.is_between)) taken.push_back(each.candidate);
    }
  };
  if (!has_choice) take((count + 1) / 2, false);
  take(count, true);
  return taken;
}

const FitPoint* find_nearest(const std::vector<FitPoint>& points, const SceneRequirement& require) {
  const FitPoint* nearest = nullptr;
  double least = kNone;
  const double budget = budget_of(require);
  for (const FitPoint& point : points) {
    if (!point.failure.empty() || !std::isfinite(point.worst_error())) continue;
    if (find_better_refused(point, points, require) != nullptr) continue;
    const double over_error = std::max(1.0, point.known_error() / require.at_most);
    const double over_cost = std::isfinite(budget) ? std::max(1.0, point.cost() / budget) : 1.0;
    const double over = over_error * over_cost;
    if (over < least || (over == least && nearest != nullptr && point.cost() < nearest->cost())) {
      least = over;
      nearest = &point;
    }
  }
  return nearest;
}

const FitPoint* find_point(const std::vector<FitPoint>& points, const std::string& label,
                           const std::string& simplifier, std::optional<double> ratio) {
  for (const FitPoint& point : points) {
    const FitCandidate& own = point.candidate;
    if (own.model.label == label && own.simplifier == simplifier && own.ratio == ratio) return &point;
  }
  return nullptr;
}

}  // namespace palpate::experiments
