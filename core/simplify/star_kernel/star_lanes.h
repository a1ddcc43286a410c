// The body of both forms of StarKernel, whatever lanes are made of. A source that means an instruction set
// defines PALPATE_STAR_TARGET before it includes this: then each function here has it.
//
// Lanes (a type that follows) has: kWidth, 4 or 8; of, load, store; + - * /; min, max, sqrt;
// root_of_square(x, x x), the root of the latter; any_less, whether a < b in any lane; which_positive, a bit
// a lane; low and (of eight)
// high, four lanes of core/base/lanes.h; load_points(base, corner, origin, unit), the coordinates of that
// corner of kWidth triangles.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "core/base/lanes.h"
#include "core/simplify/star_kernel/star_kernel.h"

#ifndef PALPATE_STAR_TARGET
/// The instruction set that the including source compiles its lanes for; empty: that of the build.
#define PALPATE_STAR_TARGET
#endif
#ifdef __GNUC__
/// A function of lanes, which is never called but always put in place.
#define PALPATE_STAR_LANES PALPATE_STAR_TARGET __attribute__((always_inline)) inline
#else
/// A function of lanes.
#define PALPATE_STAR_LANES inline
#endif

namespace palpate::simplify {

/// Solid angle at a corner of the regular tet, as the thesis rounds it, sr.
inline constexpr float kIdealSolidAngleSr = 0.55F;
/// The mean ratio cubed is so many times the square of six volumes over the cube of the sum of squared edges.
inline constexpr float kMeanRatioCubed = 432.0F;

/// A vector of each lane.
template <typename Lanes>
struct LaneVec {
  Lanes x;
  Lanes y;
  Lanes z;

  PALPATE_STAR_LANES friend LaneVec operator+(const LaneVec& a, const LaneVec& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
  }
  PALPATE_STAR_LANES friend LaneVec operator-(const LaneVec& a, const LaneVec& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
  }
  PALPATE_STAR_LANES friend Lanes dot(const LaneVec& a, const LaneVec& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
  }
  PALPATE_STAR_LANES friend LaneVec cross(const LaneVec& a, const LaneVec& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
  }
  PALPATE_STAR_LANES static LaneVec load(const float* rows) {
    return {Lanes::load(rows), Lanes::load(rows + kBlockTriangles), Lanes::load(rows + 2 * kBlockTriangles)};
  }
};

/// The denominator of Van Oosterom and Strackee's formula at a corner: lengths of its edges, scalar products.
template <typename Lanes>
PALPATE_STAR_LANES Lanes solid_angle_denominator(const Lanes& a, const Lanes& b, const Lanes& c,
                                                 const Lanes& ab, const Lanes& bc, const Lanes& ca) {
  return a * b * c + ab * c + bc * a + ca * b;
}

/// Where the apex lies: in front of the triangles, behind them, or behind the second half of them only.
enum class SeenFrom { kFront, kBehind, kBoth };

/// The volumes with the sign that they have from there.
template <SeenFrom kSide, typename Lanes>
PALPATE_STAR_LANES Lanes seen_from(const Lanes& volume) {
  if constexpr (kSide == SeenFrom::kFront) {
    return volume;
  } else if constexpr (kSide == SeenFrom::kBehind) {
    return Lanes::of(0.0F) - volume;
  } else {
    return halves(volume, Lanes::of(0.0F) - volume);
  }
}

/// sin^2 of the dihedral angle farthest from 90 degrees. At the edge e of faces i and j it is
/// (6 V / |n_i|^2) (6 V / |n_j|^2) e^2. The normals are those of the faces at the apex, the squared lengths
/// those of its edges and, in the same order, of the edges across.
template <typename Lanes>
PALPATE_STAR_LANES Lanes least_sine_sq(const Lanes& six_volume, const LaneVec<Lanes>& normal_u,
                                       const LaneVec<Lanes>& normal_v, const LaneVec<Lanes>& normal_w,
                                       const LaneVec<Lanes>& at_apex, const LaneVec<Lanes>& across) {
  const LaneVec<Lanes> normal_p = normal_u + normal_v + normal_w;
  const Lanes at_u = six_volume / dot(normal_u, normal_u);
  const Lanes at_v = six_volume / dot(normal_v, normal_v);
  const Lanes at_w = six_volume / dot(normal_w, normal_w);
  const Lanes at_base = six_volume / dot(normal_p, normal_p);
  return min(min(min(at_apex.z * at_u * at_v, at_apex.y * at_u * at_w),
                 min(at_apex.x * at_v * at_w, across.x * at_u * at_base)),
             min(across.y * at_v * at_base, across.z * at_w * at_base));
}

/// Scores of the tets of a block, or of a part of it; see ScoreScale. u, v, w lead from the apex to the
/// base's vertices.
template <SeenFrom kSide, typename Lanes>
PALPATE_STAR_LANES Lanes score_at(const LaneVec<Lanes>& at, const StarApex& a, const float* rows) {
  constexpr std::size_t kRow = kBlockTriangles;
  const LaneVec<Lanes> u = LaneVec<Lanes>::load(rows) - at;
  const LaneVec<Lanes> v = LaneVec<Lanes>::load(rows + 3 * kRow) - at;
  const LaneVec<Lanes> w = LaneVec<Lanes>::load(rows + 6 * kRow) - at;
  const Lanes vw = Lanes::load(rows + 9 * kRow);
  const Lanes wu = Lanes::load(rows + 10 * kRow);
  const Lanes uv = Lanes::load(rows + 11 * kRow);
  const LaneVec<Lanes> normal_u = cross(v, w);
  const LaneVec<Lanes> normal_v = cross(w, u);
  const LaneVec<Lanes> normal_w = cross(u, v);
  const Lanes six_volume = seen_from<kSide>(dot(u, normal_u));
  const Lanes uu = dot(u, u);
  const Lanes vv = dot(v, v);
  const Lanes ww = dot(w, w);
  const LaneVec<Lanes> across{vw * vw, wu * wu, uv * uv};
  const Lanes sine_sq = least_sine_sq(six_volume, normal_u, normal_v, normal_w, {uu, vv, ww}, across);
  const Lanes angles = sine_sq * Lanes::of(a.dihedral_weight);
  const Lanes volume_factor = min(Lanes::of(1.0F), six_volume * Lanes::of(a.inverse_six_ideal));
  if (a.mean_ratio_weight > 0.0F) {
    // The mean ratio cubed is 432 (6 V)^2 / (sum of the squared edges)^3; the other factor has the sign.
    const Lanes squares = uu + vv + ww + (across.x + across.y + across.z);
    const Lanes ratio = six_volume / squares;
    const Lanes cube =
        ratio * ratio / squares * Lanes::of(kMeanRatioCubed * a.mean_ratio_weight) * volume_factor;
    // What underflows is 0, never -0: the least of several would depend on the width.
    return max(min(cube, angles), Lanes::of(kWorstScore)) + Lanes::of(0.0F);
  }
  const Lanes lu = sqrt(uu);
  const Lanes lv = sqrt(vv);
  const Lanes lw = sqrt(ww);
  // Scalar products at the apex, from which those at the other corners follow.
  const Lanes u_v = dot(u, v);
  const Lanes v_w = dot(v, w);
  const Lanes w_u = dot(w, u);
  const Lanes at_p = solid_angle_denominator(lu, lv, lw, u_v, v_w, w_u);
  const Lanes at_a = solid_angle_denominator(lu, uv, wu, uu - u_v, uu - u_v + v_w - w_u, uu - w_u);
  const Lanes at_b = solid_angle_denominator(lv, vw, uv, vv - v_w, vv - v_w + w_u - u_v, vv - u_v);
  const Lanes at_c = solid_angle_denominator(lw, wu, vw, ww - w_u, ww - w_u + u_v - v_w, ww - v_w);
  const Lanes x = six_volume / max(max(at_p, at_a), max(at_b, at_c));
  const Lanes xx = x * x;
  const Lanes series =
      Lanes::of(1.0F) - xx * (Lanes::of(1.0F / 3.0F) - xx * (Lanes::of(0.2F) - xx * Lanes::of(1.0F / 7.0F)));
  const Lanes shortest = min(min(min(lu, lv), min(lw, vw)), min(wu, uv));
  const Lanes longest = max(max(max(lu, lv), max(lw, vw)), max(wu, uv));
  // The magnitude of x: a product of two negative factors must not look positive.
  const Lanes cube = root_of_square(x, xx) * series * Lanes::of(2.0F / kIdealSolidAngleSr) *
                     (shortest / longest) * volume_factor;
  return max(min(cube, angles), Lanes::of(kWorstScore));
}

/// Fills the rows of triangles (a, b, c).
template <typename Lanes>
PALPATE_STAR_LANES void store_triangles(const LaneVec<Lanes>& a, const LaneVec<Lanes>& b,
                                        const LaneVec<Lanes>& c, float* rows) {
  constexpr std::size_t kRow = kBlockTriangles;
  a.x.store(rows);
  a.y.store(rows + kRow);
  a.z.store(rows + 2 * kRow);
  b.x.store(rows + 3 * kRow);
  b.y.store(rows + 4 * kRow);
  b.z.store(rows + 5 * kRow);
  c.x.store(rows + 6 * kRow);
  c.y.store(rows + 7 * kRow);
  c.z.store(rows + 8 * kRow);
  sqrt(dot(c - b, c - b)).store(rows + 9 * kRow);
  sqrt(dot(a - c, a - c)).store(rows + 10 * kRow);
  sqrt(dot(b - a, b - a)).store(rows + 11 * kRow);
}

/// Scores of the tets of an apex on the triangles at `rows`, a lane each.
template <SeenFrom kSide, typename Lanes>
PALPATE_STAR_LANES Lanes score_lanes(const StarApex& a, const float* rows) {
  return score_at<kSide, Lanes>({Lanes::of(a.x), Lanes::of(a.y), Lanes::of(a.z)}, a, rows);
}

/// Packs `size` triangles into blocks, relative to `origin` and in `unit`.
template <typename Lanes>
PALPATE_STAR_LANES void pack_lanes(const StarTriangle* base, std::size_t size, const Vec3& origin,
                                   double unit, float* blocks) {
  constexpr std::size_t kRow = kBlockTriangles;
  for (std::size_t i = 0; i < size; i += Lanes::kWidth) {
    store_triangles(
        Lanes::load_points(base + i, 0, origin, unit), Lanes::load_points(base + i, 1, origin, unit),
        Lanes::load_points(base + i, 2, origin, unit), blocks + kBlockFloats * (i / kRow) + i % kRow);
  }
}

/// Scores of `size` tets, one behind the other.
template <SeenFrom kSide, typename Lanes>
PALPATE_STAR_LANES void score_all_lanes(const float* blocks, std::size_t size, const StarApex& apex,
                                        float* scores) {
  for (std::size_t i = 0; i < size; i += Lanes::kWidth) {
    const float* const rows = blocks + kBlockFloats * (i / kBlockTriangles) + i % kBlockTriangles;
    score_lanes<kSide, Lanes>(apex, rows).store(scores + i);
  }
}

/// Six volumes of the tets of a block, as score_lanes computes them.
template <typename Lanes>
PALPATE_STAR_LANES Lanes six_volume_lanes(const StarApex& a, const float* rows) {
  const LaneVec<Lanes> at{Lanes::of(a.x), Lanes::of(a.y), Lanes::of(a.z)};
  const LaneVec<Lanes> u = LaneVec<Lanes>::load(rows) - at;
  const LaneVec<Lanes> v = LaneVec<Lanes>::load(rows + 3 * kBlockTriangles) - at;
  const LaneVec<Lanes> w = LaneVec<Lanes>::load(rows + 6 * kBlockTriangles) - at;
  return dot(u, cross(v, w));
}

/// Which of `size` triangles have apex a in front and apex b behind: bit i for triangle i.
template <typename Lanes>
PALPATE_STAR_LANES std::uint64_t find_positive_lanes(const float* blocks, std::size_t size, const StarApex& a,
                                                     const StarApex& b) {
  std::uint64_t positive = 0;
  for (std::size_t i = 0; i < size; i += Lanes::kWidth) {
    const float* const rows = blocks + kBlockFloats * (i / kBlockTriangles) + i % kBlockTriangles;
    const Lanes front = six_volume_lanes<Lanes>(a, rows);
    const Lanes behind = Lanes::of(0.0F) - six_volume_lanes<Lanes>(b, rows);
    positive |= std::uint64_t{which_positive(front) & which_positive(behind)} << i;
  }
  return positive & ((std::uint64_t{1} << size) - 1U);
}

/// The greatest magnitude of the coordinates of a block's triangles, or `most` if that is more.
template <typename Lanes>
PALPATE_STAR_LANES Lanes greatest_coordinate(const float* rows, Lanes most) {
  for (std::size_t row = 0; row < 9; ++row) {
    const Lanes x = Lanes::load(rows + row * kBlockTriangles);
    most = max(most, max(x, Lanes::of(0.0F) - x));
  }
  return most;
}

/// Whether all of `size` tets are positive whatever rounding has done.
///
/// With M the greatest coordinate and e = 2^-24: a coordinate is off by e M at most, a difference of two, at
/// most 2 M, by 4 e M, a component of the cross product, at most 8 M^2, by 48 e M^2, and the volume's six
/// parts together by 513 e M^3, all to first order in e. Twice that is asked for. What underflows is far
/// below that within the limits on M.
template <typename Lanes>
PALPATE_STAR_LANES bool are_surely_positive_lanes(const float* blocks, std::size_t size,
                                                  const StarApex& apex) {
  constexpr float kLeastCoordinate = 1e-6F;
  constexpr float kGreatestCoordinate = 1e9F;
  constexpr float kError = 1024.0F / 16777216.0F;
  Lanes least = Lanes::of(std::numeric_limits<float>::max());
  Lanes most = Lanes::of(std::max({std::fabs(apex.x), std::fabs(apex.y), std::fabs(apex.z)}));
  for (std::size_t i = 0; i < size; i += Lanes::kWidth) {
    const float* const rows = blocks + kBlockFloats * (i / kBlockTriangles) + i % kBlockTriangles;
    most = greatest_coordinate(rows, most);
    least = min(least, six_volume_lanes<Lanes>(apex, rows));
  }
  std::array<float, 8> volumes{};
  std::array<float, 8> coordinates{};
  least.store(volumes.data());
  most.store(coordinates.data());
  float volume = volumes[0];
  float m = coordinates[0];
  for (std::size_t k = 1; k < Lanes::kWidth; ++k) {
    volume = std::min(volume, volumes[k]);
    m = std::max(m, coordinates[k]);
  }
  // Within the limits nothing has overflowed, so no volume was lost for being no number.
  return m > kLeastCoordinate && m < kGreatestCoordinate && volume > kError * m * m * m;
}

/// The gains of four tets, of which `left` count: the sum of each lane where all do, else one after another.
template <typename Four>
PALPATE_STAR_LANES void add_gains(const Four& gain, std::size_t left, Four& lanes, double& rest) {
  if (left >= 4) {
    lanes = lanes + gain;
    return;
  }
  std::array<float, 4> out{};
  gain.store(out.data());
  for (std::size_t k = 0; k < left; ++k) rest += double{out[k]};
}

/// Least score and sum of gains, -1 / (score + gain_offset), of `size` tets, whose scores are written to
/// `scores`; given up where one is below `bound`.
template <typename Lanes>
PALPATE_STAR_LANES StarFigures evaluate_lanes(const float* blocks, std::size_t size, const StarApex& apex,
                                              float gain_offset, float bound, float* scores) {
  using Four = decltype(Lanes::of(0.0F).low());
  const Lanes limit = Lanes::of(bound);
  const Lanes offset = Lanes::of(gain_offset);
  Lanes worst = Lanes::of(std::numeric_limits<float>::max());
  Four sum = Four::of(0.0F);
  StarFigures figures;
  for (std::size_t i = 0; i < size; i += Lanes::kWidth) {
    const float* const rows = blocks + kBlockFloats * (i / kBlockTriangles) + i % kBlockTriangles;
    const Lanes score = score_lanes<SeenFrom::kFront, Lanes>(apex, rows);
    score.store(scores + i);
    worst = min(worst, score);
    if (any_less(worst, limit)) break;
    const Lanes gain = Lanes::of(-1.0F) / (max(score, Lanes::of(0.0F)) + offset);
    add_gains(gain.low(), size - i, sum, figures.sum);
    if constexpr (Lanes::kWidth == 8) {
      if (size - i > 4) add_gains(gain.high(), size - i - 4, sum, figures.sum);
    }
  }
  std::array<float, 8> out{};
  sum.store(out.data());
  for (std::size_t k = 0; k < 4; ++k) figures.sum += double{out[k]};
  worst.store(out.data());
  float least = out[0];
  for (std::size_t k = 1; k < Lanes::kWidth; ++k) least = std::min(least, out[k]);
  figures.worst = double{least};
  return figures;
}

}  // namespace palpate::simplify
