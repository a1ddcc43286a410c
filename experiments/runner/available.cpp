#include "core/base/error.h"
#include "experiments/runner/runner.h"

namespace palpate::experiments {

void require_available(const Plan& plan, const Registry& registry) {
  const auto need_method = [&](const std::string& label, const std::string& method) {
    const std::string why = registry.find(method)->contestant->unavailable();
    if (!why.empty()) throw UnavailableError(label + " (" + method + ") is unavailable: " + why);
  };
  for (const PlanContestant& contestant : plan.contestants) {
    if (contestant.required) need_method(contestant.label, contestant.method);
  }
  for (const PlanContestant& simplifier : plan.simplifiers) {
    if (simplifier.required && !simplifier.method.empty()) need_method(simplifier.label, simplifier.method);
  }
  if (plan.reference) need_method("the reference", plan.reference->method);
  const auto shapes = list_shapes();
  const auto need_shape = [&](const std::string& name, const std::optional<ShapeRequest>& request) {
    for (const ShapeInfo& shape : shapes) {
      if (request && request->name == shape.name && !shape.unavailable.empty())
        throw UnavailableError("the mesh " + name + " is unavailable: " + shape.unavailable);
    }
  };
  for (const PlanMesh& mesh : plan.meshes) need_shape(mesh.name, mesh.shape);
  for (const PlanScene& scene : plan.scenes) need_shape("of " + scene.name, scene.scene.mesh.shape);
}

}  // namespace palpate::experiments
