// Tetrahedral fusion: a tet becomes a vertex at its barycenter (Chopra and Meyer, IEEE Visualization 2002).
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh/topology.h"
#include "core/simplify/quality.h"

namespace palpate::simplify {

/// In which order the working mesh stores vertices and tets. Results do not depend on it.
enum class StorageOrder {
  kInput,   ///< as in the input
  kSpatial  ///< along a space-filling curve: neighbours in space are neighbours in memory
};

/// A tet mesh that can be fused: fused tets are marked dead, and vertex stars are kept up to date.
///
/// Memory: 40 bytes a tet and about 45 a vertex. Origins map back to the input's numbers, by which ties are
/// broken.
struct FusionMesh {
  std::vector<Vec3> points;
  std::vector<Tet> tets;                  ///< a dead tet has kNoIndex as its first vertex
  std::vector<Index> tet_origin;          ///< empty for kInput: the identity
  std::vector<Index> vertex_origin;       ///< empty for kInput
  std::vector<std::uint64_t> star_begin;  ///< row of each vertex in star_tets
  std::vector<Index> star_size;
  std::vector<Index> star_capacity;
  std::vector<Index> star_tets;
  std::size_t alive = 0;

  bool is_alive(Index t) const { return tets[t][0] != kNoIndex; }
  Index origin_of_tet(Index t) const { return tet_origin.empty() ? t : tet_origin[t]; }
  Index origin_of_vertex(Index v) const { return vertex_origin.empty() ? v : vertex_origin[v]; }
  std::span<const Index> star(Index v) const { return {star_tets.data() + star_begin[v], star_size[v]}; }
};

/// Takes a mesh over; its arrays are released as soon as they are copied or moved.
FusionMesh build_fusion_mesh(TetMesh&& mesh, StorageOrder order);

/// The alive tets in the input's order and the vertices they use; empties `mesh`.
TetMesh extract_mesh(FusionMesh&& mesh);

/// A tet that keeps its life in a fusion: `corner` of it moves to the barycenter.
struct MovedTet {
  Index tet;
  std::uint8_t corner;
};

/// What the fusion of one tet would do.
struct FusionPlan {
  Index target = kNoIndex;
  Vec3 barycenter;
  std::vector<MovedTet> moved;      ///< share exactly one vertex with the target
  std::vector<Index> dead;          ///< share two or more; the target itself is among them
  std::vector<TetFigures> figures;  ///< of the moved tets after the fusion, once checked
};

/// Collects the tets around `target` by walking the stars of its four vertices. Reuses the memory of `plan`.
void plan_fusion(const FusionMesh& mesh, Index target, FusionPlan& plan);

/// Points of moved tet `m` after the fusion.
std::array<Vec3, 4> moved_points(const FusionMesh& mesh, const FusionPlan& plan, const MovedTet& m);

/// Carries a plan out: the vertex with the smallest number in the input survives at the barycenter.
/// Requires: the plan was made for the mesh as it is.
void apply_fusion(FusionMesh& mesh, const FusionPlan& plan);

/// The mean volume of the tets of `mesh`, total volume / number of tets: the thesis's ideal volume.
double mean_tet_volume(const TetMesh& mesh);

}  // namespace palpate::simplify
