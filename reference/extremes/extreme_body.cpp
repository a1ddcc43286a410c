#include "reference/extremes/extreme_body.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/dynamics/elasticity/volume_models.h"
#include "core/dynamics/stability/stability.h"
#include "core/mesh/geometry.h"
#include "core/springs/identification/identify.h"
#include "reference/door/request_options.h"

namespace palpate::reference {
namespace {

using dynamics::MotionModel;
using nlohmann::json;

constexpr double kYoungPa = 1e4;
constexpr double kDensity = 1050.0;
constexpr double kHeldShare = 0.1;
constexpr double kMostVolumeRatio = 1e300;

std::string take_name(json& options, const char* key, const std::string& fallback) {
  return take_option<std::string>(options, key, &json::is_string, "a name", fallback);
}

dynamics::ElasticModel build_elastic(const TetMesh& mesh, const ExtremeBody& wanted) {
  const Material material{kYoungPa, wanted.poisson_ratio, kDensity};
  dynamics::SpringModelOptions options;
  options.volume = dynamics::parse_volume_model(wanted.volume);
  options.strain = StrainSize::kLarge;
  const Material fitted = dynamics::spring_material(material, options.volume);
  springs::IdentifyReport report;
  SpringNetwork net =
      springs::identify_springs(mesh, fitted, springs::parse_spring_method(wanted.springs), {}, report);
  return dynamics::build_spring_model(mesh, std::move(net), material, options).model;
}

dynamics::Loads build_hold(const TetMesh& mesh, bool is_held) {
  const std::size_t n = mesh.points.size();
  dynamics::Loads loads{std::vector<Vec3>(n), {}, std::vector<std::uint8_t>(n), std::vector<Vec3>(n)};
  const BoundingBox box = bounding_box(mesh.points);
  const double limit = box.low.x + kHeldShare * (box.high.x - box.low.x);
  for (std::size_t v = 0; is_held && v < n; ++v) loads.held[v] = mesh.points[v].x <= limit ? 7 : 0;
  return loads;
}

double mean(const std::vector<double>& values) {
  if (values.empty()) return 0.0;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Damping by the body as it stands, and by its fastest rate.
void add_damping(const ExtremeBody& wanted, double rate, MotionModel& model) {
  const std::vector<double>& stiffness = model.elastic.springs.stiffness_n_per_m;
  const double z2 = 2.0 * wanted.damping_ratio;
  switch (wanted.damping) {
    case ExtremeDamping::kNone:
      return;
    case ExtremeDamping::kStiffness:
      for (const double k : stiffness) model.spring_damping_n_s_per_m.push_back(z2 / rate * k);
      model.strain_damping_s = z2 / rate;
      return;
    case ExtremeDamping::kMass:
      for (const double m : model.mass_kg) model.environment_damping_n_s_per_m.push_back(z2 * rate * m);
      return;
    case ExtremeDamping::kAxial:
    case ExtremeDamping::kIsotropic:
      model.spring_damping_n_s_per_m.assign(stiffness.size(), z2 / rate * mean(stiffness));
      if (wanted.damping == ExtremeDamping::kIsotropic)
        model.spring_damping = dynamics::SpringDamping::kIsotropic;
      return;
    case ExtremeDamping::kDrag:
      model.environment_damping_n_s_per_m.assign(model.mass_kg.size(), z2 * rate * mean(model.mass_kg));
      return;
  }
}

void scale_stiffness(double factor, dynamics::ElasticModel& elastic) {
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

ExtremeBody take_extreme_body(json& options) {
  constexpr double kHuge = std::numeric_limits<double>::max();
  ExtremeBody out;
  out.mesh.size_m = take_number(options, "size_m", 0.0, kHuge, out.mesh.size_m);
  out.mesh.size_ratio = take_number(options, "size_ratio", 1.0, kHuge, 1.0);
  out.mesh.sliver_deg = take_number(options, "sliver_deg", 0.0, 60.0, 0.0);
  out.mesh.coordinate_scale = take_number(options, "coordinate_scale", 0.0, kHuge, 1.0);
  out.mesh.coordinate_shift_m = take_number(options, "coordinate_shift_m", -kHuge, kHuge, 0.0);
  out.is_held = take_choice(options, "held", {"end", "none"}) == 0;
  out.springs = take_name(options, "springs", out.springs);
  out.volume = take_name(options, "volume", out.volume);
  out.poisson_ratio = take_number(options, "poisson_ratio", -0.99, 0.499999, out.poisson_ratio);
  out.stiffness_factor = take_number(options, "stiffness_factor", 0.0, kHuge, 1.0);
  out.mass_factor = take_number(options, "mass_factor", 0.0, kHuge, 1.0);
  out.mass_ratio = take_number(options, "mass_ratio", 1.0, kHuge, 1.0);
  out.damping = static_cast<ExtremeDamping>(
      options.contains("damping")
          ? take_choice(options, "damping", {"none", "stiffness", "mass", "axial", "isotropic", "drag"})
          : static_cast<std::size_t>(ExtremeDamping::kAxial));
  out.damping_ratio = take_number(options, "damping_ratio", 0.0, kHuge, out.damping_ratio);
  return out;
}

BuiltBody build_extreme_body(const TetMesh& mesh, const ExtremeBody& wanted) {
  if (!(wanted.mass_factor > 0.0))
    throw InputError("mass_factor", 0, "a number above zero", std::to_string(wanted.mass_factor));
  DrivenMesh driven = drive_mesh(mesh, wanted.mesh);
  const TetMesh& body = driven.mesh;
  std::vector<double> volumes;
  for (const Tet& t : body.tets) {
    volumes.push_back(
        signed_volume(body.points[t[0]], body.points[t[1]], body.points[t[2]], body.points[t[3]]));
    if (!(volumes.back() > 0.0)) throw InputError("mesh", 0, "tets that are not flat", "one without volume");
  }
  BuiltBody out;
  MotionModel& model = out.model;
  model.tets = body.tets;
  model.elastic = build_elastic(body, wanted);
  model.mass_kg = dynamics::build_lumped_masses(body, kDensity);
  model.loads.push_back({build_hold(body, wanted.is_held), {}});
  const double rate =
      std::sqrt(bound_stable_step(model, dynamics::IntegratorKind::kSymplecticEuler).stiffness_max_per_s2);
  if (!(rate > 0.0))
    throw InputError("mesh", 0, "a body that is not held everywhere", "one that cannot move");
  add_damping(wanted, rate, model);
  scale_stiffness(wanted.stiffness_factor, model.elastic);
  SplitMix64 random(wanted.mesh.seed);
  for (double& m : model.mass_kg) m *= wanted.mass_factor * std::pow(wanted.mass_ratio, random.uniform());
  const BoundingBox box = bounding_box(body.points);
  const Vec3 size = box.high - box.low;
  out.size_m = std::max({size.x, size.y, size.z});
  out.report = {{"vertices", body.points.size()},
                {"tets", body.tets.size()},
                {"springs", model.elastic.springs.springs.size()},
                {"min_dihedral_deg", driven.min_dihedral_deg},
                {"flattened_tets", driven.flattened},
                {"rate_per_s", rate},
                {"mass_ratio", largest_over_least(model.mass_kg)},
                {"volume_ratio", largest_over_least(volumes)}};
  return out;
}

}  // namespace palpate::reference
