// The springs of a mesh, and what belongs to its vertices: influence volumes, masses, incident springs.
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "core/mesh/spring_network.h"
#include "core/mesh/tet_mesh.h"

namespace palpate::springs {

/// One spring an edge of the mesh at its rest length, all of stiffness zero; with `face_opposite` also one
/// between the two apexes of each interior face, unless they share an edge. Sorted, each pair once.
///
/// Requires: points in metres, indices in range.
/// Throws: InputError if a face has more than two tets (face_opposite alone looks).
SpringNetwork build_spring_network(const TetMesh& mesh, bool face_opposite = false);

/// The vertex of the tet that is not on the face. Throws: ContractError if there is none.
Index apex_of(const Tet& tet, const Triangle& face);

/// Influence volume of each vertex, V_m = 1/4 of the volumes of its tets; they add up to the mesh's volume.
/// Source: thesis 4.2.4, eq. 4.3.
std::vector<double> build_influence_volumes(const TetMesh& mesh);

/// Lumped mass of each vertex, density x V_m, in kg. Throws: InputError unless 0 < density < infinity.
std::vector<double> build_lumped_masses(const TetMesh& mesh, double density_kg_m3);

/// Geometric centre as the thesis has it: the mean of the tets' barycentres, each tet counted once, whatever
/// its volume. Source: thesis 4.2.6. Requires at least one tet.
Vec3 geometric_center(const TetMesh& mesh);

/// Centre of mass of the uniform solid: the same mean, each tet counted by its volume. Requires a volume.
Vec3 center_of_mass(const TetMesh& mesh);

/// Number of the spring of each tet edge. Shape: one entry a tet, springs in the order of kTetEdges.
/// Throws: ContractError if an edge of the mesh has no spring.
std::vector<std::array<Index, 6>> build_tet_springs(const TetMesh& mesh, const SpringNetwork& network);

/// Springs at each vertex, in compressed rows.
/// Shape: springs[offsets[v] .. offsets[v + 1]) are the springs of vertex v, in increasing order.
struct VertexSprings {
  std::vector<Index> offsets;
  std::vector<Index> springs;

  std::span<const Index> of(Index vertex) const {
    return {springs.data() + offsets[vertex], springs.data() + offsets[vertex + 1]};
  }
};
/// The springs at each of `vertices` vertices. Linear time and memory.
VertexSprings build_vertex_springs(const SpringNetwork& network, std::size_t vertices);

/// Unit direction of each spring, from its first vertex to its second.
std::vector<Vec3> build_spring_directions(const TetMesh& mesh, const SpringNetwork& network);

/// Per vertex, the sum of k U^2 over its springs, divided by 12 E V_m: 1 where the network is as stiff as the
/// solid (thesis 3.4, with its lost factor 1/2 restored). Mean over all: sum of k U^2 over springs / (6 E V).
std::vector<double> build_stiffness_ratios(const SpringNetwork& network,
                                           std::span<const double> influence_volumes,
                                           double young_modulus_pa);

}  // namespace palpate::springs
