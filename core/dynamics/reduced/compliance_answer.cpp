#include "core/dynamics/reduced/compliance_answer.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/component.h"
#include "core/base/error.h"
#include "core/dynamics/elasticity/loads.h"
#include "core/dynamics/finite_elements/node_loads.h"
#include "core/dynamics/linear_algebra/signed_index.h"
#include "core/dynamics/linear_algebra/vertex_field.h"
#include "core/dynamics/reduced/rigid_frame.h"
#include "core/dynamics/reduced/skin_space.h"
#include "core/dynamics/reduced/table_product.h"

namespace palpate::dynamics {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

void check_table(const ComplianceTable& table, const TetMesh& mesh, const BoundaryProblem& problem) {
  if (problem.strain == StrainSize::kLarge)
    throw InputError("strain", 0, "small: a table of compliances is linear", "large");
  if (table.body != hash_body(mesh))
    throw InputError("table", 0, "one that was made for this mesh", "one of another mesh");
  if (table.options.poisson_ratio != problem.material.poisson_ratio)
    throw InputError("table", 0, "Poisson's ratio " + std::to_string(problem.material.poisson_ratio),
                     std::to_string(table.options.poisson_ratio));
}

/// The rows of W that belong to supports: masses times stiffness between components of the skin's nodes.
using SupportRows = std::vector<std::vector<NodeWeight>>;

SupportRows support_rows(const NodeLoads& loads, const SkinPlaces& skin, int order) {
  SupportRows rows(skin.nodes.size());
  const FaceMass mass = unit_face_mass(order);
  const std::size_t count = order == 1 ? 3 : 6;
  for (const ElasticFace& face : loads.faces) {
    for (std::size_t i = 0; i < count; ++i) {
      std::vector<NodeWeight>& row = rows[skin.place[face.nodes[i]]];
      for (std::size_t j = 0; j < count; ++j) {
        const Index other = skin.place[face.nodes[j]];
        const double value = face.coefficient_n_per_m * mass[i][j];
        const auto at = std::find_if(row.begin(), row.end(),
                                     [&](const NodeWeight& entry) { return entry.node == other; });
        if (at == row.end()) {
          row.push_back({other, value});
        } else {
          at->weight += value;
        }
      }
    }
  }
  return rows;
}

bool same_holding(const NodeLoads& a, const NodeLoads& b) {
  return a.held == b.held && std::equal(a.faces.begin(), a.faces.end(), b.faces.begin(), b.faces.end(),
                                        [](const ElasticFace& x, const ElasticFace& y) {
                                          return x.nodes == y.nodes &&
                                                 x.coefficient_n_per_m == y.coefficient_n_per_m;
                                        });
}

}  // namespace

struct HeldBody::State {
  const ComplianceTable* table = nullptr;
  const TetMesh* mesh = nullptr;
  Material material;
  ElementSpace space;
  SkinPlaces skin;
  RigidFrame frame;
  std::vector<Vec3> points;  ///< of the rows of field, by their numbers
  NodeLoads holding;
  SupportRows rows;
  std::vector<std::size_t> touched;  ///< components of the skin: the supported ones first
  std::size_t supported = 0;
  Matrix rigid;                        ///< of the skin's components, 6 columns
  Eigen::LLT<Matrix> support_inverse;  ///< of W between supported components
  Eigen::LLT<Matrix> system;
  Matrix solved_rigid;  ///< system^-1 R_T
  Eigen::LLT<Matrix6> motions;
  double stabiliser = 0.0;  ///< m/N

  void number_touched() {
    const std::size_t n = skin.nodes.size();
    std::vector<std::uint8_t> held(n, 0);
    for (std::size_t node = 0; node < space.nodes(); ++node) {
      if (skin.place[node] != kNoIndex) held[skin.place[node]] = holding.held[node];
    }
    const auto is_held = [&](std::size_t c) { return ((held[c / 3] >> (c % 3)) & 1U) != 0; };
    for (std::size_t c = 0; c < 3 * n; ++c) {
      if (!rows[c / 3].empty() && !is_held(c)) touched.push_back(c);
    }
    supported = touched.size();
    for (std::size_t c = 0; c < 3 * n; ++c) {
      if (is_held(c)) touched.push_back(c);
    }
  }

  void number_rigid_motions() {
    rigid.resize(signed_index(3 * skin.nodes.size()), 6);
    for (std::size_t node = 0; node < space.nodes(); ++node) {
      if (skin.place[node] == kNoIndex) continue;
      for (std::size_t k = 0; k < 6; ++k) {
        const Vec3 at = frame.motion(k, space.points[node]);
        for (std::size_t i = 0; i < 3; ++i)
          rigid(signed_index(3 * std::size_t{skin.place[node]} + i), signed_index(k)) = component(at, i);
      }
    }
  }

  /// W between supported components.
  Matrix support_stiffness() const {
    const std::size_t n = skin.nodes.size();
    std::vector<std::size_t> place(3 * n, 3 * n);
    for (std::size_t t = 0; t < touched.size(); ++t) place[touched[t]] = t;
    Matrix stiffness = Matrix::Zero(signed_index(supported), signed_index(supported));
    for (std::size_t s = 0; s < supported; ++s) {
      for (const NodeWeight& entry : rows[touched[s] / 3]) {
        const std::size_t other = place[3 * std::size_t{entry.node} + touched[s] % 3];
        if (other < supported) stiffness(signed_index(s), signed_index(other)) = entry.weight;
      }
    }
    return stiffness;
  }

  void factor() {
    number_rigid_motions();
    support_inverse.compute(support_stiffness());
    Matrix all(signed_index(touched.size()), signed_index(touched.size()));
    for (std::size_t t = 0; t < touched.size(); ++t) {
      for (std::size_t u = 0; u < touched.size(); ++u)
        all(signed_index(t), signed_index(u)) =
            skin_entry(*table, touched[t], touched[u]) / material.young_modulus_pa;
    }
    const Eigen::Index s = signed_index(supported);
    if (s > 0) {
      const Matrix soft = support_inverse.solve(Matrix::Identity(s, s));
      all.topLeftCorner(s, s) += 0.5 * (soft + soft.transpose());
    }
    Matrix rigid_touched(signed_index(touched.size()), 6);
    for (std::size_t t = 0; t < touched.size(); ++t)
      rigid_touched.row(signed_index(t)) = rigid.row(signed_index(touched[t]));
    // Forces that balance a rigid motion's inertia alone deform nothing: where nearly all is touched the
    // block may be singular for them. What their resultant must be is known, so its square can be added.
    stabiliser = touched.empty() ? 0.0 : all.trace() / rigid_touched.squaredNorm();
    all += stabiliser * rigid_touched * rigid_touched.transpose();
    system.compute(all);
    if (system.info() != Eigen::Success || (s > 0 && support_inverse.info() != Eigen::Success))
      throw UnavailableError("the compliance of what is touched is not positive definite");
    solved_rigid = system.solve(rigid_touched);
    const Matrix6 gram = rigid_touched.transpose() * solved_rigid;
    motions.compute(gram);
    if (motions.info() != Eigen::Success)
      throw InputError("clamps and supports", 0, "enough to stop every rigid motion", "too little");
  }
};

HeldBody::HeldBody(const ComplianceTable& table, const TetMesh& mesh, const BoundaryProblem& problem)
    : state_(std::make_unique<State>()) {
  check_table(table, mesh, problem);
  require_no_rigid_motion(mesh, build_loads(mesh, problem));
  State& s = *state_;
  s.table = &table;
  s.mesh = &mesh;
  s.material = problem.material;
  s.space = build_element_space(mesh, table.options.reaction_order);
  s.skin = number_skin(mesh, s.space);
  require(s.skin.nodes.vertices == table.nodes.vertices && s.skin.nodes.edges == table.nodes.edges,
          "a table with the skin of its mesh");
  s.frame = build_rigid_frame(mesh);
  s.points = table.options.midpoints ? build_element_space(mesh, 2).points : mesh.points;
  require(table.order.size() == s.points.size(), "a table with a row for each point");
  s.holding = build_node_loads(mesh, s.space, problem, BodyForces::kLeaveOut);
  s.rows = support_rows(s.holding, s.skin, s.space.order);
  s.number_touched();
  s.factor();
}

HeldBody::~HeldBody() = default;

std::size_t HeldBody::touched() const {
  return state_->touched.size();
}

namespace {

/// W by, the part of W between supported and held components, and the right side that they make.
void bring_supports(const HeldBody::State& s, const NodeLoads& loads,
                    const std::vector<std::uint8_t>& is_held, const std::vector<double>& held_by,
                    HeldBody::SkinLoad& load) {
  const FaceMass mass = unit_face_mass(s.space.order);
  const std::size_t count = s.space.nodes_per_face();
  for (const ElasticFace& face : loads.faces) {
    for (std::size_t i = 0; i < count; ++i) {
      double row = 0.0;
      for (std::size_t j = 0; j < count; ++j) row += face.coefficient_n_per_m * mass[i][j];
      for (std::size_t axis = 0; axis < 3; ++axis)
        load.support_force_n[3 * std::size_t{s.skin.place[face.nodes[i]]} + axis] +=
            row * component(face.by_m, axis);
    }
  }
  for (std::size_t t = 0; t < s.supported; ++t) {
    const std::size_t c = s.touched[t];
    for (const NodeWeight& entry : s.rows[c / 3]) {
      const std::size_t other = 3 * std::size_t{entry.node} + c % 3;
      if (is_held[other] != 0) load.support_force_n[c] -= entry.weight * held_by[other];
    }
  }
  const Eigen::Index supported = signed_index(s.supported);
  Vector right(signed_index(s.touched.size()));
  for (std::size_t t = 0; t < s.touched.size(); ++t) {
    const std::size_t c = s.touched[t];
    right[signed_index(t)] = t < s.supported ? load.support_force_n[c] : held_by[c];
  }
  if (supported > 0) right.head(supported) = s.support_inverse.solve(right.head(supported).eval());
  load.holding_m.assign(right.data(), right.data() + right.size());
}

}  // namespace

std::unique_ptr<HeldBody::SkinLoad> HeldBody::prepare(const BoundaryProblem& problem) const {
  const State& s = *state_;
  if (!problem.body_force_n_m3.empty())
    throw InputError("body_force_n_m3", 0, "none: the table knows weight alone, which is the same everywhere",
                     "one that varies");
  const NodeLoads loads = build_node_loads(*s.mesh, s.space, problem, BodyForces::kLeaveOut);
  if (!same_holding(s.holding, loads))
    throw InputError("supports", 0, "those that the body was held by", "others");
  auto load = std::make_unique<SkinLoad>();
  const std::size_t n = 3 * s.skin.nodes.size();
  load->problem = problem;
  load->external_n.assign(n, 0.0);
  load->support_force_n.assign(n, 0.0);
  std::vector<double> held_by(n, 0.0);
  std::vector<std::uint8_t> is_held(n, 0);
  for (std::size_t t = s.supported; t < s.touched.size(); ++t) is_held[s.touched[t]] = 1;
  for (std::size_t node = 0; node < s.space.nodes(); ++node) {
    const Index place = s.skin.place[node];
    for (std::size_t i = 0; i < 3; ++i) {
      const double force = component(loads.force_n[node], i);
      if (place == kNoIndex && force != 0.0)
        throw InputError("nodal_forces", 0, "forces on vertices of the skin, which the table knows",
                         "one inside the body, on vertex " + std::to_string(node));
      if (place == kNoIndex) continue;
      const std::size_t c = 3 * std::size_t{place} + i;
      load->external_n[c] = force;
      if (is_held[c] != 0) {
        load->external_n[c] = 0.0;  // it goes into what holds
        held_by[c] = component(loads.held_by_m[node], i);
      } else if (force != 0.0) {
        load->loaded.push_back(c);
      }
    }
  }
  bring_supports(s, loads, is_held, held_by, *load);
  load->weight = work_of_weight(*s.mesh, s.frame, s.material.density_kg_m3 * problem.gravity_m_s2);
  load->resultant = load->weight;
  for (const std::size_t c : load->loaded) {
    for (std::size_t k = 0; k < 6; ++k)
      load->resultant[k] += s.rigid(signed_index(c), signed_index(k)) * load->external_n[c];
  }
  load->displacement_m.assign(3 * s.table->order.size(), 0.0);
  return load;
}

void HeldBody::react(SkinLoad& load) const {
  const State& s = *state_;
  Vector right = Eigen::Map<const Vector>(load.holding_m.data(), signed_index(load.holding_m.size()));
  for (std::size_t t = 0; t < s.touched.size(); ++t) {
    double sum = 0.0;
    for (const std::size_t c : load.loaded) sum += skin_entry(*s.table, s.touched[t], c) * load.external_n[c];
    right[signed_index(t)] -= sum / s.material.young_modulus_pa;
  }
  Vector6 missing = Eigen::Map<const Vector6>(load.resultant.data());
  for (std::size_t t = 0; t < s.touched.size(); ++t)
    right[signed_index(t)] -= s.stabiliser * s.rigid.row(signed_index(s.touched[t])).dot(missing);
  const Vector free = s.system.solve(right);
  for (std::size_t t = 0; t < s.touched.size(); ++t)
    missing += s.rigid.row(signed_index(s.touched[t])).transpose() * free[signed_index(t)];
  const Vector6 rigid = s.motions.solve(missing);
  const Vector reaction = free - s.solved_rigid * rigid;
  load.force_n = load.external_n;
  for (std::size_t t = 0; t < s.touched.size(); ++t) load.force_n[s.touched[t]] += reaction[signed_index(t)];
  for (std::size_t k = 0; k < 6; ++k) load.rigid[k] = rigid[signed_index(k)];
}

namespace {

/// The forces of the supports, of each and on each node; returns their energy.
double measure_supports(const HeldBody::State& s, const HeldBody::SkinLoad& load, ComplianceAnswer& out,
                        std::vector<Vec3>& pull) {
  const NodeLoads loads = build_node_loads(*s.mesh, s.space, load.problem, BodyForces::kLeaveOut);
  const FaceMass mass = unit_face_mass(s.space.order);
  out.support_forces_n.assign(load.problem.supports.size(), Vec3{});
  double support_energy = 0.0;
  for (const ElasticFace& face : loads.faces) {
    for (std::size_t i = 0; i < s.space.nodes_per_face(); ++i) {
      const Index a = s.skin.place[face.nodes[i]];
      Vec3 sum;
      for (std::size_t j = 0; j < s.space.nodes_per_face(); ++j)
        sum = sum +
              (face.coefficient_n_per_m * mass[i][j]) * (face.by_m - out.skin_m[s.skin.place[face.nodes[j]]]);
      out.support_forces_n[face.support] = out.support_forces_n[face.support] + sum;
      pull[a] = pull[a] + sum;
      support_energy += 0.5 * dot(sum, face.by_m - out.skin_m[a]);
    }
  }
  return support_energy;
}

/// Rows [first, last) of vertices: elastic part and rigid motion.
void move_rows(const ComplianceTable& table, const RigidFrame& frame, const std::vector<Vec3>& points,
               double young_pa, std::size_t first, std::size_t last, HeldBody::SkinLoad& load) {
  const std::span<double> rows(load.displacement_m.data() + 3 * first, 3 * (last - first));
  multiply_field(table, 3 * first, 3 * last, load.force_n, rows);
  for (std::size_t row = first; row < last; ++row) {
    const Vec3 rigid = frame.at(load.rigid, points[table.order[row]]);
    double* u = load.displacement_m.data() + 3 * row;
    u[0] = u[0] / young_pa + rigid.x;
    u[1] = u[1] / young_pa + rigid.y;
    u[2] = u[2] / young_pa + rigid.z;
  }
}

}  // namespace

void HeldBody::move_skin(SkinLoad& load) const {
  const State& s = *state_;
  move_rows(*s.table, s.frame, s.points, s.material.young_modulus_pa, 0, s.table->nodes.vertices.size(),
            load);
}

void HeldBody::move_inside(SkinLoad& load) const {
  const State& s = *state_;
  move_rows(*s.table, s.frame, s.points, s.material.young_modulus_pa, s.table->nodes.vertices.size(),
            s.table->order.size(), load);
}

ComplianceAnswer HeldBody::finish(const SkinLoad& load) const {
  const State& s = *state_;
  const std::size_t n = s.skin.nodes.size();
  ComplianceAnswer out;
  out.displacement_m.resize(s.table->order.size());
  for (std::size_t row = 0; row < s.table->order.size(); ++row) {
    const double* u = load.displacement_m.data() + 3 * row;
    out.displacement_m[s.table->order[row]] = {u[0], u[1], u[2]};
  }
  std::vector<double> elastic(3 * n);
  multiply_skin(*s.table, load.force_n, elastic);
  std::vector<double> skin(3 * n);
  double work = 0.0;
  for (std::size_t k = 0; k < 6; ++k) work += load.weight[k] * load.rigid[k];  // R^T M u = 0 but for R a
  for (std::size_t c = 0; c < 3 * n; ++c) {
    const double own = elastic[c] / s.material.young_modulus_pa;
    double rigid = 0.0;
    for (std::size_t k = 0; k < 6; ++k) rigid += s.rigid(signed_index(c), signed_index(k)) * load.rigid[k];
    skin[c] = own + rigid;
    out.energy_j += 0.5 * own * load.force_n[c];
    work += load.external_n[c] * skin[c];
  }
  for (std::size_t k = 0; k < n; ++k) {
    out.skin_force_n.push_back({load.force_n[3 * k], load.force_n[3 * k + 1], load.force_n[3 * k + 2]});
    out.skin_m.push_back({skin[3 * k], skin[3 * k + 1], skin[3 * k + 2]});
  }
  std::vector<Vec3> pull(n);
  const double support_energy = measure_supports(s, load, out, pull);
  double off = 0.0;
  double size = 0.0;
  for (std::size_t t = 0; t < s.supported; ++t) {
    const std::size_t c = s.touched[t];
    const double reaction = load.force_n[c] - load.external_n[c];
    off = std::max(off, std::fabs(reaction - component(pull[c / 3], c % 3)));
  }
  for (std::size_t c = 0; c < 3 * n; ++c) size = std::max(size, std::fabs(load.force_n[c]));
  out.residual_relative = size > 0.0 ? off / size : 0.0;
  out.potential_j = out.energy_j + support_energy - work;
  return out;
}

ComplianceAnswer HeldBody::solve(const BoundaryProblem& problem) const {
  const std::unique_ptr<SkinLoad> load = prepare(problem);
  react(*load);
  move_skin(*load);
  move_inside(*load);
  return finish(*load);
}

}  // namespace palpate::dynamics
