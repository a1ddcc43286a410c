#include "core/dynamics/reduced/skin_space.h"

#include <algorithm>
#include <map>

#include "core/base/error.h"
#include "core/mesh/topology.h"

namespace palpate::dynamics {
namespace {

/// Barycentric coordinates in a face of the mesh.
using Place = std::array<double, 3>;

/// Where a vertex of the (refined) mesh lies in a face of the mesh: a corner, or the middle of a side.
Place place_of_vertex(const Triangle& face, Index vertex, std::size_t vertices, const EdgeNumbers& edges) {
  Place at{};
  const auto add = [&](Index v, double share) {
    for (std::size_t i = 0; i < 3; ++i) {
      if (face[i] == v) at[i] += share;
    }
  };
  if (vertex < vertices) {
    add(vertex, 1.0);
  } else {
    const Edge& ends = edges.edges[vertex - vertices];
    add(ends[0], 0.5);
    add(ends[1], 0.5);
  }
  return at;
}

/// The shape functions of a face in the order of face_nodes.
std::array<double, 6> face_shapes(int order, const Place& at) {
  if (order == 1) return {at[0], at[1], at[2], 0.0, 0.0, 0.0};
  std::array<double, 6> shape{};
  for (std::size_t i = 0; i < 3; ++i) {
    shape[i] = at[i] * (2.0 * at[i] - 1.0);
    shape[3 + i] = 4.0 * at[i] * at[(i + 1) % 3];
  }
  return shape;
}

double area_of(const TetMesh& mesh, const Triangle& face) {
  return 0.5 * length(cross(mesh.points[face[1]] - mesh.points[face[0]],
                            mesh.points[face[2]] - mesh.points[face[0]]));
}

std::vector<std::vector<NodeWeight>> to_columns(const std::vector<std::map<Index, double>>& maps) {
  std::vector<std::vector<NodeWeight>> columns;
  for (const std::map<Index, double>& map : maps) {
    std::vector<NodeWeight>& column = columns.emplace_back();
    for (const auto& [node, weight] : map) column.push_back({node, weight});
  }
  return columns;
}

SkinCoupling nodal_coupling(const SkinPlaces& skin) {
  SkinCoupling out;
  out.coupling.resize(skin.nodes.size());
  for (std::size_t node = 0; node < skin.place.size(); ++node) {
    if (skin.place[node] != kNoIndex) out.coupling[skin.place[node]] = {{static_cast<Index>(node), 1.0}};
  }
  return out;
}

}  // namespace

SkinPlaces number_skin(const TetMesh& mesh, const ElementSpace& space) {
  std::vector<std::uint8_t> on_skin(space.nodes(), 0);
  for (const Triangle& face : build_boundary(mesh)) {
    const std::array<Index, 6> nodes = face_nodes(space, face);
    for (std::size_t i = 0; i < space.nodes_per_face(); ++i) on_skin[nodes[i]] = 1;
  }
  SkinPlaces skin;
  skin.place.assign(space.nodes(), kNoIndex);
  const std::size_t vertices = mesh.points.size();
  for (std::size_t node = 0; node < space.nodes(); ++node) {
    if (on_skin[node] == 0) continue;
    skin.place[node] = static_cast<Index>(skin.nodes.size());
    if (node < vertices) {
      skin.nodes.vertices.push_back(static_cast<Index>(node));
    } else {
      skin.nodes.edges.push_back(space.edges.edges[node - vertices]);
    }
  }
  return skin;
}

SkinCoupling couple_skin(const TetMesh& mesh, const ElementSpace& coarse, const TetMesh& fine_mesh,
                         const ElementSpace& fine, const SkinPlaces& skin) {
  require(coarse.order <= fine.order, "tractions of no higher order than the elements");
  const std::size_t n = skin.nodes.size();
  const std::size_t vertices = mesh.points.size();
  if (coarse.order == fine.order && fine_mesh.points.size() == vertices) return nodal_coupling(skin);
  const std::vector<Triangle> faces = build_boundary(mesh);
  const bool is_refined = fine_mesh.points.size() > vertices;
  const EdgeNumbers edges = build_edge_numbers(mesh);
  const std::vector<Triangle> fine_faces = is_refined ? refine_triangles(faces, edges, vertices) : faces;
  const std::size_t per_face = fine_faces.size() / std::max<std::size_t>(faces.size(), 1);
  const FaceMass unit = unit_face_mass(fine.order);
  const std::size_t fine_count = fine.nodes_per_face();
  const std::size_t coarse_count = coarse.nodes_per_face();
  std::vector<std::map<Index, double>> columns(n);
  std::vector<std::map<Index, double>> mass(n);
  for (std::size_t f = 0; f < fine_faces.size(); ++f) {
    const Triangle& face = faces[f / per_face];
    const std::array<Index, 6> nodes = face_nodes(fine, fine_faces[f]);
    const std::array<Index, 6> coarse_nodes = face_nodes(coarse, face);
    std::array<Place, 6> at{};
    for (std::size_t i = 0; i < 3; ++i) at[i] = place_of_vertex(face, fine_faces[f][i], vertices, edges);
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < 3; ++k) at[3 + i][k] = 0.5 * (at[i][k] + at[(i + 1) % 3][k]);
    }
    const double area = area_of(fine_mesh, fine_faces[f]);
    std::array<std::array<double, 6>, 6> shapes{};  // [fine node][coarse node]
    for (std::size_t i = 0; i < fine_count; ++i) shapes[i] = face_shapes(coarse.order, at[i]);
    for (std::size_t c = 0; c < coarse_count; ++c) {
      std::array<double, 6> coupled{};
      for (std::size_t i = 0; i < fine_count; ++i) {
        for (std::size_t j = 0; j < fine_count; ++j) coupled[i] += area * unit[i][j] * shapes[j][c];
      }
      const std::size_t column = skin.place[coarse_nodes[c]];
      for (std::size_t i = 0; i < fine_count; ++i) {
        columns[column][nodes[i]] += coupled[i];
        for (std::size_t d = 0; d < coarse_count; ++d)
          mass[column][skin.place[coarse_nodes[d]]] += coupled[i] * shapes[i][d];
      }
    }
  }
  return {to_columns(columns), to_columns(mass)};
}

}  // namespace palpate::dynamics
