// Quality factors of many tets at once, rounded to a grid on which sums are exact.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "core/mesh/orientation.h"
#include "core/simplify/quality/quality.h"

namespace palpate::simplify {

/// Qualities are multiples of 2^-36, so that the sum of up to 2^16 of them is exact in any order.
inline double round_to_grid(double quality) {
  constexpr double kShift = 98304.0;  // 1.5 * 2^16, where doubles are 2^-36 apart
  return (quality + kShift) - kShift;
}

/// Tets to be measured, as arrays by corner and coordinate, and what was found.
struct TetBatch {
  static constexpr std::size_t kCapacity = 64;
  using Row = std::array<double, kCapacity>;

  std::size_t size = 0;
  alignas(64) std::array<std::array<Row, 3>, 4> corner;  ///< [corner][coordinate][tet]
  alignas(64) Row quality;                               ///< on the grid; 0 for what is not positive
  alignas(64) Row margin;  ///< > 0: the tet is surely positive; otherwise ask the exact predicate

  void add(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    const std::array<const Vec3*, 4> p{&a, &b, &c, &d};
    for (std::size_t k = 0; k < 4; ++k) {
      corner[k][0][size] = p[k]->x;
      corner[k][1][size] = p[k]->y;
      corner[k][2][size] = p[k]->z;
    }
    ++size;
  }
  Vec3 point(std::size_t k, std::size_t i) const {
    return {corner[k][0][i], corner[k][1][i], corner[k][2][i]};
  }
};

/// Fills `quality` and `margin` of the batch: the quality factor of quality.h to within 2^-36,
///
///   q = cbrt(shape [* min(1, volume / ideal_volume)]),  rounded to the grid
///
/// The same tet gives the same bits wherever it stands in a batch and whatever the processor.
void measure_batch(const QualityMetric& metric, double ideal_volume, TetBatch& batch);

/// Is tet i of a measured batch positive? Exact.
inline bool is_positive(const TetBatch& batch, std::size_t i) {
  return batch.margin[i] > 0.0 ||
         orientation(batch.point(0, i), batch.point(1, i), batch.point(2, i), batch.point(3, i)) > 0;
}

}  // namespace palpate::simplify
