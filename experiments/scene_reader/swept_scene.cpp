#include "experiments/scene_reader/swept_scene.h"

#include <cstdint>
#include <optional>
#include <utility>

#include "experiments/scene_reader/scene_problem.h"

namespace palpate::experiments {

SweptScene place_swept_scene(Scene scene, const nlohmann::json& sweep) {
  if (sweep.contains("poisson_ratio")) scene.material.poisson_ratio = sweep.at("poisson_ratio").get<double>();
  std::optional<std::uint64_t> vertices;
  if (sweep.contains("vertices")) vertices = sweep.at("vertices").get<std::uint64_t>();
  SweptScene out;
  out.mesh = build_scene_mesh(scene.mesh, vertices).mesh;
  out.placed = place_scene(std::move(scene), out.mesh);
  return out;
}

}  // namespace palpate::experiments
