#include "core/judge/displacement/displacement.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/error.h"
#include "core/judge/displacement/rigid_part.h"
#include "core/judge/mesh/compensated_sum.h"
#include "core/judge/mesh/tet_edges.h"

namespace palpate::judge {
namespace {

/// A field whose deformation is a smaller share of it than this is a rigid motion, rounded.
constexpr double kRigid = 1e-12;

/// A tet's volume and the gradients of its four barycentric coordinates.
struct Element {
  double volume = 0.0;
  std::array<Vec3, 4> gradient;
};

Element element_of(const TetMesh& mesh, const Tet& tet) {
  const Vec3& o = mesh.points[tet[0]];
  const Vec3 a = mesh.points[tet[1]] - o;
  const Vec3 b = mesh.points[tet[2]] - o;
  const Vec3 c = mesh.points[tet[3]] - o;
  const double six_volumes = dot(cross(a, b), c);
  Element element;
  if (!(six_volumes > 0.0)) return element;
  element.volume = six_volumes / 6.0;
  element.gradient[1] = (1.0 / six_volumes) * cross(b, c);
  element.gradient[2] = (1.0 / six_volumes) * cross(c, a);
  element.gradient[3] = (1.0 / six_volumes) * cross(a, b);
  element.gradient[0] = -1.0 * (element.gradient[1] + element.gradient[2] + element.gradient[3]);
  return element;
}

/// Rows of a displacement gradient: row i is the gradient of component i.
using Gradient = std::array<Vec3, 3>;

void add_gradient(Gradient& sum, const Vec3& u, const Vec3& shape_gradient) {
  sum[0] = sum[0] + u.x * shape_gradient;
  sum[1] = sum[1] + u.y * shape_gradient;
  sum[2] = sum[2] + u.z * shape_gradient;
}

/// lambda (tr e)^2 + 2 mu e : e with e the symmetric part of g.
double energy_density(const Gradient& g, double lambda, double mu) {
  const double trace = g[0].x + g[1].y + g[2].z;
  const double xy = 0.5 * (g[0].y + g[1].x);
  const double yz = 0.5 * (g[1].z + g[2].y);
  const double zx = 0.5 * (g[2].x + g[0].z);
  const double squares =
      g[0].x * g[0].x + g[1].y * g[1].y + g[2].z * g[2].z + 2.0 * (xy * xy + yz * yz + zx * zx);
  return lambda * trace * trace + 2.0 * mu * squares;
}

double linear_energy(const TetMesh& mesh, std::span<const Vec3> field, double lambda, double mu) {
  CompensatedSum sum;
  for (const Tet& tet : mesh.tets) {
    const Element element = element_of(mesh, tet);
    Gradient g{};
    for (std::size_t i = 0; i < 4; ++i) add_gradient(g, field[tet[i]], element.gradient[i]);
    sum.add(element.volume * energy_density(g, lambda, mu));
  }
  return sum.value();
}

/// Gradients of quadratic shape functions are linear, so four points of degree 2 are exact.
double quadratic_energy(const TetMesh& mesh, const TetEdges& edges, std::span<const Vec3> field,
                        double lambda, double mu) {
  const double near = (5.0 + 3.0 * std::sqrt(5.0)) / 20.0;
  const double far = (5.0 - std::sqrt(5.0)) / 20.0;
  const std::size_t n = mesh.points.size();
  CompensatedSum sum;
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const Tet& tet = mesh.tets[t];
    const Element element = element_of(mesh, tet);
    for (std::size_t at = 0; at < 4; ++at) {
      const auto share = [&](std::size_t i) { return i == at ? near : far; };
      Gradient g{};
      for (std::size_t i = 0; i < 4; ++i)
        add_gradient(g, field[tet[i]], (4.0 * share(i) - 1.0) * element.gradient[i]);
      for (std::size_t k = 0; k < kTetEdges.size(); ++k) {
        const auto i = static_cast<std::size_t>(kTetEdges[k][0]);
        const auto j = static_cast<std::size_t>(kTetEdges[k][1]);
        add_gradient(g, field[n + edges.of_tet[t][k]],
                     4.0 * (share(i) * element.gradient[j] + share(j) * element.gradient[i]));
      }
      sum.add(0.25 * element.volume * energy_density(g, lambda, mu));
    }
  }
  return sum.value();
}

void require_indices(const TetMesh& mesh) {
  for (const Tet& tet : mesh.tets)
    for (const Index v : tet)
      require(v < mesh.points.size(), "displacement: a tet has a vertex that does not exist");
}

std::vector<double> linear_shares(const TetMesh& mesh) {
  std::vector<double> share(mesh.points.size(), 0.0);
  for (const Tet& tet : mesh.tets) {
    const double volume = element_of(mesh, tet).volume;
    for (const Index v : tet) share[v] += 0.25 * volume;
  }
  return share;
}

std::vector<double> quadratic_shares(const TetMesh& mesh, const TetEdges& edges) {
  const std::size_t n = mesh.points.size();
  std::vector<double> share(n + edges.edges.size(), 0.0);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const double volume = element_of(mesh, mesh.tets[t]).volume;
    for (const Index v : mesh.tets[t]) share[v] += volume / 32.0;
    for (const Index e : edges.of_tet[t]) share[n + e] += 7.0 * volume / 48.0;
  }
  return share;
}

/// What the fields of a mesh are measured with, made once for several of them.
class Ruler {
 public:
  Ruler(const TetMesh& mesh, std::size_t rows, double lambda, double mu)
      : mesh_(mesh), lambda_(lambda), mu_(mu) {
    require(mu > 0.0 && 3.0 * lambda + 2.0 * mu > 0.0, "displacement: the material is not positive");
    require_indices(mesh);
    points_ = mesh.points;
    if (rows == mesh.points.size()) {
      share_ = linear_shares(mesh);
      return;
    }
    edges_ = number_edges(mesh);
    require(rows == mesh.points.size() + edges_.edges.size(),
            "displacement: neither one row a vertex nor one a vertex and edge");
    share_ = quadratic_shares(mesh, edges_);
    for (const Edge& edge : edges_.edges)
      points_.push_back(0.5 * (mesh.points[edge[0]] + mesh.points[edge[1]]));
  }

  DisplacementSize measure(std::span<const Vec3> field) const {
    DisplacementSize size;
    CompensatedSum sum;
    CompensatedSum strained;
    const std::vector<Vec3> rest = without_rigid_motion(points_, share_, field);
    double most = 0.0;
    for (std::size_t i = 0; i < field.size(); ++i) {
      const double square = length_sq(field[i]);
      sum.add(share_[i] * square);
      strained.add(share_[i] * length_sq(rest[i]));
      if (square > most) {
        most = square;
        size.max_point = i;
      }
    }
    size.l2 = std::sqrt(sum.value());
    size.deformation = std::sqrt(strained.value());
    size.max = std::sqrt(most);
    const double energy = edges_.edges.empty() ? linear_energy(mesh_, field, lambda_, mu_)
                                               : quadratic_energy(mesh_, edges_, field, lambda_, mu_);
    size.energy = std::sqrt(std::max(energy, 0.0));
    return size;
  }

 private:
  const TetMesh& mesh_;
  double lambda_;
  double mu_;
  TetEdges edges_;  // empty for fields that are linear in each tet
  std::vector<Vec3> points_;
  std::vector<double> share_;
};

}  // namespace

void require_finite(std::span<const Vec3> field, const char* name) {
  for (std::size_t i = 0; i < field.size(); ++i) {
    if (!is_finite(field[i]))
      throw InputError(name, 0, "finite numbers", "one that is not finite at point " + std::to_string(i));
  }
}

DisplacementSize measure_displacement(const TetMesh& mesh, std::span<const Vec3> field, double lambda_pa,
                                      double mu_pa) {
  return Ruler(mesh, field.size(), lambda_pa, mu_pa).measure(field);
}

std::vector<double> volume_shares(const TetMesh& mesh, std::size_t rows) {
  require_indices(mesh);
  if (rows == mesh.points.size()) return linear_shares(mesh);
  std::vector<double> share = quadratic_shares(mesh, number_edges(mesh));
  require(rows == share.size(), "displacement: neither one row a vertex nor one a vertex and edge");
  return share;
}

std::vector<Vec3> with_midpoints(const TetMesh& mesh, std::span<const Vec3> field) {
  std::vector<Vec3> all(field.begin(), field.end());
  const TetEdges edges = number_edges(mesh);
  const std::size_t n = mesh.points.size();
  if (field.size() != n + edges.edges.size()) {
    require(field.size() == n, "displacement: neither one row a vertex nor one a vertex and edge");
    for (const Edge& edge : edges.edges) all.push_back(0.5 * (field[edge[0]] + field[edge[1]]));
  }
  return all;
}

DisplacementError compare_displacement(const TetMesh& mesh, std::span<const Vec3> field,
                                       std::span<const Vec3> truth, double lambda_pa, double mu_pa) {
  require(field.size() == truth.size(), "compare_displacement: fields of different sizes");
  require_finite(field, "displacement");
  require_finite(truth, "reference displacement");
  std::vector<Vec3> difference(field.size());
  for (std::size_t i = 0; i < field.size(); ++i) difference[i] = field[i] - truth[i];
  const Ruler ruler(mesh, field.size(), lambda_pa, mu_pa);
  const DisplacementSize off = ruler.measure(difference);
  const DisplacementSize whole = ruler.measure(truth);
  if (!(whole.l2 > 0.0))
    throw InputError("reference displacement", 0, "a body that moves", "zero displacements");
  if (!(whole.energy > 0.0))
    throw InputError("reference displacement", 0, "a body that is strained", "a rigid motion");
  if (!(whole.deformation > kRigid * whole.l2))
    throw InputError("reference displacement", 0, "a body that is strained", "a rigid motion");
  DisplacementError error;
  error.relative_l2 = off.l2 / whole.l2;
  error.relative_deformation = off.deformation / whole.deformation;
  error.relative_max = off.max / whole.max;
  error.relative_energy = off.energy / whole.energy;
  error.worst_point = off.max_point;
  const double strained = whole.deformation / whole.l2;
  error.rigid_share = std::max(0.0, 1.0 - strained * strained);
  return error;
}

}  // namespace palpate::judge
