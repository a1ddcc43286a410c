// What an answer of an elastic model costs at small strain.
#pragma once

#include "core/dynamics/elasticity/elastic_model.h"
#include "core/dynamics/elasticity/loads.h"
#include "reference/linear_systems/answer_cost.h"

namespace palpate::reference {

/// Of the tangent at rest with its supports, factored here. A volume force's part is left out.
/// Throws: UnavailableError if it is not positive definite.
AnswerCost measure_model_cost(const dynamics::ElasticModel& model, const dynamics::Loads& loads);

}  // namespace palpate::reference
