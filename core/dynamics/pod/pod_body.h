// A body at large strain in few shapes: its energy by cubature, its loads, and its equilibrium.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/dynamics/elasticity/loads.h"
#include "core/dynamics/pod/cubature.h"

namespace palpate::dynamics {

/// When its equilibrium counts as found.
struct PodSolveOptions {
  double tolerance = 1e-8;  ///< of the reduced forces out of balance, over those that act
  std::size_t max_iterations = 100;
};

/// An equilibrium, or what stopped the search for one.
struct PodAnswer {
  Eigen::VectorXd q;
  bool converged = false;
  std::size_t iterations = 0;
  double residual_relative = 0.0;
};

/// One domain of a reduced body.
struct PodDomain {
  WeighedDomain of;                                   ///< which one of the model, and its weight
  Eigen::Matrix<double, 9, Eigen::Dynamic> gradient;  ///< D with vec H = D q by rows
  double volume_m3 = 0.0;                             ///< with its weight
  StrainLaw law = StrainLaw::kLinear;
  Moduli moduli;
};

/// What a reduced body is made of: all that an answer needs, without the model that it was taken from.
struct PodParts {
  SnapshotBasis basis;
  std::vector<PodDomain> domains;
  std::vector<SupportFace> supports;  ///< how far they are moved is a load
  std::vector<std::uint8_t> held;     ///< bit i of a vertex: axis i
};

/// The parts for one holding. Throws: InputError for held components that are moved, or a cubature of another
/// model.
PodParts collect_pod_parts(const ElasticModel& model, SnapshotBasis basis, const Cubature& cubature,
                           const Loads& holding);

/// B^T f of the loads on the body at rest, supports that are moved included.
Eigen::VectorXd reduce_loads(const SnapshotBasis& basis, const Loads& loads);

/// The energy of u = B q by a cubature, for one holding: the elastic supports and held components that its
/// snapshots had. A basis knows no other: what moves there may not be in it.
class PodBody {
 public:
  /// Throws: as require_basis; InputError for a domain or a support that does not fit the basis.
  explicit PodBody(PodParts parts);
  /// Of collect_pod_parts. Throws: as that and the one above.
  PodBody(const ElasticModel& model, SnapshotBasis basis, const Cubature& cubature, const Loads& holding);

  /// Energy of the domains, in J; infinite where a law has none.
  double energy(const Eigen::VectorXd& q) const;
  /// Its gradient by q, in N.
  Eigen::VectorXd gradient(const Eigen::VectorXd& q) const;
  /// Its second derivative, in N/m; `semidefinite`: each domain's made so.
  Eigen::MatrixXd tangent(const Eigen::VectorXd& q, bool semidefinite) const;

  /// Newton's method with a line search on the potential from rest; each domain's tangent is made
  /// semidefinite where the sum is not definite. Throws: InputError for loads on another holding: supports on
  /// other faces or of another stiffness, or other held components. How far supports are moved is a load.
  PodAnswer solve(const Loads& loads, const PodSolveOptions& options) const;

  const PodParts& parts() const { return parts_; }
  const SnapshotBasis& basis() const { return parts_.basis; }
  std::size_t domains() const { return parts_.domains.size(); }
  /// What an answer needs, in bytes: basis, domains, supports.
  std::size_t bytes() const;

 private:
  struct Resultants {
    Eigen::VectorXd force;
    double constant_j = 0.0;
  };

  Resultants reduce(const Loads& loads) const;

  PodParts parts_;
  Eigen::MatrixXd support_stiffness_;
};

}  // namespace palpate::dynamics
