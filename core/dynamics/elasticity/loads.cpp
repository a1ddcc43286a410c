#include "core/dynamics/elasticity/loads.h"

#include <string>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/rigid_motion.h"
#include "core/mesh/subdivision/refinement.h"

namespace palpate::dynamics {
namespace {

/// Area vector of a face: half the cross product, outward for a boundary face.
Vec3 area_vector(const TetMesh& mesh, const Triangle& face) {
  const Vec3& a = mesh.points[face[0]];
  return 0.5 * cross(mesh.points[face[1]] - a, mesh.points[face[2]] - a);
}

void check_face(const TetMesh& mesh, const Triangle& face, const char* where) {
  for (const Index v : face) {
    if (v >= mesh.points.size())
      throw InputError(where, 0, "vertices below " + std::to_string(mesh.points.size()), std::to_string(v));
  }
}

void check_patch(const TetMesh& mesh, const FacePatch& patch, const char* where) {
  if (patch.weight.size() != patch.faces.size())
    throw InputError(where, 0, "one weight a face", std::to_string(patch.weight.size()) + " weights");
  for (const Triangle& face : patch.faces) check_face(mesh, face, where);
  for (const double weight : patch.weight) {
    if (!(weight > 0.0 && weight <= 1.0))
      throw InputError(where, 0, "weights in (0, 1]", std::to_string(weight));
  }
}

void hold(const TetMesh& mesh, const HeldFaces& held, const std::vector<Vec3>& field, Loads& loads) {
  for (const Triangle& face : held.faces) {
    check_face(mesh, face, "held");
    for (const Index v : face) {
      const Vec3 told = field.empty() ? held.by_m : held.by_m + field[v];
      const std::array<double, 3> by{told.x, told.y, told.z};
      const std::array<double*, 3> place{&loads.held_by_m[v].x, &loads.held_by_m[v].y, &loads.held_by_m[v].z};
      for (std::size_t i = 0; i < 3; ++i) {
        if (!held.axes[i]) continue;
        const auto bit = static_cast<std::uint8_t>(1U << i);
        if ((loads.held[v] & bit) != 0 && *place[i] != by[i])
          throw InputError("held", 0, "one displacement for vertex " + std::to_string(v),
                           std::to_string(*place[i]) + " m and " + std::to_string(by[i]) + " m");
        loads.held[v] |= bit;
        *place[i] = by[i];
      }
    }
  }
}

void add_tractions(const TetMesh& mesh, const Traction& traction, std::vector<Vec3>& force) {
  check_patch(mesh, traction.patch, "tractions");
  for (std::size_t f = 0; f < traction.patch.faces.size(); ++f) {
    const Triangle& face = traction.patch.faces[f];
    const Vec3 area = area_vector(mesh, face);
    const double share = traction.patch.weight[f] / 3.0;
    const Vec3 part = share * (length(area) * traction.traction_pa - traction.pressure_pa * area);
    for (const Index v : face) force[v] = force[v] + part;
  }
}

void add_gravity(const TetMesh& mesh, const BoundaryProblem& problem, std::vector<Vec3>& force) {
  const Vec3 weight = problem.material.density_kg_m3 * problem.gravity_m_s2;
  if (length_sq(weight) == 0.0) return;
  for (const Tet& t : mesh.tets) {
    const double volume =
        signed_volume(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]);
    for (const Index v : t) force[v] = force[v] + (0.25 * volume) * weight;
  }
}

void check_field(const std::vector<Vec3>& field, std::size_t nodes, const char* where) {
  if (!field.empty() && field.size() != nodes)
    throw InputError(where, 0, "a value a vertex and an edge midpoint (" + std::to_string(nodes) + ")",
                     std::to_string(field.size()));
}

/// Adds the integral of a quadratic body force times each linear shape function: in a tet of volume V, b_i
/// times the quadratic function of vertex j is 0 for i = j and -V / 60 else, of an edge V / 15 if i is one of
/// its ends and V / 30 else.
void add_body_force_field(const TetMesh& mesh, const EdgeNumbers& edges, const std::vector<Vec3>& field,
                          std::vector<Vec3>& force) {
  for (const Tet& t : mesh.tets) {
    const double volume =
        signed_volume(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]);
    const auto add = [&](std::size_t i, double share, const Vec3& value) {
      force[t[i]] = force[t[i]] + (share * volume) * value;
    };
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 4; ++j) {
        if (i != j) add(i, -1.0 / 60.0, field[t[j]]);
      }
      for (const auto& [a, b] : kTetEdges) {
        const bool is_end = i == static_cast<std::size_t>(a) || i == static_cast<std::size_t>(b);
        const Index edge = edges.of(t[static_cast<std::size_t>(a)], t[static_cast<std::size_t>(b)]);
        add(i, is_end ? 1.0 / 15.0 : 1.0 / 30.0, field[mesh.points.size() + edge]);
      }
    }
  }
}

/// What varies in space.
void add_fields(const TetMesh& mesh, const BoundaryProblem& problem, std::vector<Vec3>& force) {
  if (problem.body_force_n_m3.empty() && problem.held_field_m.empty()) return;
  const EdgeNumbers edges = build_edge_numbers(mesh);
  const std::size_t nodes = mesh.points.size() + edges.edges.size();
  check_field(problem.body_force_n_m3, nodes, "body_force_n_m3");
  check_field(problem.held_field_m, nodes, "held_field_m");
  if (!problem.body_force_n_m3.empty()) add_body_force_field(mesh, edges, problem.body_force_n_m3, force);
}

}  // namespace

Loads build_loads(const TetMesh& mesh, const BoundaryProblem& problem) {
  const std::size_t n = mesh.points.size();
  Loads loads{std::vector<Vec3>(n), {}, std::vector<std::uint8_t>(n), std::vector<Vec3>(n)};
  add_gravity(mesh, problem, loads.force_n);
  add_fields(mesh, problem, loads.force_n);
  for (const Traction& traction : problem.tractions) add_tractions(mesh, traction, loads.force_n);
  for (const NodalForce& nodal : problem.nodal_forces) {
    if (nodal.vertex >= n)
      throw InputError("nodal_forces", 0, "vertices below " + std::to_string(n),
                       std::to_string(nodal.vertex));
    loads.force_n[nodal.vertex] = loads.force_n[nodal.vertex] + nodal.force_n;
  }
  for (const HeldFaces& held : problem.held) hold(mesh, held, problem.held_field_m, loads);
  for (const ElasticSupport& support : problem.supports) {
    check_patch(mesh, support.patch, "supports");
    if (!(support.stiffness_pa_per_m >= 0.0))
      throw InputError("supports", 0, "a stiffness >= 0", std::to_string(support.stiffness_pa_per_m));
    for (std::size_t f = 0; f < support.patch.faces.size(); ++f) {
      const double area = length(area_vector(mesh, support.patch.faces[f]));
      loads.supports.push_back({support.patch.faces[f],
                                support.stiffness_pa_per_m * support.patch.weight[f] * area / 12.0,
                                support.by_m});
    }
  }
  return loads;
}

void require_no_rigid_motion(const TetMesh& mesh, const Loads& loads) {
  std::vector<std::uint8_t> resisted = loads.held;
  for (const SupportFace& support : loads.supports) {
    if (!(support.coefficient_n_per_m > 0.0)) continue;
    for (const Index v : support.face) resisted[v] = 7;
  }
  const std::vector<RigidMotion> free = find_free_motions(mesh, resisted);
  if (free.empty()) return;
  throw InputError("clamps and supports", 0,
                   "the part of the mesh with vertex " + std::to_string(free[0].part) + " to be held",
                   rigid_motion_text(free[0]) + " left free");
}

double load_energy(const Loads& loads, std::span<const Vec3> displacement, double scale) {
  double energy = 0.0;
  for (std::size_t v = 0; v < displacement.size(); ++v)
    energy -= scale * dot(loads.force_n[v], displacement[v]);
  for (const SupportFace& support : loads.supports) {
    Vec3 sum;
    double squares = 0.0;
    for (const Index v : support.face) {
      const Vec3 off = displacement[v] - scale * support.by_m;
      sum = sum + off;
      squares += length_sq(off);
    }
    energy += 0.5 * support.coefficient_n_per_m * (squares + length_sq(sum));
  }
  return energy;
}

void add_load_forces(const Loads& loads, std::span<const Vec3> displacement, double scale,
                     std::span<Vec3> force) {
  for (std::size_t v = 0; v < displacement.size(); ++v) force[v] = force[v] + scale * loads.force_n[v];
  for (const SupportFace& support : loads.supports) {
    std::array<Vec3, 3> off;
    Vec3 sum;
    for (std::size_t k = 0; k < 3; ++k) {
      off[k] = displacement[support.face[k]] - scale * support.by_m;
      sum = sum + off[k];
    }
    for (std::size_t k = 0; k < 3; ++k) {
      Vec3& f = force[support.face[k]];
      f = f - support.coefficient_n_per_m * (off[k] + sum);
    }
  }
}

void add_support_tangent(const Loads& loads, BlockMatrix& matrix) {
  for (const SupportFace& support : loads.supports) {
    for (const Index a : support.face) {
      for (const Index b : support.face)
        add_block(matrix, a, b, (support.coefficient_n_per_m * (a == b ? 2.0 : 1.0)) * kIdentity);
    }
  }
}

}  // namespace palpate::dynamics
