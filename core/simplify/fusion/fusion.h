// Tetrahedral fusion: a tet becomes a vertex at its barycenter (Chopra and Meyer, IEEE Visualization 2002).
#pragma once

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/mesh/topology.h"
#include "core/simplify/quality/quality.h"

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

/// Takes a mesh over; its arrays are released as soon as they are copied or moved. Any number of threads
/// gives the same.
FusionMesh build_fusion_mesh(TetMesh&& mesh, StorageOrder order, int threads = 1);

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

/// Bit k is set if corner k of the tet is vertex v.
inline unsigned corners_that_are(const Tet& tet, Index v) {
#ifdef __SSE2__
  const __m128i corners = _mm_loadu_si128(reinterpret_cast<const __m128i*>(tet.data()));
  const __m128i equal = _mm_cmpeq_epi32(corners, _mm_set1_epi32(static_cast<int>(v)));
  return static_cast<unsigned>(_mm_movemask_ps(_mm_castsi128_ps(equal)));
#else
  return static_cast<unsigned>(tet[0] == v) | static_cast<unsigned>(tet[1] == v) << 1U |
         static_cast<unsigned>(tet[2] == v) << 2U | static_cast<unsigned>(tet[3] == v) << 3U;
#endif
}

/// The corners of a tet, the farthest from its barycenter first: what moves farthest is likeliest to flip
/// something.
std::array<std::size_t, 4> farthest_corners_first(const std::array<Vec3, 4>& corners, const Vec3& barycenter);

/// Walks the stars of the target's four vertices and fills `plan` (whose memory is reused), calling
/// on_moved(const MovedTet&) for each moved tet; it ends early, with an unfinished plan, when that returns
/// false. Returns: whether the walk went to its end.
template <typename Mesh, typename OnMoved>
bool walk_fusion(Mesh& mesh, Index target, FusionPlan& plan, OnMoved&& on_moved) {
  const Tet& center = mesh.tets[target];
  plan.target = target;
  const std::array<Vec3, 4> corners{mesh.points[center[0]], mesh.points[center[1]], mesh.points[center[2]],
                                    mesh.points[center[3]]};
  plan.barycenter = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
  plan.moved.clear();
  plan.dead.clear();
  plan.figures.clear();
  for (const Index v : center) {
    for (const Index t : mesh.star(v)) __builtin_prefetch(&mesh.tets[t]);
  }
  unsigned visited = 0;  // bit j: the star of corner j is done with
  for (const std::size_t i : farthest_corners_first(corners, plan.barycenter)) {
    const std::uint64_t end = mesh.star_begin[center[i]] + mesh.star_size[center[i]];
    for (std::uint64_t n = mesh.star_begin[center[i]]; n < end; ++n) {
      const Index t = mesh.star_tets[n];
      const Tet& tet = mesh.tets[t];
      const std::array<unsigned, 4> mask{corners_that_are(tet, center[0]), corners_that_are(tet, center[1]),
                                         corners_that_are(tet, center[2]), corners_that_are(tet, center[3])};
      const unsigned shared = mask[0] | mask[1] | mask[2] | mask[3];
      if ((shared & (shared - 1U)) == 0U) {
        const MovedTet m{t, static_cast<std::uint8_t>(std::countr_zero(shared))};
        plan.moved.push_back(m);
        if (!on_moved(m)) {
          if constexpr (!std::is_const_v<Mesh>)
            std::swap(mesh.star_tets[mesh.star_begin[center[i]]], mesh.star_tets[n]);
          return false;
        }
      } else {
        unsigned in_earlier = 0;
        for (std::size_t j = 0; j < 4; ++j) in_earlier |= (visited >> j & 1U) != 0U ? mask[j] : 0U;
        if (in_earlier == 0U) plan.dead.push_back(t);  // listed at the first of the stars that it is in
      }
    }
    visited |= 1U << i;
  }
  return true;
}

/// The corners of tet t.
inline std::array<Vec3, 4> corners_of(const FusionMesh& mesh, Index t) {
  const Tet& tet = mesh.tets[t];
  return {mesh.points[tet[0]], mesh.points[tet[1]], mesh.points[tet[2]], mesh.points[tet[3]]};
}

/// One flag a vertex by the input's numbers; does tet t have a flagged one?
inline bool has_flagged_vertex(const FusionMesh& mesh, Index t, const std::vector<std::uint8_t>& flags) {
  return std::any_of(mesh.tets[t].begin(), mesh.tets[t].end(),
                     [&](Index v) { return flags[mesh.origin_of_vertex(v)] != 0; });
}

/// Collects all tets around `target`.
void plan_fusion(const FusionMesh& mesh, Index target, FusionPlan& plan);

/// Points of moved tet `m` after the fusion.
inline std::array<Vec3, 4> moved_points(const FusionMesh& mesh, const FusionPlan& plan, const MovedTet& m) {
  const Tet& tet = mesh.tets[m.tet];
  std::array<Vec3, 4> p{mesh.points[tet[0]], mesh.points[tet[1]], mesh.points[tet[2]], mesh.points[tet[3]]};
  p[m.corner] = plan.barycenter;
  return p;
}

/// Carries a plan out: the vertex with the smallest number in the input survives at the barycenter.
/// Requires: the plan was made for the mesh as it is.
void apply_fusion(FusionMesh& mesh, const FusionPlan& plan);

/// The mean volume of the tets of `mesh`, total volume / number of tets: the thesis's ideal volume.
double mean_tet_volume(const TetMesh& mesh);

}  // namespace palpate::simplify
