#include "core/dynamics/finite_elements/elements.h"

#include <algorithm>
#include <span>

#include "core/base/error.h"
#include "core/mesh/geometry.h"

namespace palpate::dynamics {
namespace {

constexpr std::size_t kMostNodes = 10;

/// Gradients of the four barycentric coordinates, in 1/m, and the volume.
struct TetShape {
  std::array<Vec3, 4> gradient;
  double volume_m3 = 0.0;
};

TetShape shape_of(const TetMesh& mesh, const Tet& tet) {
  const Vec3 b = mesh.points[tet[1]] - mesh.points[tet[0]];
  const Vec3 c = mesh.points[tet[2]] - mesh.points[tet[0]];
  const Vec3 d = mesh.points[tet[3]] - mesh.points[tet[0]];
  const double det = dot(cross(b, c), d);
  TetShape shape;
  shape.volume_m3 = det / 6.0;
  shape.gradient[1] = (1.0 / det) * cross(c, d);
  shape.gradient[2] = (1.0 / det) * cross(d, b);
  shape.gradient[3] = (1.0 / det) * cross(b, c);
  shape.gradient[0] = -1.0 * (shape.gradient[1] + shape.gradient[2] + shape.gradient[3]);
  return shape;
}

using Gradients = std::array<Vec3, kMostNodes>;

/// Gradients of the quadratic shape functions at the barycentric coordinates `at`.
Gradients quadratic_gradients(const TetShape& shape, const std::array<double, 4>& at) {
  Gradients g{};
  for (std::size_t i = 0; i < 4; ++i) g[i] = (4.0 * at[i] - 1.0) * shape.gradient[i];
  for (std::size_t e = 0; e < kTetEdges.size(); ++e) {
    const auto i = static_cast<std::size_t>(kTetEdges[e][0]);
    const auto j = static_cast<std::size_t>(kTetEdges[e][1]);
    g[4 + e] = 4.0 * (at[i] * shape.gradient[j] + at[j] * shape.gradient[i]);
  }
  return g;
}

using LocalStiffness = std::array<std::array<Mat3, kMostNodes>, kMostNodes>;

void add_point(const Gradients& g, std::size_t nodes, double weight, const Material& material,
               LocalStiffness& local) {
  const double lambda = weight * material.lambda_pa();
  const double mu = weight * material.mu_pa();
  for (std::size_t a = 0; a < nodes; ++a) {
    for (std::size_t b = 0; b < nodes; ++b) {
      Mat3& block = local[a][b];
      block += lambda * outer(g[a], g[b]);
      block += mu * outer(g[b], g[a]);
      block += (mu * dot(g[a], g[b])) * kIdentity;
    }
  }
}

/// Stiffness of one tet. The gradients' products are of degree 2 at most: four points are exact.
LocalStiffness local_stiffness(const TetShape& shape, int order, const Material& material) {
  LocalStiffness local{};
  if (order == 1) {
    Gradients g{};
    std::copy(shape.gradient.begin(), shape.gradient.end(), g.begin());
    add_point(g, 4, shape.volume_m3, material, local);
    return local;
  }
  const double far = (5.0 + 3.0 * std::sqrt(5.0)) / 20.0;
  const double near = (5.0 - std::sqrt(5.0)) / 20.0;
  for (std::size_t p = 0; p < 4; ++p) {
    std::array<double, 4> at{near, near, near, near};
    at[p] = far;
    add_point(quadratic_gradients(shape, at), kMostNodes, 0.25 * shape.volume_m3, material, local);
  }
  return local;
}

/// Integral of phi_a phi_b over a tet of volume 1.
double unit_mass(int order, std::size_t a, std::size_t b) {
  if (order == 1) return a == b ? 0.1 : 0.05;
  if (a > b) std::swap(a, b);
  if (b < 4) return (a == b ? 6.0 : 1.0) / 420.0;
  const auto& second = kTetEdges[b - 4];
  const auto has = [&](std::size_t v) {
    return static_cast<std::size_t>(second[0]) == v || static_cast<std::size_t>(second[1]) == v;
  };
  if (a < 4) return (has(a) ? -4.0 : -6.0) / 420.0;
  if (a == b) return 32.0 / 420.0;
  const auto& first = kTetEdges[a - 4];
  const bool touch = has(static_cast<std::size_t>(first[0])) || has(static_cast<std::size_t>(first[1]));
  return (touch ? 16.0 : 8.0) / 420.0;
}

std::size_t place_of(const BlockMatrix& matrix, Index row, Index column) {
  const auto first = matrix.columns.begin() + static_cast<std::ptrdiff_t>(matrix.offsets[row]);
  const auto last = matrix.columns.begin() + static_cast<std::ptrdiff_t>(matrix.offsets[row + 1]);
  const auto place = std::lower_bound(first, last, column);
  require(place != last && *place == column, "a block outside the pattern");
  return static_cast<std::size_t>(place - matrix.columns.begin());
}

}  // namespace

ElementSpace build_element_space(const TetMesh& mesh, int order) {
  require(order == 1 || order == 2, "elements of order 1 or 2");
  ElementSpace space;
  space.order = order;
  space.points = mesh.points;
  const auto vertices = static_cast<Index>(mesh.points.size());
  if (order == 2) {
    space.edges = build_edge_numbers(mesh);
    for (const auto& [a, b] : space.edges.edges)
      space.points.push_back(0.5 * (mesh.points[a] + mesh.points[b]));
  }
  space.tet_nodes.reserve(mesh.tets.size() * space.nodes_per_tet());
  for (const Tet& tet : mesh.tets) {
    space.tet_nodes.insert(space.tet_nodes.end(), tet.begin(), tet.end());
    if (order == 1) continue;
    for (const auto& [a, b] : kTetEdges)
      space.tet_nodes.push_back(
          vertices + space.edges.of(tet[static_cast<std::size_t>(a)], tet[static_cast<std::size_t>(b)]));
  }
  return space;
}

std::array<Index, 6> face_nodes(const ElementSpace& space, const Triangle& face) {
  std::array<Index, 6> nodes{face[0], face[1], face[2], kNoIndex, kNoIndex, kNoIndex};
  if (space.order == 1) return nodes;
  const auto vertices = static_cast<Index>(space.nodes() - space.edges.edges.size());
  for (std::size_t i = 0; i < 3; ++i) {
    const Index edge = space.edges.of(face[i], face[(i + 1) % 3]);
    require(edge != kNoIndex, "a face of the mesh");
    nodes[3 + i] = vertices + edge;
  }
  return nodes;
}

FaceMass unit_face_mass(int order) {
  FaceMass mass{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      if (order == 1) {
        mass[i][j] = (i == j ? 2.0 : 1.0) / 12.0;
        continue;
      }
      mass[i][j] = (i == j ? 6.0 : -1.0) / 180.0;
      mass[3 + i][3 + j] = (i == j ? 32.0 : 16.0) / 180.0;
      // Node 3 + j is the midpoint of corners j and j + 1; opposite to it is corner j + 2.
      const double across = i == (j + 2) % 3 ? -4.0 / 180.0 : 0.0;
      mass[i][3 + j] = across;
      mass[3 + j][i] = across;
    }
  }
  return mass;
}

ElementMatrices build_element_matrices(const TetMesh& mesh, const ElementSpace& space,
                                       const Material& material) {
  const std::size_t per_tet = space.nodes_per_tet();
  std::vector<Index> offsets(mesh.tets.size() + 1);
  for (std::size_t t = 0; t < offsets.size(); ++t) offsets[t] = static_cast<Index>(t * per_tet);
  const VertexGroups groups{offsets, space.tet_nodes};
  ElementMatrices out;
  out.stiffness = build_block_matrix(space.nodes(), {&groups, 1});
  out.mass_kg.assign(out.stiffness.blocks.size(), 0.0);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const TetShape shape = shape_of(mesh, mesh.tets[t]);
    const LocalStiffness local = local_stiffness(shape, space.order, material);
    const Index* nodes = space.tet_nodes.data() + t * per_tet;
    const double mass_kg = material.density_kg_m3 * shape.volume_m3;
    for (std::size_t a = 0; a < per_tet; ++a) {
      for (std::size_t b = 0; b < per_tet; ++b) {
        const std::size_t place = place_of(out.stiffness, nodes[a], nodes[b]);
        out.stiffness.blocks[place] += local[a][b];
        out.mass_kg[place] += mass_kg * unit_mass(space.order, a, b);
      }
    }
  }
  return out;
}

void multiply_mass(const ElementMatrices& body, std::span<const Vec3> x, std::span<Vec3> y) {
  const BlockMatrix& pattern = body.stiffness;
  require(x.size() == pattern.rows() && y.size() == x.size(), "one entry a node");
  for (std::size_t v = 0; v < pattern.rows(); ++v) {
    Vec3 sum;
    for (std::size_t k = pattern.offsets[v]; k < pattern.offsets[v + 1]; ++k)
      sum = sum + body.mass_kg[k] * x[pattern.columns[k]];
    y[v] = sum;
  }
}

}  // namespace palpate::dynamics
