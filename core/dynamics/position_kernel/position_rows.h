// Where vertices stand in a sweep: rows of four numbers, displacement and inverse mass.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/large_pages.h"
#include "core/dynamics/elasticity/strain_operator.h"

namespace palpate::dynamics {

/// Four numbers a vertex: its displacement, and its inverse mass in 1/kg (of a vertex that is held along some
/// axes alone: not read). The row behind the last vertex is that of the padding: it stays zero.
using PositionRows = LargeVector<double>;

/// Numbers of a row.
inline constexpr std::size_t kRowNumbers = 4;

/// Rows of so many vertices and of the padding, all zero.
inline PositionRows make_rows(std::size_t vertices) {
  return PositionRows(kRowNumbers * (vertices + 1));
}

/// The displacement in row v.
inline Vec3 row_of(const PositionRows& rows, std::size_t v) {
  const double* const at = rows.data() + kRowNumbers * v;
  return {at[0], at[1], at[2]};
}

/// Sets the displacement in row v.
inline void set_row(PositionRows& rows, std::size_t v, const Vec3& u) {
  double* const at = rows.data() + kRowNumbers * v;
  at[0] = u.x;
  at[1] = u.y;
  at[2] = u.z;
}

/// displacement_gradient of the rows.
inline Mat3 gradient_of_rows(const StrainOperator& op, std::size_t domain, const PositionRows& rows) {
  Mat3 h;
  for (Index k = op.offsets[domain]; k < op.offsets[domain + 1]; ++k)
    add_outer(h, row_of(rows, op.vertices[k]), op.gradients[k]);
  return h;
}

/// What a sweep reads and moves.
struct SweptRows {
  double* now = nullptr;
  const double* before = nullptr;  ///< at the start of the step: read where there is damping
};

/// Which sweep of a step it is.
struct SweepOrder {
  bool is_first = false;  ///< all multipliers count as zero, whatever is stored
  bool is_backward = false;
  bool is_last = false;  ///< multipliers need not be stored: the step has no further sweep
};

/// How constraints are solved. All forms take the order of the colours; those in lanes give the same bits.
enum class PositionKernel : std::uint8_t {
  kBest,      ///< in lanes, with AVX2 where there is one
  kPortable,  ///< in lanes, without AVX2
  kSingle     ///< one at a time
};

}  // namespace palpate::dynamics
