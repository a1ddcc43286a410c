// Vectors and matrices of eight domains, whatever eight numbers are made of. A source that means an
// instruction set defines PALPATE_LANES_TARGET before it includes this: then each function here has it.
//
// Eight (a type that follows) has: Number; of, load, store; + - * /; any_less(a, b), whether a < b in any
// lane; load_rows(rows, at), the first three numbers of the rows at eight places; add_rows(rows, at, what),
// which adds to them, lane after lane. Doubles also have: min, max, sqrt (core/base/lanes.h); load_whole_rows
// and store_whole_rows, all four numbers of the rows.
#pragma once

#include <array>

#ifndef PALPATE_LANES_TARGET
/// The instruction set that the including source compiles its lanes for; empty: that of the build.
#define PALPATE_LANES_TARGET
#endif
#ifdef __GNUC__
/// A function of lanes, which is never called but always put in place.
#define PALPATE_LANES PALPATE_LANES_TARGET __attribute__((always_inline)) inline
#else
/// A function of lanes.
#define PALPATE_LANES inline
#endif

namespace palpate::dynamics {

/// A vector of each of eight domains.
template <typename Eight>
struct Vec3Lanes {
  Eight x;
  Eight y;
  Eight z;
};

/// A row of four numbers of each of eight: a vector and one more.
template <typename Eight>
struct RowLanes {
  Vec3Lanes<Eight> xyz;
  Eight w;
};

/// A matrix of each of eight domains, by rows.
template <typename Eight>
using Mat3Lanes = std::array<Eight, 9>;

/// (a0 b0 + a1 b1) + a2 b2.
template <typename Eight>
PALPATE_LANES Eight dot_lanes(const Eight& a0, const Eight& b0, const Eight& a1, const Eight& b1,
                              const Eight& a2, const Eight& b2) {
  return (a0 * b0 + a1 * b1) + a2 * b2;
}

/// a b.
template <typename Eight>
PALPATE_LANES Mat3Lanes<Eight> multiply_lanes(const Mat3Lanes<Eight>& a, const Mat3Lanes<Eight>& b) {
  return {dot_lanes(a[0], b[0], a[1], b[3], a[2], b[6]), dot_lanes(a[0], b[1], a[1], b[4], a[2], b[7]),
          dot_lanes(a[0], b[2], a[1], b[5], a[2], b[8]), dot_lanes(a[3], b[0], a[4], b[3], a[5], b[6]),
          dot_lanes(a[3], b[1], a[4], b[4], a[5], b[7]), dot_lanes(a[3], b[2], a[4], b[5], a[5], b[8]),
          dot_lanes(a[6], b[0], a[7], b[3], a[8], b[6]), dot_lanes(a[6], b[1], a[7], b[4], a[8], b[7]),
          dot_lanes(a[6], b[2], a[7], b[5], a[8], b[8])};
}

/// a^T.
template <typename Eight>
PALPATE_LANES Mat3Lanes<Eight> transpose_lanes(const Mat3Lanes<Eight>& a) {
  return {a[0], a[3], a[6], a[1], a[4], a[7], a[2], a[5], a[8]};
}

/// det(a) a^-T.
template <typename Eight>
PALPATE_LANES Mat3Lanes<Eight> cofactor_lanes(const Mat3Lanes<Eight>& a) {
  return {a[4] * a[8] - a[5] * a[7], a[5] * a[6] - a[3] * a[8], a[3] * a[7] - a[4] * a[6],
          a[2] * a[7] - a[1] * a[8], a[0] * a[8] - a[2] * a[6], a[1] * a[6] - a[0] * a[7],
          a[1] * a[5] - a[2] * a[4], a[2] * a[3] - a[0] * a[5], a[0] * a[4] - a[1] * a[3]};
}

/// The six entries xx, yy, zz, yz, xz, xy of a symmetric matrix.
template <typename Eight>
struct SymmetricLanes {
  Eight xx;
  Eight yy;
  Eight zz;
  Eight yz;
  Eight xz;
  Eight xy;
};

/// s v.
template <typename Eight>
PALPATE_LANES Vec3Lanes<Eight> multiply_lanes(const SymmetricLanes<Eight>& s, const Vec3Lanes<Eight>& v) {
  return {dot_lanes(s.xx, v.x, s.xy, v.y, s.xz, v.z), dot_lanes(s.xy, v.x, s.yy, v.y, s.yz, v.z),
          dot_lanes(s.xz, v.x, s.yz, v.y, s.zz, v.z)};
}

}  // namespace palpate::dynamics
