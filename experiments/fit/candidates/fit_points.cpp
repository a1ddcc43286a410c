#include "experiments/fit/candidates/fit_points.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "experiments/plan_reader/plan.h"
#include "experiments/records/record_file.h"
#include "experiments/text/figure_text.h"
#include "experiments/text/terminal.h"
#include "reference/door/moving_body.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

constexpr double kNone = std::numeric_limits<double>::infinity();
/// Further loads may add so much less to the errors on meshes by another simplifier.
constexpr double kOtherMeshes = 1.05;

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
  constexpr double kOneIn = 10.0;  // bounds may be exceeded
  const std::size_t harmless = std::max(looked_at, confirmed_on.size()) - confirmed_on.size();
  const auto others = static_cast<double>(error.size() + harmless - 1);
  return worst_error() + (std::pow(kOneIn, 1.0 / others) - 1.0) * (*most - *least);
}

double FitPoint::known_error() const {
  return is_confirmed() ? estimated_error() : worst_error();
}

std::vector<std::optional<double>> read_errors(const std::vector<json>& records, const FitPlan& plan,
                                               const SceneRequirement& require,
                                               const FitCandidate& candidate) {
  ErrorsByScene errors;
  const std::string label = plan_label(candidate);
  for (const json& record : records) {
    if (record.value("label", "") != label || record.value("outcome", "") != "accepted") continue;
    if (const auto error = number_at(record, "/judge/" + require.measure))
      errors.emplace(scene_of(record), *error);
  }
  std::vector<std::optional<double>> found(plan.scenes.size());
  for (std::size_t k = 0; k < found.size(); ++k) {
    const auto error = errors.find("scene_" + std::to_string(k));
    if (error != errors.end()) found[k] = error->second;
  }
  return found;
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
    add("error up to " + percent_text(point.worst_error()));
  else if (point.is_confirmed() && point.estimated_error() > require.at_most)
    add("error estimated to reach " + percent_text(point.estimated_error()) + " on loads like these (up to " +
        percent_text(point.worst_error()) + " seen)");
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

const FitPoint* find_better_refused(const FitPoint& point, const std::vector<FitPoint>& checked,
                                    const SceneRequirement& require) {
  if (point.is_confirmed()) return nullptr;
  for (const FitPoint& other : checked) {
    if (!other.is_confirmed() || other.candidate.model.label != point.candidate.model.label) continue;
    const std::size_t both = std::min(point.error.size(), other.error.size());
    const double own = worst_of_first(point, both);
    const double better = worst_of_first(other, both);
    if (own < better || why_not(other, require).empty()) continue;
    const bool has_same_meshes =
        !other.candidate.ratio || point.candidate.is_share_of(other.candidate.simplifier);
    const double most = require.at_most * (has_same_meshes ? 1.0 : kOtherMeshes);
    if (other.known_error() * own > most * better) return &other;
  }
  return nullptr;
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

const FitPoint* find_safest(const FitPoint& point, const std::vector<FitPoint>& checked,
                            const SceneRequirement& require) {
  const FitPoint* safest = &point;
  for (const FitPoint* other : choose_cheapest(checked, require)) {
    if (other->cost() > kSameCost * point.cost()) break;
    const bool is_safer = other->worst_error() < safest->worst_error();
    if (is_safer && why_not_chosen(*other, checked, require).empty()) safest = other;
  }
  return safest;
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

const FitPoint* find_point(const std::vector<FitPoint>& points, const FitCandidate& candidate) {
  return find_point(points, candidate.model.label, candidate.simplifier, candidate.ratio);
}

}  // namespace palpate::experiments
