#include "core/dynamics/finite_elements/node_loads.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/dynamics/elasticity/loads.h"
#include "core/mesh/geometry.h"

namespace palpate::dynamics {
namespace {

Vec3 area_vector(const TetMesh& mesh, const Triangle& face) {
  return 0.5 *
         cross(mesh.points[face[1]] - mesh.points[face[0]], mesh.points[face[2]] - mesh.points[face[0]]);
}

/// A constant traction on a straight quadratic face: nothing at the corners, a third at each midpoint.
void add_traction(const TetMesh& mesh, const ElementSpace& space, const Traction& traction,
                  std::vector<Vec3>& force) {
  for (std::size_t f = 0; f < traction.patch.faces.size(); ++f) {
    const Triangle& face = traction.patch.faces[f];
    const Vec3 area = area_vector(mesh, face);
    const double share = traction.patch.weight[f] / 3.0;
    const Vec3 part = share * (length(area) * traction.traction_pa - traction.pressure_pa * area);
    const std::array<Index, 6> nodes = face_nodes(space, face);
    for (std::size_t i = 3; i < 6; ++i) force[nodes[i]] = force[nodes[i]] + part;
  }
}

/// Weight and a body force that is quadratic in each tet, times the shape functions of order 2.
void add_body_forces(const TetMesh& mesh, const ElementSpace& space, const BoundaryProblem& problem,
                     std::vector<Vec3>& force) {
  const Vec3 weight = problem.material.density_kg_m3 * problem.gravity_m_s2;
  if (length_sq(weight) == 0.0 && problem.body_force_n_m3.empty()) return;
  std::vector<Vec3> field(space.nodes(), weight);
  for (std::size_t i = 0; i < problem.body_force_n_m3.size(); ++i)
    field[i] = field[i] + problem.body_force_n_m3[i];
  Material unit = problem.material;
  unit.density_kg_m3 = 1.0;
  std::vector<Vec3> product(field.size());
  multiply_mass(build_element_matrices(mesh, space, unit), field, product);
  for (std::size_t i = 0; i < force.size(); ++i) force[i] = force[i] + product[i];
}

void hold_midpoints(const ElementSpace& space, const BoundaryProblem& problem, NodeLoads& loads) {
  for (const HeldFaces& held : problem.held) {
    for (const Triangle& face : held.faces) {
      const std::array<Index, 6> nodes = face_nodes(space, face);
      for (std::size_t i = 3; i < 6; ++i) {
        const Index node = nodes[i];
        const Vec3 by = problem.held_field_m.empty() ? held.by_m : held.by_m + problem.held_field_m[node];
        if (held.axes[0]) loads.held_by_m[node].x = by.x;
        if (held.axes[1]) loads.held_by_m[node].y = by.y;
        if (held.axes[2]) loads.held_by_m[node].z = by.z;
        for (unsigned axis = 0; axis < 3; ++axis) {
          if (held.axes[axis]) loads.held[node] |= static_cast<std::uint8_t>(1U << axis);
        }
      }
    }
  }
}

}  // namespace

NodeLoads build_node_loads(const TetMesh& mesh, const ElementSpace& space, const BoundaryProblem& problem,
                           BodyForces body_forces) {
  BoundaryProblem rest = problem;
  if (body_forces == BodyForces::kLeaveOut || space.order == 2) {
    rest.gravity_m_s2 = {};
    rest.body_force_n_m3.clear();
  }
  if (space.order == 2) rest.tractions.clear();
  const Loads linear = build_loads(mesh, rest);  // it checks the problem too
  NodeLoads loads{linear.force_n, {}, linear.held, linear.held_by_m};
  loads.force_n.resize(space.nodes());
  loads.held.resize(space.nodes(), 0);
  loads.held_by_m.resize(space.nodes());
  if (space.order == 2) {
    build_loads(mesh, problem);  // throws for tractions that are wrong
    for (const Traction& traction : problem.tractions) add_traction(mesh, space, traction, loads.force_n);
    if (body_forces == BodyForces::kInclude) add_body_forces(mesh, space, problem, loads.force_n);
    hold_midpoints(space, problem, loads);
  }
  for (std::size_t s = 0; s < problem.supports.size(); ++s) {
    const ElasticSupport& support = problem.supports[s];
    for (std::size_t f = 0; f < support.patch.faces.size(); ++f) {
      const Triangle& face = support.patch.faces[f];
      const double coefficient =
          support.stiffness_pa_per_m * support.patch.weight[f] * length(area_vector(mesh, face));
      if (coefficient > 0.0) loads.faces.push_back({face_nodes(space, face), coefficient, support.by_m, s});
    }
  }
  return loads;
}

void add_support_stiffness(const NodeLoads& loads, int order, BlockMatrix& matrix) {
  const FaceMass mass = unit_face_mass(order);
  const std::size_t count = order == 1 ? 3 : 6;
  for (const ElasticFace& face : loads.faces) {
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t j = 0; j < count; ++j)
        add_block(matrix, face.nodes[i], face.nodes[j], (face.coefficient_n_per_m * mass[i][j]) * kIdentity);
    }
  }
}

void add_support_pull(const NodeLoads& loads, int order, std::span<Vec3> force) {
  const FaceMass mass = unit_face_mass(order);
  const std::size_t count = order == 1 ? 3 : 6;
  for (const ElasticFace& face : loads.faces) {
    for (std::size_t i = 0; i < count; ++i) {
      double row = 0.0;
      for (std::size_t j = 0; j < count; ++j) row += mass[i][j];
      force[face.nodes[i]] = force[face.nodes[i]] + (face.coefficient_n_per_m * row) * face.by_m;
    }
  }
}

SupportFigures measure_supports(const NodeLoads& loads, int order, std::span<const Vec3> displacement_m,
                                std::size_t supports) {
  const FaceMass mass = unit_face_mass(order);
  const std::size_t count = order == 1 ? 3 : 6;
  SupportFigures figures;
  figures.forces_n.resize(supports);
  for (const ElasticFace& face : loads.faces) {
    Vec3& force = figures.forces_n.at(face.support);
    for (std::size_t i = 0; i < count; ++i) {
      const Vec3 lack = face.by_m - displacement_m[face.nodes[i]];
      for (std::size_t j = 0; j < count; ++j) {
        const Vec3 part =
            (face.coefficient_n_per_m * mass[i][j]) * (face.by_m - displacement_m[face.nodes[j]]);
        force = force + part;
        figures.energy_j += 0.5 * dot(lack, part);
      }
    }
  }
  return figures;
}

}  // namespace palpate::dynamics
