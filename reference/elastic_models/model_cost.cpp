#include "reference/elastic_models/model_cost.h"

#include <vector>

#include "core/dynamics/elasticity/tangent.h"

namespace palpate::reference {

AnswerCost measure_model_cost(const dynamics::ElasticModel& model, const dynamics::Loads& loads) {
  std::vector<Triangle> faces;
  faces.reserve(loads.supports.size());
  for (const dynamics::SupportFace& support : loads.supports) faces.push_back(support.face);
  dynamics::BlockMatrix matrix = dynamics::build_tangent_pattern(model, faces);
  const std::vector<Vec3> rest(model.rest.size());
  dynamics::add_tangent(model, rest, dynamics::TangentKind::kExact, matrix);
  dynamics::add_support_tangent(loads, matrix);
  return measure_cost(matrix, loads.held);
}

}  // namespace palpate::reference
