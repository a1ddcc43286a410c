// The arithmetic of StarQuality, in two forms with the same bits: four tets at a time on every processor,
// eight with AVX2.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/base/types.h"

namespace palpate::simplify {

/// Triangles of a block. A block has twelve rows of so many floats each: the coordinates ax ay az bx by bz cx
/// cy cz of the triangles' corners and the lengths of the edges bc, ca, ab.
inline constexpr std::size_t kBlockTriangles = 8;
/// Numbers of a block.
inline constexpr std::size_t kBlockFloats = 12 * kBlockTriangles;

/// Score of a tet whose figures do not fit single precision: nothing is worse.
inline constexpr float kWorstScore = -1e30F;

/// A base triangle of a star: where its corners lie.
using StarTriangle = std::array<const Vec3*, 3>;

/// The apex of a star and what its scores depend on.
struct StarApex {
  float x;
  float y;
  float z;
  float inverse_six_ideal;  ///< 1 / (6 x the volume from which on a tet is no longer small)
  float dihedral_weight;
  float mean_ratio_weight;  ///< 0: scores are by solid angles, see ScoreForm
};

/// Figures of a set of tets.
struct StarFigures {
  double worst =
      0.0;           ///< least score; not above 0 if a tet is not positive, as far as single precision tells
  double sum = 0.0;  ///< sum of the gains
};

/// Longer rings are left alone: they have 20 times as many triangles and are hardly ever better.
inline constexpr std::size_t kLargestRing = 7;

/// Where the points of a ring lie, the first ones of these.
using RingPoints = std::array<const Vec3*, kBlockTriangles>;

/// All triangles i < k < j of a ring, ordered by i, then k, then j, in lanes. Up to four stand in both halves
/// of the one block, so that its halves can be seen from two sides at once.
struct RingTriangles {
  static constexpr std::size_t kMostLanes = 40;

  std::size_t size = 0;
  std::array<std::array<std::int32_t, kMostLanes>, 3> corner{};  ///< i, k and j of each lane
};

/// The triangles of a ring of `count` points, 3 to kLargestRing.
const RingTriangles& ring_triangles(std::size_t count);

/// One form of the arithmetic. `blocks` has those of `size` triangles. `base` and `scores` have room for
/// whole blocks; what lies in `base` behind the last triangle repeats it.
struct StarKernel {
  /// Fills the blocks: (p - origin) unit in double precision, then rounded, and the lengths.
  void (*pack)(const StarTriangle* base, std::size_t size, const Vec3& origin, double unit, float* blocks);

  /// The same for the triangles of a ring of `count` points; `ring` is filled up by its last point.
  void (*pack_ring)(const RingPoints& ring, std::size_t count, const Vec3& origin, double unit,
                    float* blocks);

  /// Bit t is set if triangle t of a packed ring of `size` triangles has a positive volume with the apex `a`
  /// and, seen from behind, with the apex `b`: what has not has no score above 0 on one side.
  std::uint64_t (*find_positive)(const float* blocks, std::size_t size, const StarApex& a, const StarApex& b);

  /// Whether all tets are positive for certain: their volumes in single precision are above what rounding can
  /// have made of them, coordinates included. False says nothing.
  bool (*are_surely_positive)(const float* blocks, std::size_t size, const StarApex& apex);

  /// Scores of up to four triangles of a packed ring: four from in front with the apex `a`, then four from
  /// behind with `b`.
  void (*score_both)(const float* blocks, const StarApex& a, const StarApex& b, float* scores);

  /// Scores of all tets with the apex there, seen from in front or from behind.
  void (*score)(const float* blocks, std::size_t size, const StarApex& apex, float* scores);
  void (*score_from_behind)(const float* blocks, std::size_t size, const StarApex& apex, float* scores);

  /// Figures with the apex there, and scores as above. Ends early, with what it has, once the worst is below
  /// `bound`.
  StarFigures (*evaluate)(const float* blocks, std::size_t size, const StarApex& apex, float gain_offset,
                          float bound, float* scores);
};

/// For every processor.
extern const StarKernel kStarKernel;

/// With AVX2. Requires: has_avx2().
extern const StarKernel kStarKernelAvx2;

/// The better of both here.
const StarKernel& star_kernel();

}  // namespace palpate::simplify
