#include "reference/finite_spheres/collocation.h"

#include <Eigen/Eigenvalues>
#include <Eigen/SparseLU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/dynamics/linear_algebra/matrix3.h"
#include "core/mesh/geometry.h"
#include "core/mesh/topology.h"

namespace palpate::reference {
namespace {

using dynamics::Mat3;
using dynamics::outer;
using Vector9 = Eigen::Matrix<double, 9, 1>;
using Matrix9 = Eigen::Matrix<double, 9, 9>;

/// A quadratic polynomial without its constant has nine coefficients; a few values more make it a fit.
constexpr std::size_t kLeastNeighbours = 13;  // the centre among them
/// Least over largest eigenvalue of the moments, in radii, that is no rounding.
constexpr double kLeastEigenvalue = 1e-7;
constexpr double kGrowth = 1.25;

/// The monomials whose coefficients are the derivatives.
Vector9 monomials(const Vec3& d) {
  Vector9 q;
  q << d.x, d.y, d.z, 0.5 * d.x * d.x, 0.5 * d.y * d.y, 0.5 * d.z * d.z, d.y * d.z, d.x * d.z, d.x * d.y;
  return q;
}

/// The vertices that share a tet with each vertex, itself among them, increasing.
std::vector<std::vector<Index>> list_rings(const TetMesh& mesh) {
  std::vector<std::vector<Index>> rings(mesh.points.size());
  for (const Tet& tet : mesh.tets) {
    for (const Index v : tet) rings[v].insert(rings[v].end(), tet.begin(), tet.end());
  }
  for (std::vector<Index>& ring : rings) {
    std::sort(ring.begin(), ring.end());
    ring.erase(std::unique(ring.begin(), ring.end()), ring.end());
  }
  return rings;
}

void keep_each_once(std::vector<Index>& numbers) {
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
}

/// Adds the vertices that share a tet with one of these; false if there are none.
bool add_ring(const std::vector<std::vector<Index>>& rings, std::vector<Index>& numbers) {
  const std::vector<Index> before = numbers;
  for (const Index v : before) numbers.insert(numbers.end(), rings[v].begin(), rings[v].end());
  keep_each_once(numbers);
  return numbers.size() > before.size();
}

/// The stencil over these centres; false if they don't settle a quadratic polynomial.
bool fit_stencil(const TetMesh& mesh, Index centre, double radius, const std::vector<Index>& numbers,
                 DerivativeStencil& out) {
  if (numbers.size() < kLeastNeighbours) return false;
  Matrix9 moments = Matrix9::Zero();
  std::vector<Vector9> weighed;
  weighed.reserve(numbers.size());
  for (const Index v : numbers) {
    const Vec3 d = (1.0 / radius) * (mesh.points[v] - mesh.points[centre]);
    const Vector9 q = monomials(d);
    weighed.emplace_back((v == centre ? 0.0 : quartic_spline(length(d))) * q);
    moments += weighed.back() * q.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Matrix9> eigen(moments);
  if (!(eigen.eigenvalues()[0] > kLeastEigenvalue * eigen.eigenvalues()[8])) return false;
  const Matrix9 inverse = eigen.eigenvectors() * eigen.eigenvalues().cwiseInverse().asDiagonal() *
                          eigen.eigenvectors().transpose();
  out.neighbours = numbers;
  out.first.assign(numbers.size(), {});
  out.second.assign(numbers.size(), {});
  Vector9 sum = Vector9::Zero();
  std::size_t own = 0;
  const auto set = [&](std::size_t k, const Vector9& c) {
    out.first[k] = (1.0 / radius) * Vec3{c[0], c[1], c[2]};
    for (std::size_t i = 0; i < 6; ++i)
      out.second[k].at(i) = c[static_cast<Eigen::Index>(3 + i)] / (radius * radius);
  };
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    const Vector9 c = inverse * weighed[k];
    sum += c;
    if (numbers[k] == centre) own = k;
    set(k, c);
  }
  set(own, -sum);
  return true;
}

/// A boundary vertex: its outward area, a third of its faces', and what acts there.
struct BoundaryVertex {
  bool is_boundary = false;
  Vec3 area_m2;
  double volume_m3 = 0.0;  ///< a quarter of its tets'
  double support_n_per_m = 0.0;
  Vec3 force_n;  ///< tractions, forces, and supports that are moved
  std::array<bool, 3> held{};
  Vec3 held_at_m;
};

Vec3 area_of(const TetMesh& mesh, const Triangle& f) {
  return 0.5 * cross(mesh.points[f[1]] - mesh.points[f[0]], mesh.points[f[2]] - mesh.points[f[0]]);
}

std::vector<BoundaryVertex> gather_boundary(const TetMesh& mesh, const BoundaryProblem& problem) {
  std::vector<BoundaryVertex> out(mesh.points.size());
  for (const Triangle& f : build_boundary(mesh)) {
    const Vec3 third = (1.0 / 3.0) * area_of(mesh, f);
    for (const Index v : f) {
      out[v].is_boundary = true;
      out[v].area_m2 = out[v].area_m2 + third;
    }
  }
  for (const Tet& t : mesh.tets) {
    const double quarter =
        0.25 * signed_volume(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]);
    for (const Index v : t) out[v].volume_m3 += quarter;
  }
  const auto each_corner = [&](const FacePatch& patch, const auto& add) {
    for (std::size_t k = 0; k < patch.faces.size(); ++k) {
      const Vec3 third = (patch.weight[k] / 3.0) * area_of(mesh, patch.faces[k]);
      for (const Index v : patch.faces[k]) add(out[v], third);
    }
  };
  for (const ElasticSupport& support : problem.supports) {
    each_corner(support.patch, [&](BoundaryVertex& at, const Vec3& third) {
      const double stiffness = support.stiffness_pa_per_m * length(third);
      at.support_n_per_m += stiffness;
      at.force_n = at.force_n + stiffness * support.by_m;
    });
  }
  for (const Traction& traction : problem.tractions) {
    each_corner(traction.patch, [&](BoundaryVertex& at, const Vec3& third) {
      at.force_n = at.force_n + length(third) * traction.traction_pa - traction.pressure_pa * third;
    });
  }
  for (const NodalForce& force : problem.nodal_forces) {
    if (!out[force.vertex].is_boundary)
      throw InputError("forces", 0,
                       "vertices of the boundary: inside, a force on a point is no equation there",
                       "one on vertex " + std::to_string(force.vertex));
    out[force.vertex].force_n = out[force.vertex].force_n + force.force_n;
  }
  for (const HeldFaces& held : problem.held) {
    for (const Triangle& f : held.faces) {
      for (const Index v : f) {
        for (std::size_t axis = 0; axis < 3; ++axis)
          out[v].held.at(axis) = out[v].held.at(axis) || held.axes.at(axis);
        const Vec3 more = problem.held_field_m.empty() ? Vec3{} : problem.held_field_m[v];
        if (held.axes[0]) out[v].held_at_m.x = held.by_m.x + more.x;
        if (held.axes[1]) out[v].held_at_m.y = held.by_m.y + more.y;
        if (held.axes[2]) out[v].held_at_m.z = held.by_m.z + more.z;
      }
    }
  }
  return out;
}

/// What a neighbour's displacement gives of (lambda + mu) grad div u + mu lap u.
Mat3 balance_block(const Material& material, const std::array<double, 6>& s) {
  const double mu = material.mu_pa();
  const Mat3 second{{s[0], s[5], s[4], s[5], s[1], s[3], s[4], s[3], s[2]}};
  return (material.lambda_pa() + mu) * second + (mu * dynamics::trace(second)) * dynamics::kIdentity;
}

/// What it gives of sigma n, n an area.
Mat3 traction_block(const Material& material, const Vec3& g, const Vec3& n) {
  const double mu = material.mu_pa();
  return material.lambda_pa() * outer(n, g) + mu * outer(g, n) + (mu * dot(g, n)) * dynamics::kIdentity;
}

double entry(const Vec3& a, std::size_t axis) {
  return axis == 0 ? a.x : (axis == 1 ? a.y : a.z);
}

/// The rows of one vertex, each scaled by what its stencil makes of a displacement of 1 m.
class RowBuilder {
 public:
  RowBuilder(const TetMesh& mesh, const BoundaryProblem& problem, const std::vector<Index>& moving)
      : problem_(problem), moving_(moving), boundary_(gather_boundary(mesh, problem)) {}

  void add(Index v, const DerivativeStencil& stencil) {
    const BoundaryVertex& at = boundary_[v];
    const Material& material = problem_.material;
    std::vector<Mat3> blocks(stencil.neighbours.size());
    for (std::size_t k = 0; k < blocks.size(); ++k) {
      blocks[k] = (-at.volume_m3) * balance_block(material, stencil.second[k]);
      if (at.is_boundary) blocks[k] += traction_block(material, stencil.first[k], at.area_m2);
      if (at.is_boundary && stencil.neighbours[k] == v) blocks[k] += at.support_n_per_m * dynamics::kIdentity;
    }
    Vec3 right = at.force_n + (at.volume_m3 * material.density_kg_m3) * problem_.gravity_m_s2;
    if (!problem_.body_force_n_m3.empty()) right = right + at.volume_m3 * problem_.body_force_n_m3[v];
    for (std::size_t axis = 0; axis < 3; ++axis) add_row(v, axis, stencil, blocks, right);
  }

  const std::vector<Eigen::Triplet<double>>& entries() const { return entries_; }
  const std::vector<double>& right() const { return right_; }
  const std::vector<BoundaryVertex>& boundary() const { return boundary_; }

 private:
  void add_row(Index v, std::size_t axis, const DerivativeStencil& stencil, const std::vector<Mat3>& blocks,
               const Vec3& right) {
    const int row = static_cast<int>(right_.size());
    if (boundary_[v].held.at(axis)) {
      entries_.emplace_back(row, row, 1.0);
      right_.push_back(entry(boundary_[v].held_at_m, axis));
      return;
    }
    double size = 0.0;
    for (const Mat3& block : blocks) size += length(block.row(axis));
    for (std::size_t k = 0; k < blocks.size(); ++k) {
      const Index place = moving_[stencil.neighbours[k]];
      for (std::size_t j = 0; place != kNoIndex && j < 3; ++j)
        entries_.emplace_back(row, static_cast<int>(3 * std::size_t{place} + j), blocks[k](axis, j) / size);
    }
    right_.push_back(entry(right, axis) / size);
  }

  const BoundaryProblem& problem_;
  const std::vector<Index>& moving_;
  std::vector<BoundaryVertex> boundary_;
  std::vector<Eigen::Triplet<double>> entries_;
  std::vector<double> right_;
};

/// All forces of the problem and the supports' answer, over the sum of their sizes; not a number where faces
/// are held, as what holds them is not computed.
double measure_net_force(const TetMesh& mesh, const BoundaryProblem& problem,
                         const std::vector<BoundaryVertex>& boundary, const std::vector<Vec3>& u) {
  if (!problem.held.empty()) return std::numeric_limits<double>::quiet_NaN();
  Vec3 net;
  double size = 0.0;
  const auto add = [&](const Vec3& force) {
    net = net + force;
    size += length(force);
  };
  for (std::size_t v = 0; v < u.size(); ++v) {
    if (boundary[v].is_boundary) add(boundary[v].force_n - boundary[v].support_n_per_m * u[v]);
  }
  for (const Tet& t : mesh.tets) {
    const double quarter =
        0.25 * signed_volume(mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]], mesh.points[t[3]]);
    for (const Index v : t) {
      add((quarter * problem.material.density_kg_m3) * problem.gravity_m_s2);
      if (!problem.body_force_n_m3.empty()) add(quarter * problem.body_force_n_m3[v]);
    }
  }
  return size > 0.0 ? length(net) / size : 0.0;
}

}  // namespace

std::vector<DerivativeStencil> build_stencils(const TetMesh& mesh, const Spheres& spheres) {
  const std::vector<std::vector<Index>> rings = list_rings(mesh);
  std::vector<std::vector<Index>> reached(mesh.points.size());
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    for (const Index sphere : spheres.of(t)) {
      for (const Index v : mesh.tets[t]) {
        if (length(mesh.points[v] - spheres.centres_m[sphere]) < spheres.radii_m[sphere])
          reached[sphere].push_back(v);
      }
    }
  }
  std::vector<DerivativeStencil> out(mesh.points.size());
  for (Index v = 0; v < out.size(); ++v) {
    std::vector<Index>& numbers = reached[v];
    keep_each_once(numbers);
    double radius = spheres.radii_m[v];
    while (!fit_stencil(mesh, v, radius, numbers, out[v])) {
      if (!add_ring(rings, numbers))
        throw InputError("the mesh", 0, "enough vertices that settle a quadratic polynomial",
                         "too few, or flat");
      for (const Index each : numbers)
        radius = std::max(radius, kGrowth * length(mesh.points[each] - mesh.points[v]));
    }
  }
  return out;
}

CollocationResult solve_collocation(const TetMesh& mesh, const BoundaryProblem& problem,
                                    const std::vector<DerivativeStencil>& stencils,
                                    const std::vector<Index>& moving) {
  RowBuilder rows(mesh, problem, moving);
  for (Index v = 0; v < moving.size(); ++v) {
    if (moving[v] != kNoIndex) rows.add(v, stencils[v]);
  }
  const auto n = static_cast<Eigen::Index>(rows.right().size());
  Eigen::SparseMatrix<double> matrix(n, n);
  matrix.setFromTriplets(rows.entries().begin(), rows.entries().end());
  matrix.makeCompressed();
  const Eigen::Map<const Eigen::VectorXd> right(rows.right().data(), n);
  CollocationResult out;
  out.displacement_m.resize(mesh.points.size());
  out.entries = static_cast<std::size_t>(matrix.nonZeros());
  Eigen::SparseLU<Eigen::SparseMatrix<double>, Eigen::COLAMDOrdering<int>> factor;
  factor.compute(matrix);
  if (factor.info() != Eigen::Success) return out;
  out.factor_entries = static_cast<std::size_t>(factor.nnzL() + factor.nnzU());
  Eigen::VectorXd x = factor.solve(right);
  x += factor.solve(right - matrix * x);
  const Eigen::VectorXd left = (right - matrix * x).cwiseAbs();
  const Eigen::VectorXd sizes = matrix.cwiseAbs() * x.cwiseAbs() + right.cwiseAbs();
  for (Eigen::Index i = 0; i < n; ++i) {
    if (sizes[i] > 0.0) out.residual_relative = std::max(out.residual_relative, left[i] / sizes[i]);
  }
  constexpr double kMostResidual = 1e-8;
  out.converged = x.allFinite() && out.residual_relative < kMostResidual;
  for (std::size_t v = 0; v < moving.size(); ++v) {
    const auto at = 3 * static_cast<Eigen::Index>(moving[v]);
    if (moving[v] != kNoIndex) out.displacement_m[v] = {x[at], x[at + 1], x[at + 2]};
  }
  out.net_force_share = measure_net_force(mesh, problem, rows.boundary(), out.displacement_m);
  return out;
}

}  // namespace palpate::reference
