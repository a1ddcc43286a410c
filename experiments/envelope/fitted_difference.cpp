#include "experiments/envelope/fitted_difference.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "core/base/number_text.h"
#include "experiments/envelope/envelope_axes.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

/// What was written anew by another hand is the same but for rounding.
constexpr double kSameShare = 1e-9;
constexpr double kSameAngle = 1e-6;
/// Sizes that a fit's unseen loads have to each other, at most: 1.3 to 0.7.
constexpr double kMostUneven = 1.3 / 0.7;

bool is_same(const json& a, const json& b) {
  if (a.is_number() && b.is_number()) {
    const auto x = a.get<double>();
    const auto y = b.get<double>();
    return std::abs(x - y) <= kSameShare * std::max(std::abs(x), std::abs(y));
  }
  if (!a.is_array() || !b.is_array()) return a == b;
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), is_same);
}

std::string shown(const json& value) {
  if (value.is_null()) return "none";
  if (value.is_number()) return short_number(value.get<double>());
  if (value.is_string()) return value.get<std::string>();
  if (!value.is_array()) return value.dump();
  std::string text;
  for (const json& each : value) text += (text.empty() ? "" : ", ") + shown(each);
  return "[" + text + "]";
}

/// Adds what differs, key by key: "support 1: elastic_pa_per_m is 2000, where 1000 was fitted".
void compare(const std::string& what, const json& fitted, const json& own, std::vector<std::string>& lines) {
  if (!fitted.is_object() || !own.is_object()) {
    if (!is_same(fitted, own))
      lines.push_back(what + " is " + shown(own) + ", where " + shown(fitted) + " was fitted");
    return;
  }
  std::set<std::string> keys;
  for (const json* each : {&fitted, &own}) {
    for (const auto& [key, value] : each->items()) keys.insert(key);
  }
  for (const std::string& key : keys)
    compare(what + (what.ends_with(':') ? " " : ".") + key, fitted.value(key, json()), own.value(key, json()),
            lines);
}

std::string numbered(const char* what, std::size_t k) {
  return std::string(what) + " " + std::to_string(k + 1);
}

json without(json value, std::initializer_list<const char*> keys) {
  for (const char* key : keys) value.erase(key);
  return value;
}

json with_defaults(json defaults, const json& given) {
  defaults.merge_patch(given);
  return defaults;
}

/// A support with the directions that a hard one holds in.
json whole_support(json clamp) {
  if (!clamp.contains("elastic_pa_per_m")) {
    json axes = clamp.value("axes", json{"x", "y", "z"});
    std::sort(axes.begin(), axes.end());
    clamp["axes"] = std::move(axes);
  }
  return clamp;
}

void compare_supports(const json& fitted, const json& own, std::vector<std::string>& lines) {
  const json before = fitted.value("clamp", json::array());
  const json now = own.value("clamp", json::array());
  if (before.size() != now.size()) {
    lines.push_back("it has " + std::to_string(now.size()) + " supports (clamp), where " +
                    std::to_string(before.size()) + " were fitted");
    return;
  }
  for (std::size_t k = 0; k < now.size(); ++k)
    compare(numbered("support", k) + ":", whole_support(before[k]), whole_support(now[k]), lines);
}

std::vector<double> vector_of_load(const json& load) {
  if (load.contains("gravity_m_s2")) return load.at("gravity_m_s2").get<std::vector<double>>();
  return (load.contains("displace") ? load.at("displace").at("by_m") : load.at("force").at("total_n"))
      .get<std::vector<double>>();
}

double length_of(const std::vector<double>& v) {
  return std::hypot(v.at(0), v.at(1), v.at(2));
}

double degrees_between(const std::vector<double>& a, const std::vector<double>& b) {
  double along = 0.0;
  for (std::size_t k = 0; k < 3; ++k) along += a.at(k) * b.at(k);
  const std::vector<double> across{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                                   a[0] * b[1] - a[1] * b[0]};
  return 180.0 / std::numbers::pi * std::atan2(length_of(across), along);
}

/// What a profile is but its times.
json shape_of(const json& load) {
  if (!load.contains("profile")) return nullptr;
  return {{"shares", load.at("profile").at("shares")}, {"smooth", load.at("profile").value("smooth", false)}};
}

void compare_load(const std::string& what, const json& fitted, const json& own,
                  std::vector<std::string>& lines) {
  for (const char* kind : {"displace", "force"}) {
    if (own.contains(kind))
      compare(what + ":", without(fitted.at(kind), {"by_m", "total_n"}),
              without(own.at(kind), {"by_m", "total_n"}), lines);
  }
  const std::vector<double> before = vector_of_load(fitted);
  const std::vector<double> now = vector_of_load(own);
  if (length_of(before) > 0.0 && length_of(now) > 0.0) {
    const double turn = degrees_between(before, now);
    if (turn * std::numbers::pi / 180.0 > kSameAngle)
      lines.push_back(what + " is turned by " + three_digits(turn) + " degrees");
  }
  const json shape = shape_of(own);
  const json fitted_shape = shape_of(fitted);
  if (shape.is_null() && !fitted_shape.is_null()) {
    lines.push_back(what + " is there all at once, where it was fitted with a profile");
  } else if (!shape.is_null() && fitted_shape.is_null()) {
    lines.push_back(what + " has a profile, where it was fitted without");
  } else {
    compare(what + ": profile", fitted_shape, shape, lines);
  }
  if (fitted.value("from_s", 0.0) > 0.0 && !(own.value("from_s", 0.0) > 0.0))
    compare(what + ": from_s", fitted.at("from_s"), own.value("from_s", json()), lines);
  if (fitted.contains("until_s") != own.contains("until_s"))
    compare(what + ": until_s", fitted.value("until_s", json()), own.value("until_s", json()), lines);
}

/// All loads may be larger together; which is the larger of two is part of what was fitted.
void compare_sizes(const json& fitted, const json& own, std::vector<std::string>& lines) {
  struct Size {
    double ratio = 1.0;
    std::size_t load = 0;
  };
  std::optional<Size> least;
  std::optional<Size> most;
  for (std::size_t k = 0; k < own.size(); ++k) {
    const double before = length_of(vector_of_load(fitted[k]));
    const double now = length_of(vector_of_load(own[k]));
    if (!(before > 0.0)) {
      if (now > 0.0) lines.push_back(numbered("load", k) + " does something, where it was fitted as none");
      continue;
    }
    const Size size{now / before, k};
    if (!least || size.ratio < least->ratio) least = size;
    if (!most || size.ratio > most->ratio) most = size;
  }
  if (!most || most->ratio <= kMostUneven * (1.0 + kSameShare) * least->ratio) return;
  lines.push_back(numbered("load", least->load) + " is " + three_digits(least->ratio) +
                  " times the fitted one and " + numbered("load", most->load) + " " +
                  three_digits(most->ratio) + " times: their share in each other was fitted, too");
}

/// How a scene is stepped, with what is left out.
json whole_stepping(const json& dynamic) {
  json out = with_defaults({{"engine", "auto"},
                            {"precision", "double"},
                            {"solver", {{"iterations", 1000}, {"tolerance", 1e-8}, {"substeps", 1}}},
                            {"damping",
                             {{"stiffness_s", 0.0},
                              {"mass_per_s", 0.0},
                              {"spring_n_s_per_m", 0.0},
                              {"vertex_n_s_per_m", 0.0},
                              {"springs", "axial"}}}},
                           dynamic);
  return without(std::move(out),
                 {"time_step_s", "safety", "duration_s", "allow_unstable", "frames", "samples", "probes_m"});
}

void compare_analyses(const json& fitted, const json& own, std::vector<std::string>& lines) {
  if (fitted.is_object() != own.is_object()) {
    lines.emplace_back(own.is_object() ? "it moves (analysis), where it was fitted at rest"
                                       : "it is at rest (analysis), where it was fitted in motion");
    return;
  }
  if (!own.is_object()) return;
  const json& before = fitted.at("dynamic");
  const json& now = own.at("dynamic");
  compare("analysis:", whole_stepping(before), whole_stepping(now), lines);
  const json step = now.value("time_step_s", json());
  const json fitted_step = before.value("time_step_s", json());
  if (step.is_string()) {
    if (!fitted_step.is_string()) {
      compare("analysis: time_step_s", fitted_step, step, lines);
    } else {
      compare("analysis: safety", before.value("safety", 0.9), now.value("safety", 0.9), lines);
    }
  }
  if (now.at("duration_s").get<double>() > (1.0 + kSameShare) * before.at("duration_s").get<double>())
    compare("analysis: duration_s", before.at("duration_s"), now.at("duration_s"), lines);
}

void compare_requirements(const json& fitted, const json& own, std::vector<std::string>& lines) {
  if (!fitted.contains("require") || !own.contains("require")) return;
  const json& before = fitted.at("require").at("error");
  const json& now = own.at("require").at("error");
  if (now.at("at_most").get<double>() < (1.0 - kSameShare) * before.at("at_most").get<double>())
    compare("require: error.at_most", before.at("at_most"), now.at("at_most"), lines);
  compare("require: error", without(before, {"at_most"}), without(now, {"at_most"}), lines);
}

}  // namespace

std::vector<std::string> differences_between(const json& fitted, const json& own) {
  std::vector<std::string> lines;
  compare("mesh:", without(fitted.at("mesh"), {"file", "regions_from"}),
          without(own.at("mesh"), {"file", "regions_from"}), lines);
  compare("strain", fitted.value("strain", "small"), own.value("strain", "small"), lines);
  compare_supports(fitted, own, lines);
  const json& loads = own.at("load");
  for (std::size_t k = 0; k < loads.size(); ++k)
    compare_load(numbered("load", k), fitted.at("load").at(k), loads[k], lines);
  compare_sizes(fitted.at("load"), loads, lines);
  compare_analyses(fitted.at("analysis"), own.at("analysis"), lines);
  compare_requirements(fitted, own, lines);
  return lines;
}

std::optional<double> times_shortened(const json& fitted, const json& own) {
  std::optional<double> most;
  const auto add = [&](double before, double now) {
    if (before > 0.0 && now > 0.0) most = std::max(most.value_or(0.0), before / now);
  };
  const json& loads = own.at("load");
  for (std::size_t k = 0; k < loads.size(); ++k) {
    const json& now = loads[k];
    const json& before = fitted.at("load").at(k);
    const double from = now.value("from_s", 0.0);
    const double fitted_from = before.value("from_s", 0.0);
    add(fitted_from, from);
    if (now.contains("until_s") && before.contains("until_s"))
      add(before.at("until_s").get<double>() - fitted_from, now.at("until_s").get<double>() - from);
    if (!now.contains("profile") || !before.contains("profile")) continue;
    const auto times = now.at("profile").at("times_s").get<std::vector<double>>();
    const auto fitted_times = before.at("profile").at("times_s").get<std::vector<double>>();
    if (times.size() != fitted_times.size()) continue;
    for (std::size_t i = 1; i < times.size(); ++i)
      add(fitted_times[i] - fitted_times[i - 1], times[i] - times[i - 1]);
  }
  return most;
}

}  // namespace palpate::experiments
