// Forces of a reduced body from few of its domains, weighed: cubature.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "core/dynamics/elasticity/elastic_model.h"
#include "core/dynamics/pod/snapshot_basis.h"

namespace palpate::dynamics {

/// One domain of a model, with the weight that it stands for.
struct WeighedDomain {
  std::size_t term = 0;  ///< of ElasticModel::strain_terms
  std::size_t domain = 0;
  double weight = 1.0;
};

/// Domains whose weighed forces stand for those of all.
struct Cubature {
  std::vector<WeighedDomain> domains;
  double residual_relative = 0.0;  ///< of the training forces, each snapshot's over its own size
};

/// All domains, each with weight 1.
Cubature take_all_domains(const ElasticModel& model);

/// The matrix D with vec H_s = D q by rows: 9 x shapes.
Eigen::MatrixXd gradient_matrix(const StrainOperator& op, std::size_t domain, const SnapshotBasis& basis);

/// x >= 0 with |A x - b| <= tolerance |b| and few entries that are not zero, by the active sets of Lawson and
/// Hanson, stopped there; or the least squares over x >= 0 if that is farther from b.
///
/// Source: C. Lawson and R. Hanson, Solving Least Squares Problems (1974), chapter 23.
std::vector<double> solve_nonnegative(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, double tolerance);

/// Chooses domains and weights >= 0 so that the reduced forces B^T f at the snapshots' projections are met to
/// `tolerance`, each snapshot's over its own size.
///
/// Throws: InputError for a model with springs or a volume force, or without a snapshot.
/// Source: S. An, T. Kim and D. James, ACM Trans. Graph. 27 (2008); the stop by tolerance: C. Farhat, P.
/// Avery, T. Chapman and J. Cortial, Int. J. Numer. Meth. Engng 98 (2014), 625-662 (ECSW).
Cubature fit_cubature(const ElasticModel& model, const SnapshotBasis& basis,
                      std::span<const std::vector<Vec3>> snapshots, double tolerance);

}  // namespace palpate::dynamics
