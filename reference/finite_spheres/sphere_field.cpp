#include "reference/finite_spheres/sphere_field.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/topology.h"
#include "core/simplify/sizing/triangle_tree.h"

namespace palpate::reference {

SphereField build_sphere_field(const TetMesh& mesh, double factor, SphereFunctions functions) {
  SphereField field;
  field.mesh = &mesh;
  field.spheres = build_spheres(mesh, factor);
  field.functions = functions;
  field.moving_spheres = mesh.points.size();
  field.moving.resize(mesh.points.size());
  for (Index v = 0; v < field.moving.size(); ++v) field.moving[v] = v;
  return field;
}

void localise(SphereField& field, std::span<const Triangle> loaded, double radius_m) {
  if (loaded.empty())
    throw InputError("local_radius_m", 0, "a load on faces or vertices, around which spheres move",
                     "none but body forces and supports at rest");
  const auto& points = field.mesh->points;
  field.moving_spheres = 0;
  for (Index v = 0; v < points.size(); ++v) {
    const bool is_near = std::any_of(loaded.begin(), loaded.end(), [&](const Triangle& t) {
      const double distance_sq = t[0] == t[1] ? length_sq(points[v] - points[t[0]])
                                              : simplify::distance_sq_to_triangle(points[v], points[t[0]],
                                                                                  points[t[1]], points[t[2]]);
      return distance_sq <= radius_m * radius_m;
    });
    field.moving[v] = is_near ? static_cast<Index>(field.moving_spheres++) : kNoIndex;
  }
}

void evaluate_moving(const SphereField& field, std::size_t tet, const Vec3& at, FunctionValues& out) {
  evaluate_functions(field.spheres, field.functions, tet, at, out);
  const std::size_t per = functions_per_sphere(field.functions);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < out.numbers.size(); ++i) {
    const Index place = field.moving[out.numbers[i] / per];
    if (place == kNoIndex) continue;
    out.numbers[kept] = static_cast<Index>(per * place + out.numbers[i] % per);
    out.values[kept] = out.values[i];
    out.gradients[kept++] = out.gradients[i];
  }
  out.numbers.resize(kept);
  out.values.resize(kept);
  out.gradients.resize(kept);
}

void collect_moving(const SphereField& field, std::size_t tet, std::vector<Index>& out) {
  out.clear();
  for (const Index sphere : field.spheres.of(tet)) {
    if (field.moving[sphere] != kNoIndex) out.push_back(field.moving[sphere]);
  }
}

Vec3 sum_values(const FunctionValues& at, std::span<const Vec3> coefficients) {
  Vec3 sum;
  for (std::size_t i = 0; i < at.numbers.size(); ++i) sum = sum + at.values[i] * coefficients[at.numbers[i]];
  return sum;
}

dynamics::Mat3 sum_gradients(const FunctionValues& at, std::span<const Vec3> coefficients) {
  dynamics::Mat3 sum;
  for (std::size_t i = 0; i < at.numbers.size(); ++i)
    dynamics::add_outer(sum, coefficients[at.numbers[i]], at.gradients[i]);
  return sum;
}

std::vector<Vec3> sample_displacement(const SphereField& field, std::span<const Vec3> coefficients,
                                      bool with_midpoints) {
  require(coefficients.size() == field.coefficients(), "one vector a coefficient");
  const TetMesh& mesh = *field.mesh;
  const VertexStars stars = build_vertex_stars(mesh);
  std::vector<Vec3> displacement;
  FunctionValues here;
  const auto add = [&](Index tet, const Vec3& at) {
    evaluate_moving(field, tet, at, here);
    displacement.push_back(sum_values(here, coefficients));
  };
  for (Index v = 0; v < mesh.points.size(); ++v) add(stars.of(v).front(), mesh.points[v]);
  if (!with_midpoints) return displacement;
  for (const auto& [a, b] : build_edges(mesh)) {
    const auto star = stars.of(a);
    const auto holds = [&mesh, other = b](Index tet) {
      return std::find(mesh.tets[tet].begin(), mesh.tets[tet].end(), other) != mesh.tets[tet].end();
    };
    const auto tet = std::find_if(star.begin(), star.end(), holds);
    require(tet != star.end(), "each edge has a tet");
    add(*tet, 0.5 * (mesh.points[a] + mesh.points[b]));
  }
  return displacement;
}

Vec3 point_in_tet(const TetMesh& mesh, std::size_t tet, const std::array<double, 4>& at) {
  Vec3 sum;
  for (std::size_t i = 0; i < 4; ++i) sum = sum + at[i] * mesh.points[mesh.tets[tet][i]];
  return sum;
}

double tet_volume(const TetMesh& mesh, std::size_t tet) {
  const Tet& t = mesh.tets[tet];
  return signed_volume(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]);
}

}  // namespace palpate::reference
