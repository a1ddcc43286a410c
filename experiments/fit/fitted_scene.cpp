#include "experiments/fit/fitted_scene.h"

#include <sstream>

#include "experiments/text/yaml_value.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

json region_json(const Region& region) {
  const auto list = [](const Vec3& v) { return json{v.x, v.y, v.z}; };
  switch (region.kind) {
    case Region::Kind::kSphere:
      return {{"sphere", {{"center_m", list(region.center)}, {"radius_m", region.radius}}}};
    case Region::Kind::kHalfSpace:
      return {{"half_space", {{"normal", list(region.normal)}, {"offset_m", region.offset}}}};
    case Region::Kind::kBox:
      break;
  }
  return {{"box", {{"low_m", list(region.low)}, {"high_m", list(region.high)}}}};
}

void put_region(const Region& region, json& entry) {
  for (const char* key : {"sphere", "half_space", "box"}) entry.erase(key);
  entry.update(region_json(region));
}

/// The places of an error as the fitted mesh is to have them: regions where the whole mesh had them.
void put_places(const std::vector<ErrorPlace>& places, json& error) {
  if (places.empty() || places.front().probe) return;
  error["at"] = json::array();
  for (const ErrorPlace& place : places) error["at"].push_back(region_json(place.region));
}

json model_json(const FitModel& model) {
  const std::size_t dot = model.method.find('.');
  const std::string kind = model.method.substr(0, dot);
  json out = model.set;
  out[kind == "fem" ? "finite_elements" : kind] = model.method.substr(dot + 1);
  return out;
}

}  // namespace

json build_fitted_scene(const Scene& placed, const FitModel& model) {
  json scene = read_yaml(placed.file).json();
  scene["mesh"] = {{"file", "organ.mesh"}, {"unit_m", 1}};
  scene["model"] = model_json(model);
  for (std::size_t k = 0; k < placed.clamps.size(); ++k)
    put_region(placed.clamps[k].region, scene["clamp"][k]);
  for (std::size_t k = 0; k < placed.loads.size(); ++k) {
    json& load = scene["load"][k];
    if (load.contains("displace")) put_region(placed.loads[k].region, load["displace"]);
    if (load.contains("force")) put_region(placed.loads[k].region, load["force"]);
  }
  if (placed.require) put_places(placed.require->places, scene["require"]["error"]);
  return scene;
}

std::string scene_lines(const json& scene) {
  std::ostringstream text;
  for (const auto& [key, value] : scene.items()) {
    if (!value.is_array()) {
      text << key << ": " << value.dump() << '\n';
      continue;
    }
    text << key << ":\n";
    for (const json& item : value) text << "  - " << item.dump() << '\n';
  }
  return text.str();
}

}  // namespace palpate::experiments
