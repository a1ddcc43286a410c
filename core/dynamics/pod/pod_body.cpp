#include "core/dynamics/pod/pod_body.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/base/error.h"

namespace palpate::dynamics {
namespace {

using Vector9 = Eigen::Matrix<double, 9, 1>;
using Rows9 = Eigen::Matrix<double, 9, 9, Eigen::RowMajor>;

Mat3 gradient_at(const Eigen::Matrix<double, 9, Eigen::Dynamic>& d, const Eigen::VectorXd& q) {
  Mat3 h;
  Eigen::Map<Vector9>(h.m.data()) = d * q;
  return h;
}

bool is_same_place(const SupportFace& a, const SupportFace& b) {
  return a.face == b.face && a.coefficient_n_per_m == b.coefficient_n_per_m;
}

}  // namespace

PodParts collect_pod_parts(const ElasticModel& model, SnapshotBasis basis, const Cubature& cubature,
                           const Loads& holding) {
  PodParts out{std::move(basis), {}, holding.supports, holding.held};
  for (SupportFace& support : out.supports) support.by_m = {};
  for (std::size_t v = 0; v < out.held.size(); ++v) {
    if (out.held[v] != 0 && length_sq(holding.held_by_m[v]) > 0.0)
      throw InputError("problem", 0, "held faces that stay where they are; move elastic pads instead",
                       "one that is moved");
  }
  out.domains.reserve(cubature.domains.size());
  for (const WeighedDomain& each : cubature.domains) {
    if (each.term >= model.strain_terms.size() || each.domain >= model.strain_terms[each.term].op.domains() ||
        !(each.weight >= 0.0))
      throw InputError("cubature", 0, "domains of the model with weights of 0 or more", "others");
    const StrainTerm& term = model.strain_terms[each.term];
    out.domains.push_back({each, gradient_matrix(term.op, each.domain, out.basis),
                           each.weight * term.op.volume_m3[each.domain], term.law, term.moduli});
  }
  return out;
}

Eigen::VectorXd reduce_loads(const SnapshotBasis& basis, const Loads& loads) {
  std::vector<Vec3> force(loads.force_n.size());
  const std::vector<Vec3> still(force.size());
  add_load_forces(loads, still, 1.0, force);
  return coordinates_of(basis, force);
}

PodBody::PodBody(PodParts parts) : parts_(std::move(parts)) {
  require_basis(parts_.basis, parts_.held);
  const Eigen::Index shapes = parts_.basis.shapes.cols();
  for (const PodDomain& domain : parts_.domains) {
    if (domain.gradient.cols() != shapes)
      throw InputError("domains", 0, "gradients of as many shapes as the basis has", "others");
  }
  support_stiffness_ = Eigen::MatrixXd::Zero(shapes, shapes);
  for (const SupportFace& support : parts_.supports) {
    for (const Index v : support.face) {
      if (v >= parts_.held.size()) throw InputError("supports", 0, "vertices of the body", "others");
    }
    for (std::size_t i = 0; i < 3; ++i) {
      const auto a = parts_.basis.shapes.middleRows<3>(3 * static_cast<Eigen::Index>(support.face[i]));
      for (std::size_t j = 0; j < 3; ++j) {
        const auto b = parts_.basis.shapes.middleRows<3>(3 * static_cast<Eigen::Index>(support.face[j]));
        support_stiffness_ += (i == j ? 2.0 : 1.0) * support.coefficient_n_per_m * (a.transpose() * b);
      }
    }
  }
}

PodBody::PodBody(const ElasticModel& model, SnapshotBasis basis, const Cubature& cubature,
                 const Loads& holding)
    : PodBody(collect_pod_parts(model, std::move(basis), cubature, holding)) {}

double PodBody::energy(const Eigen::VectorXd& q) const {
  double sum = 0.0;
  for (const PodDomain& point : parts_.domains)
    sum += point.volume_m3 * energy_density(point.law, point.moduli, gradient_at(point.gradient, q));
  return sum;
}

Eigen::VectorXd PodBody::gradient(const Eigen::VectorXd& q) const {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(q.size());
  for (const PodDomain& point : parts_.domains) {
    const Mat3 p = stress(point.law, point.moduli, gradient_at(point.gradient, q));
    sum += point.volume_m3 * (point.gradient.transpose() * Eigen::Map<const Vector9>(p.m.data()));
  }
  return sum;
}

Eigen::MatrixXd PodBody::tangent(const Eigen::VectorXd& q, bool semidefinite) const {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(q.size(), q.size());
  for (const PodDomain& point : parts_.domains) {
    Tangent9 c = dynamics::tangent(point.law, point.moduli, gradient_at(point.gradient, q));
    if (semidefinite) c = project_to_semidefinite(c);
    sum +=
        point.volume_m3 * (point.gradient.transpose() * (Eigen::Map<const Rows9>(c.data()) * point.gradient));
  }
  return sum;
}

PodBody::Resultants PodBody::reduce(const Loads& loads) const {
  bool is_same = loads.supports.size() == parts_.supports.size() && loads.held == parts_.held;
  for (std::size_t k = 0; is_same && k < parts_.supports.size(); ++k)
    is_same = is_same_place(loads.supports[k], parts_.supports[k]);
  for (std::size_t v = 0; is_same && v < parts_.held.size(); ++v)
    is_same = parts_.held[v] == 0 || length_sq(loads.held_by_m[v]) == 0.0;
  if (!is_same)
    throw InputError("problem", 0, "the supports and held faces that the basis was trained on", "others");
  Resultants out;
  out.force = reduce_loads(parts_.basis, loads);
  out.constant_j = load_energy(loads, std::vector<Vec3>(loads.force_n.size()), 1.0);
  return out;
}

PodAnswer PodBody::solve(const Loads& loads, const PodSolveOptions& options) const {
  const Resultants load = reduce(loads);
  PodAnswer out;
  out.q = Eigen::VectorXd::Zero(parts_.basis.shapes.cols());
  const auto potential = [&](const Eigen::VectorXd& q) {
    return energy(q) + 0.5 * q.dot(support_stiffness_ * q) - load.force.dot(q) + load.constant_j;
  };
  double now = potential(out.q);
  while (true) {
    const Eigen::VectorXd inner = gradient(out.q);
    const Eigen::VectorXd held = support_stiffness_ * out.q;
    const Eigen::VectorXd off = load.force - inner - held;
    const double acting = load.force.norm() + held.norm();
    out.residual_relative = acting > 0.0 ? off.norm() / acting : 0.0;
    out.converged = out.residual_relative <= options.tolerance;
    if (out.converged || out.iterations == options.max_iterations || !off.allFinite()) return out;
    ++out.iterations;
    Eigen::LLT<Eigen::MatrixXd> factor(tangent(out.q, false) + support_stiffness_);
    if (factor.info() != Eigen::Success) factor.compute(tangent(out.q, true) + support_stiffness_);
    if (factor.info() != Eigen::Success) return out;
    const Eigen::VectorXd step = factor.solve(off);
    constexpr double kArmijo = 1e-4;
    constexpr double kLeastShare = 1e-8;
    double share = 1.0;
    double there = potential(out.q + step);
    // Where rounding hides what is gained the whole step is taken.
    const double hidden = 1e-12 * (std::abs(now) + std::abs(load.force.dot(out.q)));
    while (!(there <= now - kArmijo * share * off.dot(step) + hidden) && share > kLeastShare) {
      share *= 0.5;
      there = potential(out.q + share * step);
    }
    if (!std::isfinite(there)) return out;
    out.q += share * step;
    now = there;
  }
}

std::size_t PodBody::bytes() const {
  const auto shapes = static_cast<std::size_t>(parts_.basis.shapes.cols());
  return sizeof(double) * (static_cast<std::size_t>(parts_.basis.shapes.size()) + shapes * shapes +
                           parts_.domains.size() * (9 * shapes + 4));
}

}  // namespace palpate::dynamics
