#include <algorithm>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/topology.h"
#include "reference/finite_spheres/group_stiffness.h"
#include "reference/finite_spheres/quadrature.h"
#include "reference/finite_spheres/sphere_system.h"

namespace palpate::reference {
namespace {

/// Moving spheres in compressed rows: a row a tet, or a dual cell.
struct Groups {
  std::vector<Index> offsets{0};
  std::vector<Index> spheres;

  std::span<const Index> of(std::size_t group) const {
    return {spheres.data() + offsets[group], spheres.data() + offsets[group + 1]};
  }
  void add(const std::vector<Index>& group) {
    spheres.insert(spheres.end(), group.begin(), group.end());
    offsets.push_back(static_cast<Index>(spheres.size()));
  }
};

Groups group_by_tet(const SphereField& field) {
  Groups groups;
  std::vector<Index> here;
  for (std::size_t tet = 0; tet < field.mesh->tets.size(); ++tet) {
    collect_moving(field, tet, here);
    groups.add(here);
  }
  return groups;
}

Groups group_by_cell(const SphereField& field) {
  const VertexStars stars = build_vertex_stars(*field.mesh);
  Groups groups;
  std::vector<Index> here;
  std::vector<Index> all;
  for (Index v = 0; v < field.mesh->points.size(); ++v) {
    all.clear();
    for (const Index tet : stars.of(v)) {
      collect_moving(field, tet, here);
      all.insert(all.end(), here.begin(), here.end());
    }
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    groups.add(all);
  }
  return groups;
}

SphereSystem empty_system(const SphereField& field, const Groups& groups) {
  SphereSystem system;
  system.matrix = build_sphere_matrix(field.moving_spheres, functions_per_sphere(field.functions),
                                      {groups.offsets, groups.spheres});
  system.dead_n.resize(field.coefficients());
  system.moved_n.resize(field.coefficients());
  return system;
}

void add_force(const FunctionValues& here, const Vec3& force, std::vector<Vec3>& sum) {
  for (std::size_t i = 0; i < here.numbers.size(); ++i)
    sum[here.numbers[i]] = sum[here.numbers[i]] + here.values[i] * force;
}

/// Adds the integral of phi (gravity + body forces).
void add_body_forces(const SphereField& field, const BoundaryProblem& problem,
                     const std::vector<TetPoint>& rule, SphereSystem& system) {
  const TetMesh& mesh = *field.mesh;
  const QuadraticField varying(mesh, problem.body_force_n_m3);
  const Vec3 weight_n_m3 = problem.material.density_kg_m3 * problem.gravity_m_s2;
  if (problem.body_force_n_m3.empty() && length_sq(weight_n_m3) == 0.0) return;
  FunctionValues here;
  for (std::size_t tet = 0; tet < mesh.tets.size(); ++tet) {
    const double volume = tet_volume(mesh, tet);
    for (const TetPoint& point : rule) {
      evaluate_moving(field, tet, point_in_tet(mesh, tet, point.at), here);
      add_force(here, (point.weight * volume) * (weight_n_m3 + varying.at(tet, point.at)), system.dead_n);
    }
  }
}

SphereSystem integrate_tets(const SphereField& field, const BoundaryProblem& problem,
                            const IntegrationOptions& integration) {
  const TetMesh& mesh = *field.mesh;
  const std::vector<TetPoint> rule = build_tet_rule(integration.points, integration.subdivide);
  const Groups groups = group_by_tet(field);
  SphereSystem system = empty_system(field, groups);
  const QuadraticField body_force(mesh, problem.body_force_n_m3);
  const Vec3 weight_n_m3 = problem.material.density_kg_m3 * problem.gravity_m_s2;
  GroupStiffness stiffness(problem.material);
  FunctionValues here;
  for (std::size_t tet = 0; tet < mesh.tets.size(); ++tet) {
    if (groups.of(tet).empty()) continue;
    stiffness.start(groups.of(tet), functions_per_sphere(field.functions));
    const double volume = tet_volume(mesh, tet);
    for (const TetPoint& point : rule) {
      evaluate_moving(field, tet, point_in_tet(mesh, tet, point.at), here);
      stiffness.add(here.numbers, here.gradients, point.weight * volume);
      add_force(here, (point.weight * volume) * (weight_n_m3 + body_force.at(tet, point.at)), system.dead_n);
      ++system.points;
    }
    stiffness.add_to_upper(system.matrix);
  }
  return system;
}

/// The integrals of phi n over the surfaces of the median-dual cells, and the cells' volumes.
///
/// Shape:  surface has one entry a function and group, from per_sphere x groups.offsets[cell] on.
struct DualCells {
  Groups groups;
  std::size_t per_sphere = 1;
  std::vector<Vec3> surface;
  std::vector<double> volume_m3;

  std::span<Vec3> of(std::size_t cell) {
    return {surface.data() + per_sphere * groups.offsets[cell],
            surface.data() + per_sphere * groups.offsets[cell + 1]};
  }
  void add(std::size_t cell, const FunctionValues& here, const Vec3& area) {
    const std::span<const Index> spheres = groups.of(cell);
    const std::span<Vec3> sums = of(cell);
    std::size_t at = 0;
    for (std::size_t i = 0; i < here.numbers.size(); ++i) {
      const auto sphere = static_cast<Index>(here.numbers[i] / per_sphere);
      while (spheres[at] < sphere) ++at;
      Vec3& sum = sums[per_sphere * at + here.numbers[i] % per_sphere];
      sum = sum + here.values[i] * area;
    }
  }
};

/// Adds the surfaces inside one tet: for each edge a quadrilateral from the edge's middle over the two faces'
/// to the tet's, in two triangles, between the cells of its ends.
void add_inner_surfaces(const SphereField& field, std::size_t tet, FunctionValues& here, DualCells& cells) {
  const TetMesh& mesh = *field.mesh;
  const Tet& t = mesh.tets[tet];
  const Vec3 middle = point_in_tet(mesh, tet, {0.25, 0.25, 0.25, 0.25});
  for (const auto& [first, second] : kTetEdges) {
    const Index a = t[static_cast<std::size_t>(first)];
    const Index b = t[static_cast<std::size_t>(second)];
    const Vec3 edge = mesh.points[b] - mesh.points[a];
    const Vec3 half = 0.5 * (mesh.points[a] + mesh.points[b]);
    for (std::size_t other = 0; other < 4; ++other) {
      if (t[other] == a || t[other] == b) continue;
      const Vec3 face = (1.0 / 3.0) * (2.0 * half + mesh.points[t[other]]);
      Vec3 area = 0.5 * cross(face - half, middle - half);
      if (dot(area, edge) < 0.0) area = -1.0 * area;  // from a to b
      evaluate_moving(field, tet, (1.0 / 3.0) * (half + face + middle), here);
      cells.add(a, here, area);
      cells.add(b, here, -1.0 * area);
    }
  }
}

/// Adds the faces of a tet that lie on the boundary, by the rule of the boundary's own integrals.
void add_outer_surfaces(const SphereField& field, const std::vector<Face>& faces, FunctionValues& here,
                        DualCells& cells) {
  const TetMesh& mesh = *field.mesh;
  const std::vector<FacePoint> rule = build_dual_face_rule();
  for (const Face& face : faces) {
    if (face.tets[1] != kNoIndex) continue;
    const auto corner = [&](std::size_t i) -> const Vec3& { return mesh.points[face.vertices[i]]; };
    Vec3 area = 0.5 * cross(corner(1) - corner(0), corner(2) - corner(0));
    if (dot(area, corner(0) - point_in_tet(mesh, face.tets[0], {0.25, 0.25, 0.25, 0.25})) < 0.0)
      area = -1.0 * area;
    for (std::size_t p = 0; p < rule.size(); ++p) {
      Vec3 at;
      for (std::size_t i = 0; i < 3; ++i) at = at + rule[p].at[i] * corner(i);
      evaluate_moving(field, face.tets[0], at, here);
      cells.add(face.vertices[static_cast<std::size_t>(kDualFaceCorner[p])], here, rule[p].weight * area);
    }
  }
}

DualCells build_dual_cells(const SphereField& field) {
  const TetMesh& mesh = *field.mesh;
  DualCells cells;
  cells.groups = group_by_cell(field);
  cells.per_sphere = functions_per_sphere(field.functions);
  cells.surface.resize(cells.per_sphere * cells.groups.spheres.size());
  cells.volume_m3.assign(mesh.points.size(), 0.0);
  FunctionValues here;
  std::vector<Index> movers;
  for (std::size_t tet = 0; tet < mesh.tets.size(); ++tet) {
    for (const Index v : mesh.tets[tet]) cells.volume_m3[v] += 0.25 * tet_volume(mesh, tet);
    collect_moving(field, tet, movers);
    if (!movers.empty()) add_inner_surfaces(field, tet, here, cells);
  }
  add_outer_surfaces(field, build_faces(mesh), here, cells);
  return cells;
}

SphereSystem integrate_cells(const SphereField& field, const BoundaryProblem& problem) {
  const TetMesh& mesh = *field.mesh;
  DualCells cells = build_dual_cells(field);
  SphereSystem system = empty_system(field, cells.groups);
  GroupStiffness stiffness(problem.material);
  std::vector<Index> numbers;
  std::vector<Vec3> gradients;
  for (Index cell = 0; cell < mesh.points.size(); ++cell) {
    const std::span<const Index> group = cells.groups.of(cell);
    if (group.empty()) continue;
    const double volume = cells.volume_m3[cell];
    stiffness.start(group, cells.per_sphere);
    numbers.clear();
    for (const Index sphere : group) {
      for (std::size_t n = 0; n < cells.per_sphere; ++n)
        numbers.push_back(static_cast<Index>(cells.per_sphere * sphere + n));
    }
    gradients.clear();
    for (const Vec3& integral : cells.of(cell)) gradients.push_back((1.0 / volume) * integral);
    stiffness.add(numbers, gradients, volume);
    stiffness.add_to_upper(system.matrix);
    ++system.points;
  }
  add_body_forces(field, problem, build_tet_rule(4, 0), system);
  return system;
}

}  // namespace

SphereSystem build_body_system(const SphereField& field, const BoundaryProblem& problem,
                               const IntegrationOptions& integration) {
  SphereSystem system = integration.kind == SphereIntegration::kNodal
                            ? integrate_cells(field, problem)
                            : integrate_tets(field, problem, integration);
  mirror_upper(system.matrix);
  return system;
}

}  // namespace palpate::reference
