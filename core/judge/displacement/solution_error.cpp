#include "core/judge/displacement/solution_error.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/base/error.h"
#include "core/judge/displacement/displacement.h"
#include "core/judge/mesh/compensated_sum.h"
#include "core/judge/mesh/tet_edges.h"

namespace palpate::judge {
namespace {

/// Gauss points a direction.
constexpr std::size_t kPoints = 5;

struct LinePoint {
  double at = 0.0;
  double weight = 0.0;
};

/// Gauss-Legendre on [0, 1]: the zeros of the Legendre polynomial by Newton's method from cos(pi (i + 3/4) /
/// (n + 1/2)).
std::array<LinePoint, kPoints> line_points() {
  constexpr double kDegree = kPoints;
  std::array<LinePoint, kPoints> points;
  for (std::size_t i = 0; i < kPoints; ++i) {
    double x = std::cos(std::numbers::pi * (static_cast<double>(i) + 0.75) / (kDegree + 0.5));
    double slope = 1.0;
    for (int step = 0; step < 20; ++step) {
      double before = 1.0;
      double value = x;
      for (std::size_t k = 2; k <= kPoints; ++k) {
        const double degree = static_cast<double>(k);
        const double next = ((2.0 * degree - 1.0) * x * value - (degree - 1.0) * before) / degree;
        before = value;
        value = next;
      }
      slope = kDegree * (x * value - before) / (x * x - 1.0);
      x -= value / slope;
    }
    points[i] = {0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope)};
  }
  return points;
}

/// A point of a tet, its share of the volume, and the ten quadratic shape functions there.
struct TetPoint {
  std::array<double, 4> barycentric{};
  double share = 0.0;
  std::array<double, 10> shape{};
};

/// The product rule on a cube that is folded into the tet: b1 = r, b2 = (1 - r) s, b3 = (1 - r)(1 - s) t,
/// whose determinant is (1 - r)^2 (1 - s). One factor costs two degrees: exact up to 2 n - 3.
std::vector<TetPoint> tet_points() {
  const std::array<LinePoint, kPoints> line = line_points();
  std::vector<TetPoint> points;
  for (const LinePoint& r : line) {
    for (const LinePoint& s : line) {
      for (const LinePoint& t : line) {
        TetPoint point;
        auto& b = point.barycentric;
        b = {0.0, r.at, (1.0 - r.at) * s.at, (1.0 - r.at) * (1.0 - s.at) * t.at};
        b[0] = (1.0 - r.at) * (1.0 - s.at) * (1.0 - t.at);
        point.share = 6.0 * r.weight * s.weight * t.weight * (1.0 - r.at) * (1.0 - r.at) * (1.0 - s.at);
        for (std::size_t i = 0; i < 4; ++i) point.shape[i] = b[i] * (2.0 * b[i] - 1.0);
        for (std::size_t e = 0; e < kTetEdges.size(); ++e) {
          const auto& [i, j] = kTetEdges[e];
          point.shape[4 + e] = 4.0 * b[static_cast<std::size_t>(i)] * b[static_cast<std::size_t>(j)];
        }
        points.push_back(point);
      }
    }
  }
  return points;
}

double volume_of(const TetMesh& mesh, const Tet& t) {
  const Vec3& o = mesh.points[t[0]];
  return dot(cross(mesh.points[t[1]] - o, mesh.points[t[2]] - o), mesh.points[t[3]] - o) / 6.0;
}

/// The ten values of a quadratic field in one tet.
std::array<Vec3, 10> values_of(const TetMesh& mesh, const TetEdges& edges, std::span<const Vec3> field,
                               std::size_t t) {
  std::array<Vec3, 10> values;
  for (std::size_t i = 0; i < 4; ++i) values[i] = field[mesh.tets[t][i]];
  for (std::size_t e = 0; e < 6; ++e) values[4 + e] = field[mesh.points.size() + edges.of_tet[t][e]];
  return values;
}

void check_size(const TetMesh& mesh, const TetEdges& edges, std::span<const Vec3> field) {
  require(field.size() == mesh.points.size() || field.size() == mesh.points.size() + edges.edges.size(),
          "a field has one value a vertex, or one more an edge");
}

/// Gradient of a quadratic field at local vertex `corner`: 3 grad b_i u_i of the corner itself, -grad b_j u_j
/// of the others, and 4 grad b_j of the edge from the corner to j.
std::array<Vec3, 3> gradient_at_corner(const TetMesh& mesh, const Tet& tet,
                                       const std::array<Vec3, 10>& values, std::size_t corner) {
  const double six_volumes = 6.0 * volume_of(mesh, tet);
  std::array<Vec3, 3> rows{};
  const auto add = [&](const Vec3& u, const Vec3& direction) {
    rows[0] = rows[0] + u.x * direction;
    rows[1] = rows[1] + u.y * direction;
    rows[2] = rows[2] + u.z * direction;
  };
  std::array<Vec3, 4> slope;  // gradients of the barycentric coordinates
  for (std::size_t i = 0; i < 4; ++i) {
    const auto& face = kTetFaces[i];
    const Vec3& a = mesh.points[tet[static_cast<std::size_t>(face[0])]];
    const Vec3& b = mesh.points[tet[static_cast<std::size_t>(face[1])]];
    const Vec3& c = mesh.points[tet[static_cast<std::size_t>(face[2])]];
    slope[i] = (-1.0 / six_volumes) * cross(b - a, c - a);
  }
  for (std::size_t i = 0; i < 4; ++i) add(values[i], (i == corner ? 3.0 : -1.0) * slope[i]);
  for (std::size_t e = 0; e < kTetEdges.size(); ++e) {
    const auto i = static_cast<std::size_t>(kTetEdges[e][0]);
    const auto j = static_cast<std::size_t>(kTetEdges[e][1]);
    if (i == corner) add(values[4 + e], 4.0 * slope[j]);
    if (j == corner) add(values[4 + e], 4.0 * slope[i]);
  }
  return rows;
}

}  // namespace

SolutionError compare_with_solution(const TetMesh& mesh, std::span<const Vec3> field,
                                    const std::function<Vec3(const Vec3&)>& truth) {
  const TetEdges edges = number_edges(mesh);
  check_size(mesh, edges, field);
  const std::vector<Vec3> nodes = with_midpoints(mesh, field);
  const std::vector<TetPoint> points = tet_points();
  CompensatedSum error_sum;
  CompensatedSum truth_sum;
  double error_max = 0.0;
  double truth_max = 0.0;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const std::array<Vec3, 10> values = values_of(mesh, edges, nodes, t);
    const double volume = volume_of(mesh, mesh.tets[t]);
    for (const TetPoint& point : points) {
      Vec3 x;
      Vec3 u;
      for (std::size_t i = 0; i < 4; ++i) x = x + point.barycentric[i] * mesh.points[mesh.tets[t][i]];
      for (std::size_t i = 0; i < 10; ++i) u = u + point.shape[i] * values[i];
      const Vec3 known = truth(x);
      const double error_sq = length_sq(u - known);
      const double truth_sq = length_sq(known);
      error_sum.add(volume * point.share * error_sq);
      truth_sum.add(volume * point.share * truth_sq);
      error_max = std::max(error_max, error_sq);
      truth_max = std::max(truth_max, truth_sq);
    }
  }
  if (!std::isfinite(error_sum.value()) || !std::isfinite(truth_sum.value())) {
    throw InputError("the displacement", 0, "finite numbers", "others");
  }
  if (!(truth_sum.value() > 0.0)) throw InputError("the known solution", 0, "one that is not zero", "zero");
  return {std::sqrt(error_sum.value()), std::sqrt(error_sum.value() / truth_sum.value()),
          std::sqrt(error_max / truth_max)};
}

std::array<Vec3, 3> stress_at_vertex(const TetMesh& mesh, std::span<const Vec3> field, Index vertex,
                                     double lambda_pa, double mu_pa) {
  const TetEdges edges = number_edges(mesh);
  check_size(mesh, edges, field);
  const std::vector<Vec3> nodes = with_midpoints(mesh, field);
  std::array<Vec3, 3> g{};
  double volume_sum = 0.0;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const Tet& tet = mesh.tets[t];
    const auto corner = static_cast<std::size_t>(std::find(tet.begin(), tet.end(), vertex) - tet.begin());
    if (corner == tet.size()) continue;
    const double volume = volume_of(mesh, tet);
    const std::array<Vec3, 3> here = gradient_at_corner(mesh, tet, values_of(mesh, edges, nodes, t), corner);
    for (std::size_t row = 0; row < 3; ++row) g[row] = g[row] + volume * here[row];
    volume_sum += volume;
  }
  require(volume_sum > 0.0, "stress_at_vertex: no tet has this vertex");
  for (Vec3& row : g) row = (1.0 / volume_sum) * row;
  const double pressure = lambda_pa * (g[0].x + g[1].y + g[2].z);
  const double xy = mu_pa * (g[0].y + g[1].x);
  const double yz = mu_pa * (g[1].z + g[2].y);
  const double zx = mu_pa * (g[2].x + g[0].z);
  return {Vec3{pressure + 2.0 * mu_pa * g[0].x, xy, zx},
          {xy, pressure + 2.0 * mu_pa * g[1].y, yz},
          {zx, yz, pressure + 2.0 * mu_pa * g[2].z}};
}

double observed_order(double coarse_error, double coarse_cells, double fine_error, double fine_cells) {
  require(coarse_error > 0.0 && fine_error > 0.0 && coarse_cells > 0.0 && coarse_cells < fine_cells,
          "observed_order: errors above 0 on meshes that differ");
  return std::log(coarse_error / fine_error) / std::log(fine_cells / coarse_cells);
}

}  // namespace palpate::judge
