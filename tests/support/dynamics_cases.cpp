#include "tests/support/dynamics_cases.h"

#include <algorithm>
#include <cmath>

#include "core/base/random.h"
#include "core/mesh/geometry.h"
#include "core/mesh/topology.h"

namespace palpate::testing_support {

SpringNetwork make_edge_springs(const TetMesh& mesh, double young_modulus_pa) {
  SpringNetwork net;
  net.springs = build_edges(mesh);
  net.stiffness_n_per_m.resize(net.springs.size());
  for (const Edge& edge : net.springs)
    net.rest_length_m.push_back(length(mesh.points[edge[1]] - mesh.points[edge[0]]));
  for (const Tet& t : mesh.tets) {
    const double volume =
        signed_volume(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]);
    for (const auto& [i, j] : kTetEdges) {
      const Index a = t[static_cast<std::size_t>(i)];
      const Index b = t[static_cast<std::size_t>(j)];
      const auto place =
          std::lower_bound(net.springs.begin(), net.springs.end(), Edge{std::min(a, b), std::max(a, b)});
      const auto s = static_cast<std::size_t>(place - net.springs.begin());
      net.stiffness_n_per_m[s] += young_modulus_pa * volume / (net.rest_length_m[s] * net.rest_length_m[s]);
    }
  }
  return net;
}

std::vector<Vec3> make_random_field(std::size_t vertices, double size, std::uint64_t seed) {
  SplitMix64 random(seed);
  const auto one = [&] { return size * (2.0 * random.uniform() - 1.0); };
  std::vector<Vec3> field(vertices);
  for (Vec3& u : field) {
    u.x = one();
    u.y = one();
    u.z = one();
  }
  return field;
}

std::vector<Vec3> make_affine_field(const std::vector<Vec3>& points, const dynamics::Mat3& gradient,
                                    const Vec3& shift) {
  std::vector<Vec3> field;
  field.reserve(points.size());
  for (const Vec3& x : points) field.push_back(gradient * x + shift);
  return field;
}

dynamics::Mat3 make_rotation(const Vec3& axis, double angle) {
  const dynamics::Mat3 turn{{0.0, -axis.z, axis.y, axis.z, 0.0, -axis.x, -axis.y, axis.x, 0.0}};
  return dynamics::kIdentity + std::sin(angle) * turn +
         (1.0 - std::cos(angle)) * dynamics::multiply(turn, turn);
}

std::vector<Triangle> find_faces_at(const TetMesh& mesh, int axis, double at) {
  std::vector<Triangle> found;
  for (const Triangle& face : build_boundary(mesh)) {
    if (std::all_of(face.begin(), face.end(),
                    [&](Index v) { return std::abs(coordinate(mesh.points[v], axis) - at) < 1e-9; }))
      found.push_back(face);
  }
  return found;
}

double coordinate(const Vec3& v, int axis) {
  return axis == 0 ? v.x : (axis == 1 ? v.y : v.z);
}

double field_norm(const std::vector<Vec3>& a) {
  double sum = 0.0;
  for (const Vec3& v : a) sum += length_sq(v);
  return std::sqrt(sum);
}

double field_distance(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  std::vector<Vec3> off(a);
  for (std::size_t v = 0; v < off.size(); ++v) off[v] = off[v] - b[v];
  return field_norm(off);
}

}  // namespace palpate::testing_support
