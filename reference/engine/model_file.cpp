#include "reference/engine/model_file.h"

namespace palpate::reference {
namespace {

using nlohmann::json;

json vectors(const std::vector<Vec3>& values) {
  json out = json::array();
  for (const Vec3& v : values) out.push_back({v.x, v.y, v.z});
  return out;
}

/// One number a member; all zero where the model has none.
std::vector<double> filled(const std::vector<double>& values, std::size_t count) {
  return values.empty() ? std::vector<double>(count) : values;
}

json springs_to_json(const dynamics::MotionModel& model) {
  const SpringNetwork& net = model.elastic.springs;
  return {{"force", model.elastic.springs_are_linear ? "linear" : "length"},
          {"damping", dynamics::spring_damping_name(model.spring_damping)},
          {"vertices", net.springs},
          {"rest_length_m", net.rest_length_m},
          {"stiffness_n_per_m", net.stiffness_n_per_m},
          {"damping_n_s_per_m", filled(model.spring_damping_n_s_per_m, net.springs.size())}};
}

json term_to_json(const dynamics::StrainTerm& term, double damping_s) {
  return {{"law", dynamics::strain_law_name(term.law)},
          {"lambda_pa", term.moduli.lambda_pa},
          {"mu_pa", term.moduli.mu_pa},
          {"damping_s", damping_s},
          {"volume_m3", term.op.volume_m3},
          {"offsets", term.op.offsets},
          {"vertices", term.op.vertices},
          {"gradients_per_m", vectors(term.op.gradients)}};
}

}  // namespace

json model_to_json(const TetMesh& mesh, const dynamics::MotionModel& model) {
  json out{{"points_m", vectors(mesh.points)},
           {"tets", mesh.tets},
           {"mass_kg", model.mass_kg},
           {"vertex_damping_n_s_per_m", filled(model.environment_damping_n_s_per_m, mesh.points.size())},
           {"springs", springs_to_json(model)},
           {"strain_terms", json::array()},
           {"volume_force", nullptr}};
  for (const dynamics::StrainTerm& term : model.elastic.strain_terms)
    out["strain_terms"].push_back(term_to_json(term, model.strain_damping_s));
  if (const auto& force = model.elastic.volume_force)
    out["volume_force"] = {{"stiffness_n_per_m3", force->stiffness_n_per_m3},
                           {"rest_volume_m3", force->rest_volume_m3},
                           {"center_weights", force->center_weights}};
  return out;
}

}  // namespace palpate::reference
