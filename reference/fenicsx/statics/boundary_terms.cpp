#include "reference/fenicsx/statics/boundary_terms.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <unordered_map>

#include "core/mesh/topology.h"

namespace palpate::reference::fenicsx {
namespace {

Vec3 area_vector(const TetMesh& mesh, const Triangle& face) {
  const Vec3& a = mesh.points[face[0]];
  return 0.5 * cross(mesh.points[face[1]] - a, mesh.points[face[2]] - a);
}

Edge edge_of(Index a, Index b) {
  return {std::min(a, b), std::max(a, b)};
}

std::array<double, 3> scaled(const Vec3& v, double factor) {
  return {factor * v.x, factor * v.y, factor * v.z};
}

/// Calls visit(first entry of node i, first entry of node j, mass of i and j) for all pairs of a face's
/// nodes.
template <typename Visit>
void for_each_pair(const LocalFace& face, const Visit& visit) {
  const auto n = static_cast<std::size_t>(face.node_count);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      visit(3 * static_cast<std::size_t>(face.nodes[i]), 3 * static_cast<std::size_t>(face.nodes[j]),
            face_mass(face.node_count, i, j));
    }
  }
}

double sum_over_processes(double here) {
  double sum = 0.0;
  MPI_Allreduce(&here, &sum, 1, MPI_DOUBLE, MPI_SUM, PETSC_COMM_WORLD);
  return sum;
}

/// The displacement that is added to held faces, at the middle of an edge or (a, a) at a vertex.
class HeldField {
 public:
  HeldField(const TetMesh& mesh, const std::vector<Vec3>& values)
      : values_(values), vertices_(mesh.points.size()) {
    if (!values.empty()) edges_ = build_edges(mesh);
  }

  Vec3 at(const Edge& ends) const {
    if (values_.empty()) return {};
    if (ends[0] == ends[1]) return values_[ends[0]];
    const auto place = std::lower_bound(edges_.begin(), edges_.end(), ends) - edges_.begin();
    return values_[vertices_ + static_cast<std::size_t>(place)];
  }

 private:
  const std::vector<Vec3>& values_;
  std::size_t vertices_;
  std::vector<Edge> edges_;
};

}  // namespace

double face_mass(int node_count, std::size_t i, std::size_t j) {
  if (node_count == 3) return i == j ? 1.0 / 6.0 : 1.0 / 12.0;
  if (i > j) std::swap(i, j);
  if (j < 3) return i == j ? 6.0 / 180.0 : -1.0 / 180.0;
  if (i >= 3) return i == j ? 32.0 / 180.0 : 16.0 / 180.0;
  return (i + 1) % 3 == j - 3 ? -4.0 / 180.0 : 0.0;  // the midpoint of 1-2 is opposite to vertex 0
}

double face_load(int node_count, std::size_t i) {
  if (node_count == 3) return 1.0 / 3.0;
  return i < 3 ? 0.0 : 1.0 / 3.0;
}

BoundaryTerms::BoundaryTerms(const TetMesh& mesh, const BoundaryProblem& problem, const ElasticBody& body)
    : owned_nodes_(body.owned_nodes()) {
  find_held(mesh, problem, body);
  is_moved_ = sum_over_processes(is_moved_ ? 1.0 : 0.0) > 0.0;
  find_faces(mesh, problem, body);
  std::unordered_map<Index, std::size_t> node_of;
  for (std::size_t node = 0; node < body.owned_nodes(); ++node) {
    const auto [a, b] = body.nodes()[node];
    if (a == b) node_of.emplace(a, node);
  }
  for (const NodalForce& load : problem.nodal_forces) {
    const auto found = node_of.find(load.vertex);
    if (found != node_of.end())
      nodal_forces_.emplace_back(static_cast<PetscInt>(found->second), load.force_n);
  }
}

void BoundaryTerms::find_held(const TetMesh& mesh, const BoundaryProblem& problem, const ElasticBody& body) {
  if (problem.held.empty()) return;
  const HeldField field(mesh, problem.held_field_m);
  std::map<Edge, std::size_t> node_of;
  for (std::size_t node = 0; node < body.nodes().size(); ++node) node_of.emplace(body.nodes()[node], node);
  std::set<std::size_t> seen;
  for (const HeldFaces& patch : problem.held) {
    for (const Triangle& f : patch.faces) {
      for (const Edge& ends : {Edge{f[0], f[0]}, Edge{f[1], f[1]}, Edge{f[2], f[2]}, edge_of(f[0], f[1]),
                               edge_of(f[1], f[2]), edge_of(f[2], f[0])}) {
        const auto found = node_of.find(ends);
        if (found == node_of.end()) continue;
        const std::size_t node = found->second;
        const std::array<double, 3> by = scaled(patch.by_m + field.at(ends), 1.0);
        for (std::size_t axis = 0; axis < 3; ++axis) {
          if (!patch.axes[axis] || !seen.insert(3 * node + axis).second) continue;
          held_.push_back({3 * node + axis, by[axis]});
          is_moved_ = is_moved_ || by[axis] != 0.0;
          if (node < body.owned_nodes())
            held_rows_.push_back(3 * body.global_numbers()[node] + static_cast<PetscInt>(axis));
        }
      }
    }
  }
}

void BoundaryTerms::find_faces(const TetMesh& mesh, const BoundaryProblem& problem, const ElasticBody& body) {
  for (const ElasticSupport& support : problem.supports) {
    for (const LocalFace& face : body.find_faces(support.patch.faces)) {
      const double area = length(area_vector(mesh, support.patch.faces[face.given]));
      supports_.push_back({face, support.stiffness_pa_per_m * support.patch.weight[face.given] * area,
                           support.by_m, support_count_});
    }
    ++support_count_;
  }
  for (const Traction& traction : problem.tractions) {
    for (const LocalFace& face : body.find_faces(traction.patch.faces)) {
      const Vec3 area = area_vector(mesh, traction.patch.faces[face.given]);
      const Vec3 force = length(area) * traction.traction_pa - traction.pressure_pa * area;
      loads_.push_back({face, 1.0, traction.patch.weight[face.given] * force});
    }
  }
}

void BoundaryTerms::set_held(double factor, const Vector& u) const {
  const LocalEntries entries(u.get());
  for (const Held& held : held_) entries[held.entry] = factor * held.value_m;
}

void BoundaryTerms::clear_held(const Vector& u) const {
  set_held(0.0, u);
}

void BoundaryTerms::add_supports(const Matrix& tangent) const {
  std::vector<PetscScalar> block;
  for (const FaceTerm& term : supports_) {
    const auto n = static_cast<std::size_t>(term.face.node_count);
    block.assign(9 * n * n, 0.0);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) {
        const double mass = term.scale * face_mass(term.face.node_count, i, j);
        for (std::size_t axis = 0; axis < 3; ++axis) block[(3 * i + axis) * 3 * n + 3 * j + axis] = mass;
      }
    }
    check(MatSetValuesBlockedLocal(tangent.get(), term.face.node_count, term.face.nodes.data(),
                                   term.face.node_count, term.face.nodes.data(), block.data(), ADD_VALUES),
          "MatSetValuesBlockedLocal");
  }
}

void BoundaryTerms::add_support_force(const Vector& u, double factor, const Vector& force) const {
  const LocalEntries at(u.get());
  const LocalEntries to(force.get());
  for (const FaceTerm& term : supports_) {
    const std::array<double, 3> by = scaled(term.vector, factor);
    for_each_pair(term.face, [&](std::size_t row, std::size_t column, double mass) {
      for (std::size_t axis = 0; axis < 3; ++axis)
        to[row + axis] -= term.scale * mass * (at[column + axis] - by[axis]);
    });
  }
}

double BoundaryTerms::support_energy(const Vector& u, double factor) const {
  double energy = 0.0;
  const LocalEntries at(u.get());
  for (const FaceTerm& term : supports_) {
    const std::array<double, 3> by = scaled(term.vector, factor);
    for_each_pair(term.face, [&](std::size_t row, std::size_t column, double mass) {
      for (std::size_t axis = 0; axis < 3; ++axis)
        energy += 0.5 * term.scale * mass * (at[row + axis] - by[axis]) * (at[column + axis] - by[axis]);
    });
  }
  return sum_over_processes(energy);
}

std::vector<Vec3> BoundaryTerms::support_forces(const Vector& u, double factor) const {
  std::vector<std::array<double, 3>> sum(support_count_);  // the shape functions of a face add up to 1
  const LocalEntries at(u.get());
  for (const FaceTerm& term : supports_) {
    const std::array<double, 3> by = scaled(term.vector, factor);
    for (std::size_t i = 0; i < static_cast<std::size_t>(term.face.node_count); ++i) {
      const std::size_t entry = 3 * static_cast<std::size_t>(term.face.nodes[i]);
      const double share = term.scale * face_load(term.face.node_count, i);
      for (std::size_t axis = 0; axis < 3; ++axis)
        sum[term.of][axis] -= share * (at[entry + axis] - by[axis]);
    }
  }
  std::vector<Vec3> forces;
  forces.reserve(sum.size());
  for (const auto& [x, y, z] : sum)
    forces.push_back({sum_over_processes(x), sum_over_processes(y), sum_over_processes(z)});
  return forces;
}

Vec3 BoundaryTerms::total_support_force(const Vector& u, double factor) const {
  Vec3 sum;
  for (const Vec3& force : support_forces(u, factor)) sum = sum + force;
  return sum;
}

Vec3 BoundaryTerms::total_at_held(const Vector& force) const {
  std::array<double, 3> sum{};
  const LocalEntries at(force.get());
  for (const Held& held : held_) {
    if (held.entry < 3 * owned_nodes_) sum[held.entry % 3] += at[held.entry];
  }
  return {sum_over_processes(sum[0]), sum_over_processes(sum[1]), sum_over_processes(sum[2])};
}

void BoundaryTerms::add_loads(const Vector& force) const {
  const LocalEntries to(force.get());
  const auto add = [&](PetscInt node, const Vec3& f) {
    const auto at = 3 * static_cast<std::size_t>(node);
    to[at] += f.x;
    to[at + 1] += f.y;
    to[at + 2] += f.z;
  };
  for (const FaceTerm& term : loads_) {
    for (std::size_t i = 0; i < static_cast<std::size_t>(term.face.node_count); ++i)
      add(term.face.nodes[i], face_load(term.face.node_count, i) * term.vector);
  }
  for (const auto& [node, f] : nodal_forces_) add(node, f);
}

}  // namespace palpate::reference::fenicsx
