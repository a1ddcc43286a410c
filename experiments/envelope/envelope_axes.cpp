#include "experiments/envelope/envelope_axes.h"

#include <algorithm>
#include <cmath>

namespace palpate::experiments {
namespace {

using nlohmann::json;

struct AxisFacts {
  const char* name;
  const char* text;
  double most;
};

constexpr std::array<AxisFacts, kEnvelopeAxes.size()> kFacts{
    {{"stiffer", "Young's modulus times", 100.0},
     {"lighter", "density divided by", 100.0},
     {"larger", "all loads times", 30.0},
     {"faster", "times of the loads divided by", 100.0},
     {"step", "time step times", 100.0}}};

const AxisFacts& facts_of(EnvelopeAxis axis) {
  return kFacts.at(static_cast<std::size_t>(axis));
}

bool is_moving(const json& scene) {
  return scene.at("analysis").is_object();
}

bool has_times(const json& load) {
  return load.contains("profile") || load.contains("until_s") || load.contains("from_s");
}

/// Where a load keeps its vector.
json::json_pointer vector_key(const json& load) {
  if (load.contains("gravity_m_s2")) return json::json_pointer("/gravity_m_s2");
  return json::json_pointer(load.contains("displace") ? "/displace/by_m" : "/force/total_n");
}

void scale_list(json& list, double factor) {
  for (json& value : list) value = value.get<double>() * factor;
}

void scale_times(json& load, double factor) {
  if (load.contains("profile")) scale_list(load["profile"]["times_s"], factor);
  for (const char* key : {"from_s", "until_s"}) {
    if (load.contains(key)) load[key] = load[key].get<double>() * factor;
  }
}

double size_of(const json& list) {
  double sum = 0.0;
  for (const json& value : list) sum += value.get<double>() * value.get<double>();
  return std::sqrt(sum);
}

/// The shortest time in which a load's share changes; nothing for one that is there all at once and stays.
std::optional<double> rise_of(const json& load) {
  std::optional<double> least;
  const auto add = [&](double seconds) {
    if (seconds > 0.0) least = least ? std::min(*least, seconds) : seconds;
  };
  if (load.contains("profile")) {
    const json& times = load["profile"].at("times_s");
    const json& shares = load["profile"].at("shares");
    for (std::size_t k = 1; k < times.size(); ++k) {
      if (shares[k] != shares[k - 1]) add(times[k].get<double>() - times[k - 1].get<double>());
    }
  }
  if (load.contains("until_s")) add(load["until_s"].get<double>() - load.value("from_s", 0.0));
  return least;
}

}  // namespace

const char* axis_name(EnvelopeAxis axis) {
  return facts_of(axis).name;
}

const char* axis_text(EnvelopeAxis axis) {
  return facts_of(axis).text;
}

double most_factor(EnvelopeAxis axis) {
  return facts_of(axis).most;
}

bool changes_rest(EnvelopeAxis axis, const json& scene) {
  if (axis == EnvelopeAxis::kStiffer || axis == EnvelopeAxis::kLarger) return true;
  const json& loads = scene.at("load");
  return axis == EnvelopeAxis::kLighter && std::any_of(loads.begin(), loads.end(), [](const json& load) {
           return load.contains("gravity_m_s2");
         });
}

std::vector<EnvelopeAxis> axes_of(const json& scene) {
  if (!is_moving(scene)) return {EnvelopeAxis::kStiffer, EnvelopeAxis::kLarger};
  std::vector<EnvelopeAxis> axes(kEnvelopeAxes.begin(), kEnvelopeAxes.end());
  const json& loads = scene.at("load");
  if (std::none_of(loads.begin(), loads.end(), has_times))
    axes.erase(std::find(axes.begin(), axes.end(), EnvelopeAxis::kFaster));
  return axes;
}

json scaled_scene(const json& scene, EnvelopeAxis axis, double factor) {
  json out = scene;
  json& material = out["material"];
  switch (axis) {
    case EnvelopeAxis::kStiffer:
      material["young_modulus_pa"] = material["young_modulus_pa"].get<double>() * factor;
      break;
    case EnvelopeAxis::kLighter:
      material["density_kg_m3"] = material["density_kg_m3"].get<double>() / factor;
      break;
    case EnvelopeAxis::kLarger:
      out["strain"] = "large";
      for (json& load : out["load"]) scale_list(load[vector_key(load)], factor);
      break;
    case EnvelopeAxis::kFaster:
      for (json& load : out["load"]) scale_times(load, 1.0 / factor);
      break;
    case EnvelopeAxis::kStep:
      if (is_moving(out)) {
        json& step = out["analysis"]["dynamic"]["time_step_s"];
        if (step.is_number()) step = step.get<double>() * factor;
      }
      break;
  }
  return out;
}

EnvelopePlace place_of(const json& scene) {
  EnvelopePlace place;
  const json& material = scene.at("material");
  place.young_modulus_pa = material.at("young_modulus_pa").get<double>();
  place.density_kg_m3 = material.value("density_kg_m3", 0.0);
  place.poisson_ratio = material.at("poisson_ratio").get<double>();
  for (const json& load : scene.at("load")) {
    const json::json_pointer key = vector_key(load);
    place.load_kinds.push_back(load.contains("gravity_m_s2") ? "gravity"
                               : load.contains("displace")   ? "displace"
                                                             : "force");
    place.load_sizes.push_back(size_of(load.at(key)));
    if (const auto rise = rise_of(load)) place.rise_s = std::min(place.rise_s.value_or(*rise), *rise);
  }
  if (is_moving(scene)) {
    const json& step = scene.at("analysis").at("dynamic").value("time_step_s", json());
    if (step.is_number()) place.step_s = step.get<double>();
  }
  return place;
}

EnvelopeFactors factors_between(const EnvelopePlace& from, const EnvelopePlace& to) {
  EnvelopeFactors out;
  if (from.load_kinds != to.load_kinds) out.why_none = "it has other loads";
  if (from.poisson_ratio != to.poisson_ratio) out.why_none = "its Poisson's ratio is another";
  if (!out.why_none.empty()) return out;
  const auto factor = [&](EnvelopeAxis axis) -> std::optional<double>& {
    return out.factor.at(static_cast<std::size_t>(axis));
  };
  const double stiffer = to.young_modulus_pa / from.young_modulus_pa;
  factor(EnvelopeAxis::kStiffer) = stiffer;
  double lighter = 1.0;
  if (from.density_kg_m3 > 0.0 && to.density_kg_m3 > 0.0) {
    lighter = from.density_kg_m3 / to.density_kg_m3;
    factor(EnvelopeAxis::kLighter) = lighter;
  }
  double larger = 0.0;
  for (std::size_t k = 0; k < from.load_sizes.size(); ++k) {
    if (!(from.load_sizes[k] > 0.0)) continue;
    double ratio = to.load_sizes[k] / from.load_sizes[k];
    if (from.load_kinds[k] != "displace") ratio /= stiffer;
    if (from.load_kinds[k] == "gravity") ratio /= lighter;
    larger = std::max(larger, ratio);
  }
  factor(EnvelopeAxis::kLarger) = larger;
  if (from.rise_s && to.rise_s) factor(EnvelopeAxis::kFaster) = *from.rise_s / *to.rise_s;
  if (from.step_s && to.step_s)
    factor(EnvelopeAxis::kStep) = *to.step_s / *from.step_s * std::sqrt(stiffer * lighter);
  return out;
}

}  // namespace palpate::experiments
