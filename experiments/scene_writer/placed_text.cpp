#include "experiments/scene_writer/placed_text.h"

#include <sstream>

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

/// The places of an error: regions where the body had them.
void put_places(const std::vector<ErrorPlace>& places, json& error) {
  if (places.empty() || places.front().probe) return;
  error["at"] = json::array();
  for (const ErrorPlace& place : places) error["at"].push_back(region_json(place.region));
}

}  // namespace

json placed_scene(const Scene& placed, const std::string& mesh) {
  json out = read_yaml(placed.file).json();
  out["mesh"] = {{"file", mesh}, {"unit_m", 1}};
  if (!placed.mesh.regions_from.empty())
    out["mesh"]["regions_from"] =
        std::filesystem::absolute(placed.mesh.regions_from).lexically_normal().string();
  for (std::size_t k = 0; k < placed.clamps.size(); ++k) put_region(placed.clamps[k].region, out["clamp"][k]);
  for (std::size_t k = 0; k < placed.loads.size(); ++k) {
    json& load = out["load"][k];
    if (load.contains("displace")) put_region(placed.loads[k].region, load["displace"]);
    if (load.contains("force")) put_region(placed.loads[k].region, load["force"]);
  }
  if (placed.require) put_places(placed.require->places, out["require"]["error"]);
  return out;
}

std::string lines_of_scene(const json& scene) {
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
