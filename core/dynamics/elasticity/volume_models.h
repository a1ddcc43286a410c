// Elastic models by name: springs with what they lack, or smoothed finite elements without springs.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/dynamics/elasticity/elastic_model.h"
#include "core/mesh/boundary_problem.h"

namespace palpate::dynamics {

/// What is added to springs, which by themselves have Poisson's ratio 1/4 (lambda = mu):
///
///   kNone          nothing
///   kThesis        the thesis's volume force (core/dynamics/elasticity/volume_force.h)
///   kTet           1/2 (lambda - mu) sum_T V_T (tr eps_T)^2: right for any ratio, but locks
///   kNodeAverage   1/2 (lambda - mu) sum_n V_n (tr eps_n)^2, eps_n over the tets of a node: no locking
///   kNodeSmoothed  springs at (1 - theta) mu, and
///                  1/2 sum_n V_n (lambda - mu + theta mu)(tr eps_n)^2 + sum_s V_s theta mu eps_s : eps_s,
///                  s the nodes too, or the edges or faces (SpringModelOptions::shear)
enum class VolumeModel { kNone, kThesis, kTet, kNodeAverage, kNodeSmoothed };

/// "none", "thesis", "tet", "node_average" or "node_smoothed". Throws: InputError.
VolumeModel parse_volume_model(std::string_view name);
/// The name that parse_volume_model reads.
const char* volume_model_name(VolumeModel model);

/// What build_spring_model adds to the springs, and where.
struct SpringModelOptions {
  VolumeModel volume = VolumeModel::kNone;
  StrainSize strain = StrainSize::kSmall;       ///< small: linearised springs and the linear law
  StrainLaw large_law = StrainLaw::kCorotated;  ///< of the added energies at large strain
  double theta = 0.7;                        ///< kNodeSmoothed: share of the shear modulus that is smoothed
  StrainDomain shear = StrainDomain::kNode;  ///< kNodeSmoothed: where it is; the dilatation stays at nodes
  double volume_force_ratio = 1.0;           ///< kThesis: m_kv / k_s as the thesis counts them
};

/// A model and what is to be said about it.
struct BuiltModel {
  ElasticModel model;
  double theta = 0.0;  ///< the one used; see build_spring_model
  std::vector<std::string> warnings;
};

/// The material that springs are to be fitted to: for kNone and kThesis the modulus itself, else E_s = 2.5
/// mu, whose shear modulus at nu = 1/4 is mu.
Material spring_material(const Material& material, VolumeModel volume);

/// Springs, fitted to spring_material, with a volume model.
///
/// Below Poisson's ratio 1/4 lambda - mu is negative. kTet and kNodeAverage then could make the stiffness
/// indefinite and are refused. kNodeSmoothed stays definite while the springs' bulk modulus 5/3 (1 - theta)
/// mu does not exceed the material's, lambda + 2/3 mu (each node's energy is then >= 0): theta is raised to
/// that, with a warning. With the shear elsewhere than at the nodes, lambda - (1 - theta) mu has to be >= 0.
///
/// Throws: InputError for a ratio that the model cannot represent, or theta outside [0, 1].
BuiltModel build_spring_model(const TetMesh& mesh, SpringNetwork springs, const Material& material,
                              const SpringModelOptions& options);

/// What build_blend_model mixes, in which shares.
struct BlendOptions {
  StrainSize strain = StrainSize::kSmall;
  StrainLaw large_law = StrainLaw::kNeoHookean;
  double theta = 0.7;                         ///< share of the shear modulus that is smoothed
  StrainDomain domain = StrainDomain::kNode;  ///< where lambda and theta mu are averaged
  StrainDomain rest = StrainDomain::kTet;     ///< where (1 - theta) mu is
  double stabilise = 0.0;                     ///< alpha: share of mu that each tet keeps, volume left alone
};

/// Linear elements blended with smoothed ones, without springs: a node-based smoothed finite element method,
/// stabilised.
///
///   W = sum_n V_n W(lambda, theta mu; F_n) + sum_T V_T W(0, (1 - theta) mu; F_T)
///
/// At small strain 1/2 sum_n V_n [lambda (tr eps_n)^2 + 2 theta mu eps_n : eps_n] + 1/2 (1 - theta) sum_T V_T
/// 2 mu eps_T : eps_T. An affine displacement has the exact energy and no force inside, whatever theta is.
/// Where nu < 0 makes 3 lambda + 2 theta mu negative, theta is raised until it is not, with a warning.
///
/// With alpha the shear above is (1 - alpha) mu in place of mu, and each tet adds the energy of alpha mu of a
/// change of shape alone, while the nodes keep the whole bulk modulus:
///
///   + alpha mu sum_T V_T (eps_T : eps_T - 1/3 (tr eps_T)^2) + 1/3 alpha mu sum_n V_n (tr eps_n)^2
///
/// which no deformation of a tet but a uniform swelling escapes (M. Gee, C. Dohrmann, S. Key, W. Wall, Int.
/// J. Numer. Meth. Engng 78 (2009), 429-443). Small strain alone.
///
/// Throws: InputError for theta or alpha outside [0, 1], or alpha > 0 at large strain.
BuiltModel build_blend_model(const TetMesh& mesh, const Material& material, const BlendOptions& options);

}  // namespace palpate::dynamics
