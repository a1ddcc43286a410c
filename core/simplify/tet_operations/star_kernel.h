// The arithmetic of StarQuality, in two forms with the same bits: four tets at a time on every processor,
// eight with AVX2.
#pragma once

#include <array>
#include <cstddef>

#include "core/base/types.h"

namespace palpate::simplify {

/// Triangles of a block. A block has twelve rows of so many floats each: the coordinates ax ay az bx by bz cx
/// cy cz of the triangles' corners and the lengths of the edges bc, ca, ab.
inline constexpr std::size_t kBlockTriangles = 8;
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
  float inverse_six_ideal;  ///< 1 / (6 x the ideal volume)
  float dihedral_weight;
};

/// Figures of a set of tets.
struct StarFigures {
  double worst =
      0.0;           ///< least score; not above 0 if a tet is not positive, as far as single precision tells
  double sum = 0.0;  ///< sum of the gains
};

/// One form of the arithmetic. `blocks` has those of `size` triangles. `base` and `scores` have room for
/// whole blocks; what lies in `base` behind the last triangle repeats it.
struct StarKernel {
  /// Fills the blocks: (p - origin) unit in double precision, then rounded, and the lengths.
  void (*pack)(const StarTriangle* base, std::size_t size, const Vec3& origin, double unit, float* blocks);

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
