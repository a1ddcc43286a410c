#include "core/dynamics/pod/cubature.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "core/base/error.h"

namespace palpate::dynamics {
namespace {

/// Columns of `a` in one matrix.
Eigen::MatrixXd columns_of(const Eigen::MatrixXd& a, const std::vector<Eigen::Index>& which) {
  Eigen::MatrixXd out(a.rows(), static_cast<Eigen::Index>(which.size()));
  for (std::size_t k = 0; k < which.size(); ++k) out.col(static_cast<Eigen::Index>(k)) = a.col(which[k]);
  return out;
}

/// Least squares over the columns that are in, kept positive: those that reach zero on the way leave.
void settle(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, std::vector<Eigen::Index>& in,
            Eigen::VectorXd& x) {
  while (!in.empty()) {
    const Eigen::VectorXd z = columns_of(a, in).householderQr().solve(b);
    double share = 1.0;
    for (std::size_t k = 0; k < in.size(); ++k) {
      const double goal = z[static_cast<Eigen::Index>(k)];
      if (!(goal > 0.0)) share = std::min(share, x[in[k]] / (x[in[k]] - goal));
    }
    for (std::size_t k = 0; k < in.size(); ++k)
      x[in[k]] += share * (z[static_cast<Eigen::Index>(k)] - x[in[k]]);
    if (share == 1.0) return;
    constexpr double kNothing = 1e-14;
    std::erase_if(in, [&](Eigen::Index column) {
      if (x[column] > kNothing) return false;
      x[column] = 0.0;
      return true;
    });
  }
}

}  // namespace

Cubature take_all_domains(const ElasticModel& model) {
  Cubature out;
  for (std::size_t t = 0; t < model.strain_terms.size(); ++t) {
    const std::size_t count = model.strain_terms[t].op.domains();
    for (std::size_t s = 0; s < count; ++s) out.domains.push_back({t, s, 1.0});
  }
  return out;
}

Eigen::MatrixXd gradient_matrix(const StrainOperator& op, std::size_t domain, const SnapshotBasis& basis) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(9, basis.shapes.cols());
  for (Index k = op.offsets[domain]; k < op.offsets[domain + 1]; ++k) {
    const Vec3& g = op.gradients[k];
    const Eigen::RowVector3d gradient(g.x, g.y, g.z);
    for (Eigen::Index i = 0; i < 3; ++i) {
      const auto row = basis.shapes.row(3 * static_cast<Eigen::Index>(op.vertices[k]) + i);
      for (Eigen::Index j = 0; j < 3; ++j) out.row(3 * i + j) += gradient[j] * row;
    }
  }
  return out;
}

std::vector<double> solve_nonnegative(const Eigen::MatrixXd& a, const Eigen::VectorXd& b, double tolerance) {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(a.cols());
  std::vector<Eigen::Index> in;
  const double enough = tolerance * b.norm();
  Eigen::VectorXd residual = b;
  double before = residual.norm() * 2.0;
  while (residual.norm() > enough && static_cast<Eigen::Index>(in.size()) < std::min(a.rows(), a.cols())) {
    if (!(residual.norm() < before)) break;  // rounding: nothing more is to be gained
    before = residual.norm();
    Eigen::VectorXd pull = a.transpose() * residual;
    for (const Eigen::Index column : in) pull[column] = 0.0;
    Eigen::Index best = 0;
    if (!(pull.maxCoeff(&best) > 0.0)) break;
    in.push_back(best);
    settle(a, b, in, x);
    residual = b - a * x;
  }
  return {x.begin(), x.end()};
}

Cubature fit_cubature(const ElasticModel& model, const SnapshotBasis& basis,
                      std::span<const std::vector<Vec3>> snapshots, double tolerance) {
  if (!model.springs.springs.empty() || model.volume_force)
    throw InputError("model", 0, "strain energies alone for a cubature", "springs or a volume force");
  if (snapshots.empty()) throw InputError("snapshots", 0, "at least one", "none");
  Cubature out = take_all_domains(model);
  std::vector<Eigen::VectorXd> states;
  for (const std::vector<Vec3>& u : snapshots) states.push_back(coordinates_of(basis, u));
  const Eigen::Index shapes = basis.shapes.cols();
  const auto rows = shapes * static_cast<Eigen::Index>(states.size());
  Eigen::MatrixXd forces(rows, static_cast<Eigen::Index>(out.domains.size()));
  for (std::size_t e = 0; e < out.domains.size(); ++e) {
    const StrainTerm& term = model.strain_terms[out.domains[e].term];
    const std::size_t s = out.domains[e].domain;
    const Eigen::MatrixXd d = gradient_matrix(term.op, s, basis);
    for (std::size_t k = 0; k < states.size(); ++k) {
      Mat3 h;
      Eigen::Map<Eigen::Matrix<double, 9, 1>>(h.m.data()) = d * states[k];
      const Mat3 p = stress(term.law, term.moduli, h);
      forces.block(shapes * static_cast<Eigen::Index>(k), static_cast<Eigen::Index>(e), shapes, 1) =
          term.op.volume_m3[s] * (d.transpose() * Eigen::Map<const Eigen::Matrix<double, 9, 1>>(p.m.data()));
    }
  }
  Eigen::VectorXd sum = forces.rowwise().sum();
  for (Eigen::Index k = 0; k < rows; k += shapes) {
    const double size = sum.segment(k, shapes).norm();
    if (!(size > 0.0)) continue;
    forces.middleRows(k, shapes) /= size;
    sum.segment(k, shapes) /= size;
  }
  const std::vector<double> weights = solve_nonnegative(forces, sum, tolerance);
  const Eigen::Map<const Eigen::VectorXd> x(weights.data(), static_cast<Eigen::Index>(weights.size()));
  out.residual_relative = (forces * x - sum).norm() / sum.norm();
  for (std::size_t e = 0; e < weights.size(); ++e) out.domains[e].weight = weights[e];
  std::erase_if(out.domains, [](const WeighedDomain& each) { return each.weight == 0.0; });
  return out;
}

}  // namespace palpate::dynamics
