#include "core/dynamics/elasticity/volume_models.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/enum_names.h"
#include "core/base/error.h"

namespace palpate::dynamics {
namespace {

constexpr EnumNames<VolumeModel, 5> kVolumeNames{"volume",
                                                 {"none", "thesis", "tet", "node_average", "node_smoothed"}};

void check_material(const Material& material) {
  if (!(material.young_modulus_pa > 0.0) || !std::isfinite(material.young_modulus_pa))
    throw InputError("young_modulus_pa", 0, "a finite number > 0", std::to_string(material.young_modulus_pa));
  if (!(material.poisson_ratio > -1.0 && material.poisson_ratio < 0.5))
    throw InputError("poisson_ratio", 0, "a number in (-1, 0.5)", std::to_string(material.poisson_ratio));
}

void check_theta(double theta) {
  if (!(theta >= 0.0 && theta <= 1.0))
    throw InputError("theta", 0, "a number in [0, 1]", std::to_string(theta));
}

void check_stabilise(const BlendOptions& options) {
  if (!(options.stabilise >= 0.0 && options.stabilise <= 1.0))
    throw InputError("stabilise", 0, "a number in [0, 1]", std::to_string(options.stabilise));
  if (options.stabilise > 0.0 && options.strain == StrainSize::kLarge)
    throw InputError("stabilise", 0, "0 at large strain", std::to_string(options.stabilise));
}

StrainLaw law_of(StrainSize strain, StrainLaw large_law) {
  if (strain == StrainSize::kSmall) return StrainLaw::kLinear;
  if (large_law == StrainLaw::kLinear)
    throw InputError("law", 0, "corotated, neo_hookean or stable_neo_hookean at large strain", "linear");
  return large_law;
}

std::string raised_theta(double asked, double used, double nu) {
  return "theta raised from " + std::to_string(asked) + " to " + std::to_string(used) +
         ": at Poisson's ratio " + std::to_string(nu) + " a smaller one may leave the stiffness indefinite";
}

/// Springs' stiffness times `share`.
void scale_springs(SpringNetwork& springs, double share) {
  for (double& stiffness : springs.stiffness_n_per_m) stiffness *= share;
}

void add_volume_energy(const TetMesh& mesh, const Material& material, const SpringModelOptions& options,
                       BuiltModel& built) {
  const double lambda = material.lambda_pa() - material.mu_pa();
  // At nu = 1/4 rounding may leave either sign.
  constexpr double kRounding = 1e-12;
  if (lambda < -kRounding * material.mu_pa())
    throw InputError("poisson_ratio", 0,
                     std::string("0.25 or more for volume=") + volume_model_name(options.volume) +
                         " (less takes a negative volume energy, which may leave the stiffness indefinite; "
                         "node_smoothed has a stable form)",
                     std::to_string(material.poisson_ratio));
  if (lambda <= kRounding * material.mu_pa()) return;
  const bool is_tet = options.volume == VolumeModel::kTet;
  built.model.strain_terms.push_back(
      {build_strain_operator(mesh, is_tet ? StrainDomain::kTet : StrainDomain::kNode),
       {lambda, 0.0},
       law_of(options.strain, options.large_law)});
}

void add_node_smoothed(const TetMesh& mesh, const Material& material, const SpringModelOptions& options,
                       BuiltModel& built) {
  const double mu = material.mu_pa();
  const double lambda = material.lambda_pa();
  const bool is_nodal = options.shear == StrainDomain::kNode;
  if (!is_nodal && lambda < 0.0)
    throw InputError("poisson_ratio", 0, "0 or more for shear away from the nodes",
                     std::to_string(material.poisson_ratio));
  const double bulk = lambda + 2.0 / 3.0 * mu;
  const double least = is_nodal ? 1.0 - bulk / (5.0 / 3.0 * mu) : 1.0 - lambda / mu;
  built.theta = std::max(options.theta, least);
  if (built.theta > options.theta)
    built.warnings.push_back(raised_theta(options.theta, built.theta, material.poisson_ratio));
  scale_springs(built.model.springs, 1.0 - built.theta);
  const StrainLaw law = law_of(options.strain, options.large_law);
  const double dilatation = std::max(lambda - mu + built.theta * mu, is_nodal ? -mu : 0.0);
  const double shear = built.theta * mu;
  built.model.strain_terms.push_back(
      {build_strain_operator(mesh, StrainDomain::kNode), {dilatation, is_nodal ? shear : 0.0}, law});
  if (!is_nodal && shear > 0.0)
    built.model.strain_terms.push_back({build_strain_operator(mesh, options.shear), {0.0, shear}, law});
}

}  // namespace

VolumeModel parse_volume_model(std::string_view name) {
  return kVolumeNames.parse(name);
}

const char* volume_model_name(VolumeModel model) {
  return kVolumeNames.of(model);
}

Material spring_material(const Material& material, VolumeModel volume) {
  check_material(material);
  Material out = material;
  if (volume == VolumeModel::kNone || volume == VolumeModel::kThesis) return out;
  out.young_modulus_pa = 2.5 * material.mu_pa();
  out.poisson_ratio = 0.25;
  return out;
}

BuiltModel build_spring_model(const TetMesh& mesh, SpringNetwork springs, const Material& material,
                              const SpringModelOptions& options) {
  check_material(material);
  check_theta(options.theta);
  BuiltModel built;
  built.model.rest = mesh.points;
  built.model.springs = std::move(springs);
  built.model.springs_are_linear = options.strain == StrainSize::kSmall;
  switch (options.volume) {
    case VolumeModel::kNone:
      break;
    case VolumeModel::kThesis: {
      const std::vector<double>& k = built.model.springs.stiffness_n_per_m;
      const double mean =
          k.empty() ? 0.0 : std::accumulate(k.begin(), k.end(), 0.0) / static_cast<double>(k.size());
      built.model.volume_force = build_volume_force(mesh, mean, options.volume_force_ratio);
      break;
    }
    case VolumeModel::kTet:
    case VolumeModel::kNodeAverage:
      add_volume_energy(mesh, material, options, built);
      break;
    case VolumeModel::kNodeSmoothed:
      add_node_smoothed(mesh, material, options, built);
      break;
  }
  return built;
}

BuiltModel build_blend_model(const TetMesh& mesh, const Material& material, const BlendOptions& options) {
  check_material(material);
  check_theta(options.theta);
  check_stabilise(options);
  const double kept = options.stabilise * material.mu_pa();
  const double mu = material.mu_pa() - kept;
  const double lambda = material.lambda_pa() + 2.0 / 3.0 * kept;
  BuiltModel built;
  // 3 lambda + 2 theta mu >= 0 keeps each smoothed energy >= 0; for nu >= 0 every theta does.
  built.theta = std::max(options.theta, mu > 0.0 ? std::min(1.0, -1.5 * lambda / mu) : 0.0);
  if (built.theta > options.theta)
    built.warnings.push_back(raised_theta(options.theta, built.theta, material.poisson_ratio));
  built.model.rest = mesh.points;
  const StrainLaw law = law_of(options.strain, options.large_law);
  built.model.strain_terms.push_back(
      {build_strain_operator(mesh, options.domain), {lambda, built.theta * mu}, law});
  if (built.theta < 1.0)
    built.model.strain_terms.push_back(
        {build_strain_operator(mesh, options.rest), {0.0, (1.0 - built.theta) * mu}, law});
  if (kept > 0.0)
    built.model.strain_terms.push_back(
        {build_strain_operator(mesh, StrainDomain::kTet), {-2.0 / 3.0 * kept, kept}, law});
  return built;
}

}  // namespace palpate::dynamics
