#include "reference/extremes/extreme_body.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/error.h"
#include "core/dynamics/elasticity/volume_models.h"
#include "core/dynamics/stability/stability.h"
#include "core/mesh/geometry.h"
#include "core/springs/identification/identify.h"
#include "reference/door/request_options.h"

namespace palpate::reference {
namespace {

using dynamics::MotionModel;
using nlohmann::json;

constexpr double kMostVolumeRatio = 1e300;

std::string take_name(json& options, const char* key, const std::string& fallback) {
  return take_option<std::string>(options, key, &json::is_string, "a name", fallback);
}

dynamics::ElasticModel build_elastic(const TetMesh& mesh, const Material& material, const BodyModel& wanted) {
  if (wanted.tets != "none") {
    const dynamics::StrainLaw law = dynamics::parse_strain_law(wanted.tets);
    const StrainSize strain = law == dynamics::StrainLaw::kLinear ? StrainSize::kSmall : StrainSize::kLarge;
    const bool is_smoothed = wanted.smoothing == "edge_node";
    dynamics::BlendOptions tets{strain, law, is_smoothed ? 0.0 : 1.0,
                                is_smoothed ? dynamics::StrainDomain::kNode : dynamics::StrainDomain::kTet,
                                is_smoothed ? dynamics::StrainDomain::kEdge : dynamics::StrainDomain::kTet};
    return dynamics::build_blend_model(mesh, material, tets).model;
  }
  dynamics::SpringModelOptions options;
  options.volume = dynamics::parse_volume_model(wanted.volume);
  options.strain = StrainSize::kLarge;
  const Material fitted = dynamics::spring_material(material, options.volume);
  springs::IdentifyReport report;
  SpringNetwork net =
      springs::identify_springs(mesh, fitted, springs::parse_spring_method(wanted.springs), {}, report);
  return dynamics::build_spring_model(mesh, std::move(net), material, options).model;
}

dynamics::Loads build_hold(const StabilityTask& task) {
  const std::size_t n = task.mesh.points.size();
  dynamics::Loads loads{std::vector<Vec3>(n), {}, std::vector<std::uint8_t>(n), std::vector<Vec3>(n)};
  for (const Index v : task.problem.held) loads.held[v] = 7;
  return loads;
}

double mean(const std::vector<double>& values) {
  if (values.empty()) return 0.0;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Damping by the body as it stands, and by its fastest rate.
void add_damping(const StabilityProblem& wanted, double rate, MotionModel& model) {
  const std::vector<double>& stiffness = model.elastic.springs.stiffness_n_per_m;
  const double z2 = 2.0 * wanted.damping_ratio;
  switch (wanted.damping) {
    case DampingLaw::kNone:
      return;
    case DampingLaw::kStiffness:
      for (const double k : stiffness) model.spring_damping_n_s_per_m.push_back(z2 / rate * k);
      model.strain_damping_s = z2 / rate;
      return;
    case DampingLaw::kMass:
      for (const double m : model.mass_kg) model.environment_damping_n_s_per_m.push_back(z2 * rate * m);
      return;
    case DampingLaw::kAxial:
    case DampingLaw::kIsotropic:
      model.spring_damping_n_s_per_m.assign(stiffness.size(), z2 / rate * mean(stiffness));
      if (wanted.damping == DampingLaw::kIsotropic)
        model.spring_damping = dynamics::SpringDamping::kIsotropic;
      return;
    case DampingLaw::kDrag:
      model.environment_damping_n_s_per_m.assign(model.mass_kg.size(), z2 * rate * mean(model.mass_kg));
      return;
  }
}

/// All stiffness times a factor; damping stays.
void scale_stiffness(double factor, MotionModel& model) {
  dynamics::ElasticModel& elastic = model.elastic;
  if (factor > 0.0) model.strain_damping_s /= factor;  // it is a share of the moduli
  for (double& k : elastic.springs.stiffness_n_per_m) k *= factor;
  for (dynamics::StrainTerm& term : elastic.strain_terms) {
    term.moduli.lambda_pa *= factor;
    term.moduli.mu_pa *= factor;
  }
  if (elastic.volume_force) elastic.volume_force->stiffness_n_per_m3 *= factor;
}

double largest_over_least(const std::vector<double>& values) {
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  return std::min(*most / *least, kMostVolumeRatio);
}

}  // namespace

BodyModel take_body_model(json& options) {
  BodyModel out;
  out.springs = take_name(options, "springs", out.springs);
  out.volume = take_name(options, "volume", out.volume);
  out.tets = take_name(options, "tets", out.tets);
  out.smoothing = take_name(options, "smoothing", out.smoothing);
  if (out.smoothing != "none" && out.smoothing != "edge_node")
    throw InputError("smoothing", 0, "none or edge_node", out.smoothing);
  if (out.tets == "none" && out.smoothing != "none")
    throw InputError("smoothing", 0, "none without tets", out.smoothing);
  if (out.tets != "none" && out.volume != "none")
    throw InputError("volume", 0, "none beside tets: they have their own", out.volume);
  return out;
}

BuiltBody build_extreme_body(const StabilityTask& task, const BodyModel& wanted) {
  const TetMesh& body = task.mesh;
  const StabilityProblem& problem = task.problem;
  std::vector<double> volumes;
  for (const Tet& t : body.tets) {
    volumes.push_back(
        signed_volume(body.points[t[0]], body.points[t[1]], body.points[t[2]], body.points[t[3]]));
    if (!(volumes.back() > 0.0)) throw InputError("mesh", 0, "tets that are not flat", "one without volume");
  }
  if (wanted.tets != "none" &&
      (problem.damping == DampingLaw::kAxial || problem.damping == DampingLaw::kIsotropic))
    throw InputError("damping", 0, "none, stiffness, mass or drag beside tets: there are no springs",
                     problem.damping == DampingLaw::kAxial ? "axial" : "isotropic");
  BuiltBody out;
  MotionModel& model = out.model;
  model.tets = body.tets;
  model.elastic = build_elastic(body, problem.material, wanted);
  model.mass_kg = dynamics::build_lumped_masses(body, problem.material.density_kg_m3);
  model.loads.push_back({build_hold(task), {}});
  const double rate =
      std::sqrt(bound_stable_step(model, dynamics::IntegratorKind::kSymplecticEuler).stiffness_max_per_s2);
  if (!(rate > 0.0))
    throw InputError("mesh", 0, "a body that is not held everywhere", "one that cannot move");
  add_damping(problem, rate, model);
  scale_stiffness(problem.stiffness_factor, model);
  for (std::size_t v = 0; v < model.mass_kg.size(); ++v) model.mass_kg[v] *= problem.mass_factors[v];
  const BoundingBox box = bounding_box(body.points);
  const Vec3 size = box.high - box.low;
  out.size_m = std::max({size.x, size.y, size.z});
  out.report = {{"vertices", body.points.size()},
                {"tets", body.tets.size()},
                {"springs", model.elastic.springs.springs.size()},
                {"rate_per_s", rate},
                {"mass_ratio", largest_over_least(model.mass_kg)},
                {"volume_ratio", largest_over_least(volumes)}};
  return out;
}

}  // namespace palpate::reference
