#include "core/mesh/subdivision/refinement.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/mesh/topology.h"

namespace palpate {
namespace {

/// Local numbers of the ten nodes of a quadratic tet: 0 to 3 the vertices, 4 + i the midpoint of
/// kTetEdges[i].
using QuadraticTet = std::array<Index, 10>;

QuadraticTet nodes_of(const Tet& tet, const EdgeNumbers& edges, std::size_t vertices) {
  QuadraticTet nodes{};
  std::copy(tet.begin(), tet.end(), nodes.begin());
  for (std::size_t i = 0; i < kTetEdges.size(); ++i) {
    nodes[4 + i] = static_cast<Index>(vertices) + edges.of(tet[kTetEdges[i][0]], tet[kTetEdges[i][1]]);
  }
  return nodes;
}

/// A diagonal of the inner octahedron and the ring of the other four midpoints around it, as local nodes:
/// with (diagonal, ring[i], ring[i + 1]) positively oriented.
struct Diagonal {
  std::array<int, 2> ends;
  std::array<int, 4> ring;
};
constexpr std::array<Diagonal, 3> kDiagonals{
    {{{4, 9}, {5, 6, 8, 7}}, {{5, 8}, {6, 4, 7, 9}}, {{6, 7}, {4, 5, 9, 8}}}};

/// The corner child at vertex i: the vertex and the midpoints toward the others, in the parent's order.
constexpr std::array<std::array<int, 4>, 4> kCorners{
    {{0, 4, 5, 6}, {4, 1, 7, 8}, {5, 7, 2, 9}, {6, 8, 9, 3}}};

/// Length squared, then the vertices: what decides between diagonals.
using DiagonalRank = std::pair<double, Edge>;

DiagonalRank rank_of(const Diagonal& diagonal, const QuadraticTet& nodes, std::span<const Vec3> points) {
  const Index a = nodes[static_cast<std::size_t>(diagonal.ends[0])];
  const Index b = nodes[static_cast<std::size_t>(diagonal.ends[1])];
  return {length_sq(points[b] - points[a]), {std::min(a, b), std::max(a, b)}};
}

const Diagonal& shortest_diagonal(const QuadraticTet& nodes, std::span<const Vec3> points) {
  return *std::min_element(kDiagonals.begin(), kDiagonals.end(), [&](const Diagonal& a, const Diagonal& b) {
    return rank_of(a, nodes, points) < rank_of(b, nodes, points);
  });
}

Tet pick(const QuadraticTet& nodes, const std::array<int, 4>& local) {
  Tet tet{};
  for (std::size_t i = 0; i < 4; ++i) tet[i] = nodes[static_cast<std::size_t>(local[i])];
  return tet;
}

/// Values of the ten quadratic shape functions halfway between two local nodes.
std::array<double, 10> shape_halfway(std::size_t first, std::size_t second) {
  std::array<double, 4> barycentric{};
  for (const std::size_t node : {first, second}) {
    if (node < 4) {
      barycentric[node] += 0.5;
    } else {
      for (const int end : kTetEdges[node - 4]) barycentric[static_cast<std::size_t>(end)] += 0.25;
    }
  }
  std::array<double, 10> shape{};
  for (std::size_t i = 0; i < 4; ++i) shape[i] = barycentric[i] * (2.0 * barycentric[i] - 1.0);
  for (std::size_t i = 0; i < kTetEdges.size(); ++i) {
    const auto& [a, b] = kTetEdges[i];
    shape[4 + i] = 4.0 * barycentric[static_cast<std::size_t>(a)] * barycentric[static_cast<std::size_t>(b)];
  }
  return shape;
}

FacePatch refine_patch(const FacePatch& patch, const EdgeNumbers& edges, std::size_t vertices) {
  require(patch.faces.size() == patch.weight.size(), "refine_problem: one weight a face");
  FacePatch fine;
  fine.faces = refine_triangles(patch.faces, edges, vertices);
  fine.weight.reserve(fine.faces.size());
  for (const double weight : patch.weight) fine.weight.insert(fine.weight.end(), 4, weight);
  return fine;
}

}  // namespace

Index EdgeNumbers::of(Index a, Index b) const {
  if (a > b) std::swap(a, b);
  if (a + std::size_t{1} >= offsets.size()) return kNoIndex;
  const auto first = edges.begin() + static_cast<std::ptrdiff_t>(offsets[a]);
  const auto last = edges.begin() + static_cast<std::ptrdiff_t>(offsets[a + std::size_t{1}]);
  const auto found = std::lower_bound(first, last, Edge{a, b});
  return found != last && *found == Edge{a, b} ? static_cast<Index>(found - edges.begin()) : kNoIndex;
}

EdgeNumbers build_edge_numbers(const TetMesh& mesh) {
  EdgeNumbers numbers{build_edges(mesh), {}};
  require(numbers.edges.size() < kNoIndex, "build_edge_numbers: too many edges for 32 bits");
  numbers.offsets.assign(mesh.points.size() + 1, 0);
  for (const Edge& edge : numbers.edges) ++numbers.offsets[edge[0] + std::size_t{1}];
  for (std::size_t v = 1; v < numbers.offsets.size(); ++v) numbers.offsets[v] += numbers.offsets[v - 1];
  return numbers;
}

TetMesh refine_uniformly(const TetMesh& mesh) {
  if (mesh.tets.size() >= (1U << 27U)) {
    throw InputError("uniform refinement", 0, "fewer than 2^27 tetrahedra", std::to_string(mesh.tets.size()));
  }
  const EdgeNumbers edges = build_edge_numbers(mesh);
  const std::size_t vertices = mesh.points.size();
  if (vertices + edges.edges.size() >= kNoIndex) {
    throw InputError("uniform refinement", 0, "fewer than 2^32 - 1 vertices and edges",
                     std::to_string(vertices + edges.edges.size()));
  }
  TetMesh fine;
  fine.points.reserve(vertices + edges.edges.size());
  fine.points = mesh.points;
  for (const auto& [a, b] : edges.edges) fine.points.push_back(0.5 * (mesh.points[a] + mesh.points[b]));
  fine.tets.reserve(8 * mesh.tets.size());
  for (const Tet& tet : mesh.tets) {
    const QuadraticTet nodes = nodes_of(tet, edges, vertices);
    for (const auto& corner : kCorners) fine.tets.push_back(pick(nodes, corner));
    const Diagonal& diagonal = shortest_diagonal(nodes, fine.points);
    for (std::size_t i = 0; i < 4; ++i) {
      fine.tets.push_back(
          pick(nodes, {diagonal.ends[0], diagonal.ends[1], diagonal.ring[i], diagonal.ring[(i + 1) % 4]}));
    }
  }
  return fine;
}

std::vector<Triangle> refine_triangles(std::span<const Triangle> triangles, const EdgeNumbers& edges,
                                       std::size_t vertices) {
  std::vector<Triangle> children;
  children.reserve(4 * triangles.size());
  for (const Triangle& t : triangles) {
    Triangle middle{};  // middle[i] is the midpoint of the side from t[i] to t[i + 1]
    for (std::size_t i = 0; i < 3; ++i) {
      const Index edge = edges.of(t[i], t[(i + 1) % 3]);
      require(edge != kNoIndex, "refine_triangles: a side is no edge of the mesh");
      middle[i] = static_cast<Index>(vertices) + edge;
    }
    for (std::size_t i = 0; i < 3; ++i) children.push_back({t[i], middle[i], middle[(i + 2) % 3]});
    children.push_back(middle);
  }
  return children;
}

std::vector<Vec3> refine_quadratic_field(const TetMesh& mesh, const TetMesh& refined,
                                         std::span<const Vec3> field) {
  const EdgeNumbers edges = build_edge_numbers(mesh);
  const EdgeNumbers fine_edges = build_edge_numbers(refined);
  require(field.size() == mesh.points.size() + edges.edges.size() && field.size() == refined.points.size(),
          "refine_quadratic_field: one value a vertex and an edge");
  std::vector<Vec3> fine(field.begin(), field.end());
  fine.resize(refined.points.size() + fine_edges.edges.size());
  for (const Tet& tet : mesh.tets) {
    const QuadraticTet nodes = nodes_of(tet, edges, mesh.points.size());
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      for (std::size_t j = i + 1; j < nodes.size(); ++j) {
        const Index edge = fine_edges.of(nodes[i], nodes[j]);
        if (edge == kNoIndex) continue;  // a whole edge, or a diagonal that was not taken
        const std::array<double, 10> shape = shape_halfway(i, j);
        Vec3 value;
        for (std::size_t k = 0; k < nodes.size(); ++k) value = value + shape[k] * field[nodes[k]];
        fine[refined.points.size() + edge] = value;
      }
    }
  }
  return fine;
}

BoundaryProblem refine_problem(const BoundaryProblem& problem, const TetMesh& mesh, const TetMesh& refined) {
  const EdgeNumbers edges = build_edge_numbers(mesh);
  const std::size_t vertices = mesh.points.size();
  BoundaryProblem fine = problem;
  for (HeldFaces& held : fine.held) held.faces = refine_triangles(held.faces, edges, vertices);
  for (ElasticSupport& support : fine.supports) support.patch = refine_patch(support.patch, edges, vertices);
  for (Traction& traction : fine.tractions) traction.patch = refine_patch(traction.patch, edges, vertices);
  for (std::vector<Vec3>* field : {&fine.body_force_n_m3, &fine.held_field_m}) {
    if (!field->empty()) *field = refine_quadratic_field(mesh, refined, *field);
  }
  return fine;
}

}  // namespace palpate
