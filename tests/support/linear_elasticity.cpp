#include "tests/support/linear_elasticity.h"

#include <array>
#include <cmath>

#include "core/base/error.h"
#include "core/mesh/geometry.h"
#include "core/mesh/topology.h"

namespace palpate::testing_support {
namespace {

constexpr double kWave = 2.0;

struct Element {
  double volume;
  std::array<Vec3, 4> gradient;
};

std::vector<Element> build_elements(const TetMesh& mesh) {
  std::vector<Element> elements;
  elements.reserve(mesh.tets.size());
  for (const Tet& tet : mesh.tets) {
    Element element{};
    element.volume =
        signed_volume(mesh.points[tet[0]], mesh.points[tet[1]], mesh.points[tet[2]], mesh.points[tet[3]]);
    for (std::size_t i = 0; i < 4; ++i) {  // inward area vector of the face opposite to i, over 3 V
      const auto corner = [&](int k) { return mesh.points[tet[kTetFaces[i][static_cast<std::size_t>(k)]]]; };
      element.gradient[i] =
          (-1.0 / (6.0 * element.volume)) * cross(corner(1) - corner(0), corner(2) - corner(0));
    }
    elements.push_back(element);
  }
  return elements;
}

/// K u; entries of held vertices are put to zero.
std::vector<Vec3> stiffness_times(const TetMesh& mesh, const std::vector<Element>& elements,
                                  const std::vector<std::uint8_t>& held, const LameParameters& material,
                                  const std::vector<Vec3>& u) {
  std::vector<Vec3> force(u.size());
  for (std::size_t t = 0; t < elements.size(); ++t) {
    const Tet& tet = mesh.tets[t];
    const auto& g = elements[t].gradient;
    double divergence = 0.0;
    for (std::size_t j = 0; j < 4; ++j) divergence += dot(u[tet[j]], g[j]);
    for (std::size_t i = 0; i < 4; ++i) {
      if (held[tet[i]] != 0) continue;
      Vec3 sum = material.lambda_pa * divergence * g[i];
      for (std::size_t j = 0; j < 4; ++j)
        sum = sum + material.mu_pa * (dot(g[i], g[j]) * u[tet[j]] + dot(g[i], u[tet[j]]) * g[j]);
      force[tet[i]] = force[tet[i]] + elements[t].volume * sum;
    }
  }
  return force;
}

double product(const std::vector<Vec3>& a, const std::vector<Vec3>& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += dot(a[i], b[i]);
  return sum;
}

}  // namespace

Vec3 smooth_displacement(const Vec3& p) {
  return {std::sin(kWave * p.x) * std::cos(kWave * p.y), std::sin(kWave * p.y) * std::cos(kWave * p.z),
          std::sin(kWave * p.z) * std::cos(kWave * p.x)};
}

// div u = k (cx cy + cy cz + cz cx), Laplace u = -2 k^2 u; f = -(lambda + mu) grad div u - mu Laplace u.
Vec3 smooth_body_force(const Vec3& p, const LameParameters& material) {
  const double k_sq = kWave * kWave;
  const Vec3 s{std::sin(kWave * p.x), std::sin(kWave * p.y), std::sin(kWave * p.z)};
  const Vec3 c{std::cos(kWave * p.x), std::cos(kWave * p.y), std::cos(kWave * p.z)};
  const Vec3 grad_div = -k_sq * Vec3{s.x * (c.y + c.z), s.y * (c.z + c.x), s.z * (c.x + c.y)};
  return -(material.lambda_pa + material.mu_pa) * grad_div +
         2.0 * k_sq * material.mu_pa * smooth_displacement(p);
}

std::vector<Vec3> solve_smooth_problem(const TetMesh& mesh, const LameParameters& material,
                                       const LameParameters& loaded_as) {
  const std::vector<Element> elements = build_elements(mesh);
  const std::vector<std::uint8_t> held = build_boundary_vertex_flags(mesh);
  std::vector<Vec3> u(mesh.points.size());
  std::vector<Vec3> residual(mesh.points.size());
  for (std::size_t v = 0; v < u.size(); ++v)
    if (held[v] != 0) u[v] = smooth_displacement(mesh.points[v]);
  for (std::size_t t = 0; t < elements.size(); ++t)
    for (const Index v : mesh.tets[t])
      if (held[v] == 0)
        residual[v] = residual[v] + 0.25 * elements[t].volume * smooth_body_force(mesh.points[v], loaded_as);
  const std::vector<Vec3> from_held = stiffness_times(mesh, elements, held, material, u);
  for (std::size_t v = 0; v < u.size(); ++v) residual[v] = residual[v] - from_held[v];

  std::vector<Vec3> direction = residual;
  double square = product(residual, residual);
  const double enough = 1e-24 * square;
  for (int step = 0; square > enough; ++step) {
    require(step < 5000, "solve_smooth_problem: no convergence");
    const std::vector<Vec3> image = stiffness_times(mesh, elements, held, material, direction);
    const double length = square / product(direction, image);
    for (std::size_t v = 0; v < u.size(); ++v) {
      u[v] = u[v] + length * direction[v];
      residual[v] = residual[v] - length * image[v];
    }
    const double next = product(residual, residual);
    for (std::size_t v = 0; v < u.size(); ++v) direction[v] = residual[v] + (next / square) * direction[v];
    square = next;
  }
  return u;
}

}  // namespace palpate::testing_support
