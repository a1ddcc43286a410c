#include "core/dynamics/reduced/modal_phase.h"

#include <Eigen/Dense>
#include <cmath>
#include <cstring>
#include <numbers>
#include <optional>

#include "core/base/error.h"
#include "core/dynamics/linear_algebra/signed_index.h"

namespace palpate::dynamics {
namespace {

using Matrix = Eigen::MatrixXd;
using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Vector = Eigen::VectorXd;

Matrix to_matrix(const std::vector<std::vector<Vec3>>& fields, std::size_t nodes) {
  Matrix out(signed_index(3 * nodes), signed_index(fields.size()));
  for (std::size_t c = 0; c < fields.size(); ++c)
    std::memcpy(out.col(signed_index(c)).data(), fields[c].data(), nodes * sizeof(Vec3));
  return out;
}

std::span<const Vec3> as_field(const double* numbers, std::size_t nodes) {
  return {reinterpret_cast<const Vec3*>(numbers), nodes};  // NOLINT: three numbers a vector
}

std::span<Vec3> as_field(double* numbers, std::size_t nodes) {
  return {reinterpret_cast<Vec3*>(numbers), nodes};  // NOLINT: three numbers a vector
}

/// What a group's supports do: S_g times columns.
Matrix support_product(const NodeLoads& loads, int order, const Matrix& columns) {
  Matrix out = Matrix::Zero(columns.rows(), columns.cols());
  const FaceMass mass = unit_face_mass(order);
  const std::size_t count = order == 1 ? 3 : 6;
  for (const ElasticFace& face : loads.faces) {
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t j = 0; j < count; ++j)
        out.middleRows(signed_index(3 * std::size_t{face.nodes[i]}), 3) +=
            (face.coefficient_n_per_m * mass[i][j]) *
            columns.middleRows(signed_index(3 * std::size_t{face.nodes[j]}), 3);
    }
  }
  return out;
}

/// S_g by, and by^T S_g by.
Vector support_force(const NodeLoads& loads, int order, std::size_t nodes, double& square) {
  Vector out = Vector::Zero(signed_index(3 * nodes));
  const FaceMass mass = unit_face_mass(order);
  const std::size_t count = order == 1 ? 3 : 6;
  for (const ElasticFace& face : loads.faces) {
    for (std::size_t i = 0; i < count; ++i) {
      double row = 0.0;
      for (std::size_t j = 0; j < count; ++j) row += face.coefficient_n_per_m * mass[i][j];
      const Vec3 part = row * face.by_m;
      out.segment(signed_index(3 * std::size_t{face.nodes[i]}), 3) += Eigen::Vector3d(part.x, part.y, part.z);
      square += dot(part, face.by_m);
    }
  }
  return out;
}

/// The sum of the rows of each axis: over all nodes, or over components that are held.
Matrix sum_axes(const Matrix& columns, const std::vector<std::uint8_t>* held) {
  Matrix out = Matrix::Zero(3, columns.cols());
  for (Eigen::Index row = 0; row < columns.rows(); ++row) {
    const auto node = static_cast<std::size_t>(row / 3);
    if (held != nullptr && (((*held)[node] >> (row % 3)) & 1) == 0) continue;
    out.row(row % 3) += columns.row(row);
  }
  return out;
}

Vec3 to_vec3(const Eigen::Vector3d& v) {
  return {v[0], v[1], v[2]};
}

}  // namespace

/// What a group adds to the measures.
struct GroupParts {
  Matrix pulls;        ///< 3 x (k + l): of S_g u, summed
  Eigen::Vector3d at;  ///< of f + S_g by, summed
  bool holds = false;
  Matrix held_mass;       ///< sums over the components that it holds, of M u
  Matrix held_stiffness;  ///< of K u
  Matrix held_supports;   ///< of S u
  Matrix held_loads;      ///< of f + S by, one column a group
};

struct ModalPhase::Parts {
  std::vector<ModalGroup> groups;
  ModalOptions options;
  std::size_t nodes = 0;
  Matrix shapes;    ///< Phi and the corrections, 3 nodes x (k + l)
  Matrix weighted;  ///< M Phi
  Matrix kinetic;
  Matrix elastic;
  Matrix supports;  ///< of S
  Matrix linear;    ///< shapes^T (f + S by), one column a group
  Vector squares;   ///< by^T S by, one a group
  std::vector<GroupParts> parts;
  SmallSystem system;
  std::optional<ExactStep> stepper;
  double step_s = 0.0;
  double time_s = 0.0;
  std::vector<double> eta;
  std::vector<double> rate;

  std::size_t modes() const { return system.modes(); }

  std::vector<double> shares(double at_s) const {
    std::vector<double> out;
    for (const ModalGroup& group : groups) out.push_back(value_at(group.profile, at_s).share);
    return out;
  }

  /// (eta, s) and its first two derivatives.
  std::array<Vector, 3> amounts() const {
    const Eigen::Index k = signed_index(modes());
    std::array<Vector, 3> w;
    for (Vector& each : w) each = Vector::Zero(k + signed_index(groups.size()));
    for (std::size_t g = 0; g < groups.size(); ++g) {
      const ProfileValue now = value_at(groups[g].profile, time_s);
      w[0][k + signed_index(g)] = now.share;
      w[1][k + signed_index(g)] = now.rate_per_s;
      w[2][k + signed_index(g)] = now.acceleration_per_s2;
    }
    w[0].head(k) = Eigen::Map<const Vector>(eta.data(), k);
    w[1].head(k) = Eigen::Map<const Vector>(rate.data(), k);
    const Eigen::Index l = signed_index(groups.size());
    w[2].head(k) = Eigen::Map<const RowMatrix>(system.load.data(), k, l) * w[0].tail(l) +
                   Eigen::Map<const RowMatrix>(system.load_rate.data(), k, l) * w[1].tail(l) -
                   Eigen::Map<const RowMatrix>(system.damping.data(), k, k) * w[1].head(k) -
                   Eigen::Map<const Vector>(system.squares.data(), k).cwiseProduct(w[0].head(k));
    return w;
  }

  /// In N; w, speed and acceleration are amounts().
  Eigen::Vector3d force_of(std::size_t g, const Vector& w, const Vector& speed,
                           const Vector& acceleration) const {
    const Vector s = w.tail(signed_index(groups.size()));
    const GroupParts& part = parts[g];
    Eigen::Vector3d force = s[signed_index(g)] * part.at - part.pulls * w;
    if (part.holds) {
      const double alpha = options.damping_mass_per_s;
      const double beta = options.damping_stiffness_s;
      force += part.held_mass * (acceleration + alpha * speed) + part.held_stiffness * (w + beta * speed) +
               part.held_supports * w - part.held_loads * s;
    }
    return force;
  }

  /// The shapes times amounts at the first nodes.
  std::vector<Vec3> field_of(const Vector& w, std::size_t first) const {
    require(first <= nodes, "as many nodes");
    const Vector numbers = shapes.topRows(signed_index(3 * first)) * w;
    std::vector<Vec3> out(first);
    for (std::size_t node = 0; node < first; ++node)
      out[node] = to_vec3(numbers.segment(signed_index(3 * node), 3));
    return out;
  }

  void build(const ElementMatrices& body, int order, const FactorMaker& make_factor);
  void build_system(const Matrix& stiff, const Matrix& participation);
  void build_measures(int order, const Matrix& massive, const Matrix& stiff,
                      const std::vector<Vector>& loads);
};

void ModalPhase::Parts::build(const ElementMatrices& body, int order, const FactorMaker& make_factor) {
  nodes = body.stiffness.rows();
  std::vector<std::uint8_t> held(nodes, 0);
  BlockMatrix stiffness = body.stiffness;
  for (const ModalGroup& group : groups) {
    for (std::size_t v = 0; v < nodes; ++v) {
      if ((held[v] & group.loads.held[v]) != 0)
        throw InputError("loads", 0, "one load that holds a component",
                         "two that hold node " + std::to_string(v));
      held[v] |= group.loads.held[v];
    }
    add_support_stiffness(group.loads, order, stiffness);
  }
  const HeldElements elements(body, std::move(stiffness), held, make_factor);
  const LowestModes lowest = elements.find_modes(options.modes);
  system.squares = lowest.squares_per_s2;
  system.loads = groups.size();
  std::vector<Vector> loads;
  std::vector<std::vector<Vec3>> rests;
  squares = Vector::Zero(signed_index(groups.size()));
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const NodeLoads& acts = groups[g].loads;
    Vector force = support_force(acts, order, nodes, squares[signed_index(g)]);
    for (std::size_t v = 0; v < nodes; ++v)
      force.segment(signed_index(3 * v), 3) +=
          Eigen::Vector3d(acts.force_n[v].x, acts.force_n[v].y, acts.force_n[v].z);
    rests.push_back(elements.rest_under(as_field(force.data(), nodes), acts.held_by_m));
    loads.push_back(std::move(force));
  }
  const Matrix modes_matrix = to_matrix(lowest.modes, nodes);
  const Matrix at_rest = to_matrix(rests, nodes);
  weighted.resize(modes_matrix.rows(), modes_matrix.cols());
  for (Eigen::Index c = 0; c < modes_matrix.cols(); ++c)
    multiply_mass(body, as_field(modes_matrix.col(c).data(), nodes), as_field(weighted.col(c).data(), nodes));
  const Matrix participation = weighted.transpose() * at_rest;
  shapes.resize(modes_matrix.rows(), modes_matrix.cols() + at_rest.cols());
  shapes.leftCols(modes_matrix.cols()) = modes_matrix;
  shapes.rightCols(at_rest.cols()) = at_rest - modes_matrix * participation;
  if (!options.correction) {  // what is held moves all the same
    for (Eigen::Index row = 0; row < shapes.rows(); ++row) {
      if (((held[static_cast<std::size_t>(row / 3)] >> (row % 3)) & 1) == 0)
        shapes.row(row).tail(at_rest.cols()).setZero();
    }
  }
  Matrix massive(shapes.rows(), shapes.cols());
  Matrix stiff(shapes.rows(), shapes.cols());
  for (Eigen::Index c = 0; c < shapes.cols(); ++c) {
    const auto field = as_field(shapes.col(c).data(), nodes);
    multiply_mass(body, field, as_field(massive.col(c).data(), nodes));
    multiply(body.stiffness, field, as_field(stiff.col(c).data(), nodes));
  }
  kinetic = shapes.transpose() * massive;
  elastic = shapes.transpose() * stiff;
  build_system(elastic, participation);
  build_measures(order, massive, stiff, loads);
}

void ModalPhase::Parts::build_system(const Matrix& stiff, const Matrix& participation) {
  const Eigen::Index k = signed_index(modes());
  const Eigen::Index l = signed_index(groups.size());
  RowMatrix damping = options.damping_stiffness_s * stiff.topLeftCorner(k, k);
  damping.diagonal().array() += options.damping_mass_per_s;
  const RowMatrix load = Eigen::Map<const Vector>(system.squares.data(), k).asDiagonal() * participation;
  const RowMatrix load_rate = -options.damping_stiffness_s * stiff.block(0, k, k, l);
  system.damping.assign(damping.data(), damping.data() + damping.size());
  system.load.assign(load.data(), load.data() + load.size());
  system.load_rate.assign(load_rate.data(), load_rate.data() + load_rate.size());
}

void ModalPhase::Parts::build_measures(int order, const Matrix& massive, const Matrix& stiff,
                                       const std::vector<Vector>& loads) {
  std::vector<Matrix> products;
  Matrix all = Matrix::Zero(shapes.rows(), shapes.cols());
  for (const ModalGroup& group : groups) {
    products.push_back(support_product(group.loads, order, shapes));
    all += products.back();
  }
  supports = shapes.transpose() * all;
  Matrix acting(shapes.rows(), signed_index(groups.size()));
  for (std::size_t g = 0; g < groups.size(); ++g) acting.col(signed_index(g)) = loads[g];
  linear = shapes.transpose() * acting;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    GroupParts& part = parts.emplace_back();
    part.pulls = sum_axes(products[g], nullptr);
    part.at = sum_axes(acting.col(signed_index(g)), nullptr);
    const std::vector<std::uint8_t>& held = groups[g].loads.held;
    for (const std::uint8_t bits : held) part.holds = part.holds || bits != 0;
    if (!part.holds) continue;
    part.held_mass = sum_axes(massive, &held);
    part.held_stiffness = sum_axes(stiff, &held);
    part.held_supports = sum_axes(all, &held);
    part.held_loads = sum_axes(acting, &held);
  }
}

ModalPhase::ModalPhase(const ElementMatrices& body, int order, std::vector<ModalGroup> groups,
                       const ModalOptions& options, const FactorMaker& make_factor)
    : parts_(std::make_unique<Parts>()) {
  parts_->groups = std::move(groups);
  parts_->options = options;
  parts_->build(body, order, make_factor);
  parts_->eta.assign(parts_->modes(), 0.0);
  parts_->rate.assign(parts_->modes(), 0.0);
}

ModalPhase::~ModalPhase() = default;
ModalPhase::ModalPhase(ModalPhase&&) noexcept = default;

double ModalPhase::start(const NodeState& state, double time_s) {
  Parts& p = *parts_;
  require(state.displacement_m.size() == p.nodes && state.velocity_m_s.size() == p.nodes, "a state a node");
  p.time_s = time_s;
  const auto numbers = [&](const std::vector<Vec3>& field) {
    Vector out(signed_index(3 * p.nodes));
    std::memcpy(out.data(), field.data(), p.nodes * sizeof(Vec3));
    return out;
  };
  const Vector u = numbers(state.displacement_m);
  Eigen::Map<Vector>(p.eta.data(), signed_index(p.modes())) = p.weighted.transpose() * u;
  Eigen::Map<Vector>(p.rate.data(), signed_index(p.modes())) =
      p.weighted.transpose() * numbers(state.velocity_m_s);
  const double size = u.norm();
  return size > 0.0 ? (p.shapes * p.amounts()[0] - u).norm() / size : 0.0;
}

void ModalPhase::rest() {
  Parts& p = *parts_;
  const std::vector<double> s = p.shares(p.time_s);
  const std::size_t l = s.size();
  for (std::size_t k = 0; k < p.modes(); ++k) {
    p.rate[k] = 0.0;
    p.eta[k] = 0.0;
    for (std::size_t g = 0; g < l; ++g) p.eta[k] += p.system.load[k * l + g] * s[g] / p.system.squares[k];
  }
}

void ModalPhase::prepare(double step_s) {
  Parts& p = *parts_;
  if (p.stepper && p.step_s == step_s) return;
  p.stepper.emplace(p.system, step_s);
  p.step_s = step_s;
}

void ModalPhase::advance(double step_s, double time_s) {
  prepare(step_s);
  Parts& p = *parts_;
  const std::vector<double> from = p.shares(p.time_s);
  p.time_s = time_s;
  p.stepper->advance(p.eta, p.rate, from, p.shares(time_s));
}

ModalMeasure ModalPhase::measure() const {
  const Parts& p = *parts_;
  const auto [w, speed, acceleration] = p.amounts();
  const Vector s = w.tail(signed_index(p.groups.size()));
  ModalMeasure out;
  out.kinetic_j = 0.5 * speed.dot(p.kinetic * speed);
  out.elastic_j = 0.5 * w.dot(p.elastic * w);
  out.load_j = 0.5 * w.dot(p.supports * w) - w.dot(p.linear * s) + 0.5 * s.cwiseProduct(s).dot(p.squares);
  for (std::size_t g = 0; g < p.groups.size(); ++g)
    out.group_force_n.push_back(to_vec3(p.force_of(g, w, speed, acceleration)));
  return out;
}

Vec3 ModalPhase::group_force(std::size_t group) const {
  const Parts& p = *parts_;
  require(group < p.groups.size(), "a group of loads");
  const auto [w, speed, acceleration] = p.amounts();
  return to_vec3(p.force_of(group, w, speed, acceleration));
}

Vec3 ModalPhase::displacement_of(Index node) const {
  const Parts& p = *parts_;
  return to_vec3(p.shapes.middleRows(signed_index(3 * std::size_t{node}), 3) * p.amounts()[0]);
}

NodeState ModalPhase::state() const {
  return state_of_first(parts_->nodes);
}

NodeState ModalPhase::state_of_first(std::size_t nodes) const {
  const auto w = parts_->amounts();
  return {parts_->field_of(w[0], nodes), parts_->field_of(w[1], nodes)};
}

std::vector<Vec3> ModalPhase::displacements_of_first(std::size_t nodes) const {
  return parts_->field_of(parts_->amounts()[0], nodes);
}

std::vector<double> ModalPhase::frequencies_hz() const {
  std::vector<double> out;
  for (const double square : parts_->system.squares)
    out.push_back(std::sqrt(std::fmax(square, 0.0)) / (2.0 * std::numbers::pi));
  return out;
}

const std::vector<ModalGroup>& ModalPhase::groups() const {
  return parts_->groups;
}

}  // namespace palpate::dynamics
