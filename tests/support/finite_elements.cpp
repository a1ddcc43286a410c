#include "tests/support/finite_elements.h"

#include <algorithm>
#include <cmath>

#include "core/mesh/shapes/shapes.h"

namespace palpate::test {

/// A field at the vertices and edge midpoints of a mesh.
std::vector<Vec3> at_nodes(const TetMesh& mesh, const Field& field) {
  std::vector<Vec3> values;
  for (const Vec3& point : mesh.points) values.push_back(field(point));
  for (const Edge& edge : build_edges(mesh))
    values.push_back(field(0.5 * (mesh.points[edge[0]] + mesh.points[edge[1]])));
  return values;
}

double difference(const std::vector<Vec3>& found, const std::vector<Vec3>& wanted) {
  if (found.size() != wanted.size()) return INFINITY;
  double most = 0.0;
  double scale = 0.0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    most = std::max(most, length(found[i] - wanted[i]));
    scale = std::max(scale, length(wanted[i]));
  }
  return most / scale;
}

/// Boundary faces whose corners all have `is_in`.
std::vector<Triangle> faces_where(const TetMesh& mesh, const std::function<bool(const Vec3&)>& is_in) {
  std::vector<Triangle> faces;
  for (const Triangle& face : build_boundary(mesh)) {
    if (std::all_of(face.begin(), face.end(), [&](Index v) { return is_in(mesh.points[v]); }))
      faces.push_back(face);
  }
  return faces;
}

FacePatch patch_where(const TetMesh& mesh, const std::function<bool(const Vec3&)>& is_in, double weight) {
  FacePatch patch{faces_where(mesh, is_in), {}};
  patch.weight.assign(patch.faces.size(), weight);
  return patch;
}

bool is_everywhere(const Vec3&) {
  return true;
}
bool is_at_x0(const Vec3& p) {
  return p.x == 0.0;
}

TetMesh irregular_cube() {
  return build_kuhn_cube(3, 0.4, 11);
}

void hold_planes(const TetMesh& mesh, BoundaryProblem& problem) {
  problem.held.push_back({faces_where(mesh, is_at_x0), {true, false, false}, {}});
  problem.held.push_back(
      {faces_where(mesh, [](const Vec3& p) { return p.y == 0.0; }), {false, true, false}, {}});
  problem.held.push_back(
      {faces_where(mesh, [](const Vec3& p) { return p.z == 0.0; }), {false, false, true}, {}});
}

void pull(const TetMesh& mesh, const std::function<bool(const Vec3&)>& is_in, const Vec3& traction_pa,
          BoundaryProblem& problem) {
  problem.tractions.push_back({patch_where(mesh, is_in), traction_pa, 0.0});
}

BoundaryProblem supported_cube(const TetMesh& mesh, double scale) {
  BoundaryProblem problem;
  problem.material = {10000.0, 0.45, 1050.0};
  problem.supports.push_back({patch_where(
                                  mesh, [](const Vec3& p) { return p.z == 0.0; }, 0.7),
                              1e5,
                              {}});
  problem.supports.push_back(
      {patch_where(mesh, [](const Vec3& p) { return p.x == 1.0; }), 5e4, scale * Vec3{-0.1, 0.05, 0.0}});
  pull(
      mesh, [](const Vec3& p) { return p.y == 1.0; }, scale * Vec3{200.0, 0.0, -100.0}, problem);
  return problem;
}

}  // namespace palpate::test
