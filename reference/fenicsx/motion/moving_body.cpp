#include "reference/fenicsx/motion/moving_body.h"

#include <algorithm>
#include <map>

#include "core/base/error.h"
#include "core/mesh/topology.h"

namespace palpate::reference::fenicsx {
namespace {

void finish(const Matrix& matrix) {
  check(MatAssemblyBegin(matrix.get(), MAT_FINAL_ASSEMBLY), "MatAssembly");
  check(MatAssemblyEnd(matrix.get(), MAT_FINAL_ASSEMBLY), "MatAssembly");
  check(MatSetOption(matrix.get(), MAT_KEEP_NONZERO_PATTERN, PETSC_TRUE), "MatSetOption");
  check(MatSetOption(matrix.get(), MAT_SYMMETRIC, PETSC_TRUE), "MatSetOption");
}

double dot_of(const Vector& a, const Vector& b) {
  PetscScalar value = 0.0;
  check(VecDot(a.get(), b.get(), &value), "VecDot");
  return value;
}

double quadratic_form(const Matrix& matrix, const Vector& x) {
  Vector product = zeros_like(x);
  check(MatMult(matrix.get(), x.get(), product.get()), "MatMult");
  return dot_of(x, product);
}

/// The sum of a vector's entries by axis.
Vec3 total_of(const Vector& force) {
  std::array<PetscScalar, 3> sum{};
  for (PetscInt axis = 0; axis < 3; ++axis)
    check(VecStrideSum(force.get(), axis, &sum[static_cast<std::size_t>(axis)]), "VecStrideSum");
  return {sum[0], sum[1], sum[2]};
}

}  // namespace

MovingBody::MovingBody(const TetMesh& mesh, const MotionProblem& problem, ElasticBody& body, const char* type)
    : mesh_(mesh), problem_(problem), body_(body) {
  stiffness_ = body.create_matrix(type);
  body.add_tangent(body.create_vector(), stiffness_);
  finish(stiffness_);
  mass_ = body.create_matrix(type);
  body.add_mass(mass_);
  finish(mass_);
  add_group(problem.body, {});
  for (const MotionLoad& load : problem.loads) add_group(load.part, load.profile);
  std::map<Index, std::size_t> node_of;
  for (std::size_t node = 0; node < body.owned_nodes(); ++node) {
    const auto [a, b] = body.nodes()[node];
    if (a == b) node_of.emplace(a, node);
  }
  for (const Index probe : problem.probes) {
    const auto found = node_of.find(probe);
    probe_nodes_.push_back(found == node_of.end() ? body.owned_nodes() : found->second);
  }
}

void MovingBody::add_group(const BoundaryProblem& part, const dynamics::TimeProfile& profile) {
  Group group{std::make_unique<BoundaryTerms>(mesh_, part, body_), body_.create_vector(), {}, profile};
  body_.add_body_force(part.material.density_kg_m3 * part.gravity_m_s2, group.dead);
  if (!part.body_force_n_m3.empty())
    body_.add_body_force_field(part.body_force_n_m3, build_edges(mesh_), group.dead);
  group.terms->add_loads(group.dead);
  add_up_ghosts(group.dead);
  update_ghosts(group.dead);
  group.dead_total = total_of(group.dead);
  groups_.push_back(std::move(group));
}

std::vector<std::size_t> MovingBody::groups_of(const LoadPhase& phase) const {
  std::vector<std::size_t> groups{0};
  for (const std::size_t load : phase.loads) groups.push_back(load + 1);
  std::vector<PetscInt> rows = held_rows(groups);
  std::sort(rows.begin(), rows.end());
  if (std::adjacent_find(rows.begin(), rows.end()) != rows.end())
    throw InputError("loads", 0, "each component of a vertex held by one load at a time",
                     "two that hold one");
  return groups;
}

std::vector<PetscInt> MovingBody::held_rows(const std::vector<std::size_t>& groups) const {
  std::vector<PetscInt> rows;
  for (const std::size_t g : groups) {
    const std::vector<PetscInt>& own = groups_[g].terms->held_rows();
    rows.insert(rows.end(), own.begin(), own.end());
  }
  return rows;
}

Matrix MovingBody::stiffness_with(const std::vector<std::size_t>& groups) const {
  Matrix made;
  check(MatDuplicate(stiffness_.get(), MAT_COPY_VALUES, made.put()), "MatDuplicate");
  for (const std::size_t g : groups) groups_[g].terms->add_supports(made);
  finish(made);
  return made;
}

void MovingBody::impose(const std::vector<std::size_t>& groups, const MotionState& state) const {
  for (const std::size_t g : groups) {
    const dynamics::ProfileValue now = value_at(groups_[g].profile, state.time_s);
    groups_[g].terms->set_held(now.share, state.displacement);
    groups_[g].terms->set_held(now.rate_per_s, state.velocity);
    groups_[g].terms->set_held(now.acceleration_per_s2, state.acceleration);
  }
}

void MovingBody::clear_held(const std::vector<std::size_t>& groups, const Vector& vector) const {
  for (const std::size_t g : groups) groups_[g].terms->clear_held(vector);
}

Vector MovingBody::residual(const std::vector<std::size_t>& groups, const MotionState& state) const {
  Vector force = zeros_like(state.displacement);
  for (const std::size_t g : groups)
    groups_[g].terms->add_support_force(state.displacement, value_at(groups_[g].profile, state.time_s).share,
                                        force);
  add_up_ghosts(force);
  for (const std::size_t g : groups)
    check(VecAXPY(force.get(), value_at(groups_[g].profile, state.time_s).share, groups_[g].dead.get()),
          "VecAXPY");
  Vector along = zeros_like(force);
  Vector product = zeros_like(force);
  check(VecWAXPY(along.get(), problem_.damping_mass_per_s, state.velocity.get(), state.acceleration.get()),
        "VecWAXPY");
  check(MatMult(mass_.get(), along.get(), product.get()), "MatMult");
  check(VecAXPY(force.get(), -1.0, product.get()), "VecAXPY");
  check(VecWAXPY(along.get(), problem_.damping_stiffness_s, state.velocity.get(), state.displacement.get()),
        "VecWAXPY");
  check(MatMult(stiffness_.get(), along.get(), product.get()), "MatMult");
  check(VecAXPY(force.get(), -1.0, product.get()), "VecAXPY");
  update_ghosts(force);
  return force;
}

std::vector<double> MovingBody::measure(const std::vector<std::size_t>& groups,
                                        const MotionState& state) const {
  const double kinetic = 0.5 * quadratic_form(mass_, state.velocity);
  const double elastic = 0.5 * quadratic_form(stiffness_, state.displacement);
  double load = 0.0;
  for (const std::size_t g : groups) {
    const double share = value_at(groups_[g].profile, state.time_s).share;
    load += groups_[g].terms->support_energy(state.displacement, share) -
            share * dot_of(groups_[g].dead, state.displacement);
  }
  std::vector<double> row{state.time_s, kinetic, elastic, load, kinetic + elastic + load};
  append_tools(groups, state, row);
  append_probes(state, row);
  return row;
}

void MovingBody::append_tools(const std::vector<std::size_t>& groups, const MotionState& state,
                              std::vector<double>& row) const {
  const Vector missing = residual(groups, state);
  for (std::size_t k = 0; k < problem_.loads.size(); ++k) {
    if (!problem_.loads[k].is_tool()) continue;
    Vec3 force;
    if (std::find(groups.begin(), groups.end(), k + 1) != groups.end()) {
      const Group& group = groups_[k + 1];
      const double share = value_at(group.profile, state.time_s).share;
      force = group.terms->total_support_force(state.displacement, share) -
              group.terms->total_at_held(missing) + share * group.dead_total;
    }
    row.insert(row.end(), {force.x, force.y, force.z});
  }
}

std::vector<Vec3> MovingBody::at_vertices(const MotionState& state) const {
  const LocalEntries entries(state.displacement.get());
  std::vector<double> all(3 * mesh_.points.size());
  for (std::size_t node = 0; node < body_.owned_nodes(); ++node) {
    const auto [a, b] = body_.nodes()[node];
    if (a == b) std::copy_n(&entries[3 * node], 3, all.begin() + 3 * static_cast<std::ptrdiff_t>(a));
  }
  MPI_Allreduce(MPI_IN_PLACE, all.data(), static_cast<int>(all.size()), MPI_DOUBLE, MPI_SUM,
                PETSC_COMM_WORLD);
  std::vector<Vec3> found;
  for (std::size_t k = 0; k < all.size(); k += 3) found.push_back({all[k], all[k + 1], all[k + 2]});
  return found;
}

void MovingBody::append_probes(const MotionState& state, std::vector<double>& row) const {
  const LocalEntries entries(state.displacement.get());
  for (const std::size_t node : probe_nodes_) {
    std::array<double, 3> here{};
    if (node < body_.owned_nodes()) std::copy_n(&entries[3 * node], 3, here.begin());
    std::array<double, 3> all{};
    MPI_Allreduce(here.data(), all.data(), 3, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
    row.insert(row.end(), all.begin(), all.end());
  }
}

}  // namespace palpate::reference::fenicsx
