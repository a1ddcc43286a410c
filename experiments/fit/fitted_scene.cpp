#include "experiments/fit/fitted_scene.h"

#include "experiments/scene_writer/placed_text.h"

namespace palpate::experiments {
namespace {

using nlohmann::json;

json model_json(const FitModel& model) {
  const std::size_t dot = model.method.find('.');
  const std::string kind = model.method.substr(0, dot);
  json out = model.set;
  out[kind == "fem" ? "finite_elements" : kind] = model.method.substr(dot + 1);
  return out;
}

}  // namespace

json build_fitted_scene(const Scene& placed, const FitModel& model) {
  json scene = placed_scene(placed, "organ.mesh");
  scene["model"] = model_json(model);
  return scene;
}

}  // namespace palpate::experiments
