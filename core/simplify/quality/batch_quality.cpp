#include "core/simplify/quality/batch_quality.h"

#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include <bit>
#include <cmath>
#include <limits>

// The loops are compiled a second time for wider vectors, chosen when the program starts. All operations are
// those of IEEE 754, uncontracted, so both give the same bits.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(PALPATE_SANITIZED)
#define PALPATE_WIDER_TOO __attribute__((target_clones("avx2", "default")))
#else
#define PALPATE_WIDER_TOO
#endif

namespace palpate::simplify {
namespace {

using Row = TetBatch::Row;
constexpr std::size_t kLanes = 4;  // the loops run over whole vectors; the lanes beyond the size are idle

/// What the stages hand on, by tet.
struct Work {
  alignas(64) std::array<Row, 6> edge;  ///< squared, then plain lengths: ab ac ad bc bd cd
  alignas(64) Row six_volume;
  alignas(64) std::array<Row, 4> denominator;
  alignas(64) Row largest;
  alignas(64) Row shortest;
  alignas(64) Row longest;
  alignas(64) Row shape;
};

inline double smaller(double a, double b) {
  return b < a ? b : a;
}
inline double larger(double a, double b) {
  return a < b ? b : a;
}

PALPATE_WIDER_TOO void find_edges(const TetBatch& __restrict batch, std::size_t end, Work& __restrict work) {
  const auto& p = batch.corner;
  for (std::size_t i = 0; i < end; ++i) {
    const double ux = p[1][0][i] - p[0][0][i];
    const double uy = p[1][1][i] - p[0][1][i];
    const double uz = p[1][2][i] - p[0][2][i];
    const double vx = p[2][0][i] - p[0][0][i];
    const double vy = p[2][1][i] - p[0][1][i];
    const double vz = p[2][2][i] - p[0][2][i];
    const double wx = p[3][0][i] - p[0][0][i];
    const double wy = p[3][1][i] - p[0][1][i];
    const double wz = p[3][2][i] - p[0][2][i];
    work.six_volume[i] = (uy * vz - uz * vy) * wx + (uz * vx - ux * vz) * wy + (ux * vy - uy * vx) * wz;
    work.edge[0][i] = ux * ux + uy * uy + uz * uz;
    work.edge[1][i] = vx * vx + vy * vy + vz * vz;
    work.edge[2][i] = wx * wx + wy * wy + wz * wz;
    work.edge[3][i] = (vx - ux) * (vx - ux) + (vy - uy) * (vy - uy) + (vz - uz) * (vz - uz);
    work.edge[4][i] = (wx - ux) * (wx - ux) + (wy - uy) * (wy - uy) + (wz - uz) * (wz - uz);
    work.edge[5][i] = (wx - vx) * (wx - vx) + (wy - vy) * (wy - vy) + (wz - vz) * (wz - vz);
  }
}

void take_roots(std::size_t end, Row& row) {
#ifdef __SSE2__
  for (std::size_t i = 0; i < end; i += 2) _mm_store_pd(&row[i], _mm_sqrt_pd(_mm_load_pd(&row[i])));
#else
  for (std::size_t i = 0; i < end; ++i) row[i] = std::sqrt(row[i]);
#endif
}

/// atan(x) / x for x^2 = s <= 0.09: Taylor's series, cut where 0.09^11 / 23 < 2^-42.
inline double arc_tangent_over(double s) {
  double sum = 1.0 / 21.0;
  sum = 1.0 / 19.0 - s * sum;
  sum = 1.0 / 17.0 - s * sum;
  sum = 1.0 / 15.0 - s * sum;
  sum = 1.0 / 13.0 - s * sum;
  sum = 1.0 / 11.0 - s * sum;
  sum = 1.0 / 9.0 - s * sum;
  sum = 1.0 / 7.0 - s * sum;
  sum = 1.0 / 5.0 - s * sum;
  sum = 1.0 / 3.0 - s * sum;
  return 1.0 - s * sum;
}

/// The denominators of the half solid angles' tangents, 6 V / denominator, one row a corner.
PALPATE_WIDER_TOO void find_denominators(std::size_t end, Work& work) {
  for (std::size_t i = 0; i < end; ++i) {
    const double ab = work.edge[0][i];
    const double ac = work.edge[1][i];
    const double ad = work.edge[2][i];
    const double bc = work.edge[3][i];
    const double bd = work.edge[4][i];
    const double cd = work.edge[5][i];
    const double ab2 = ab * ab;
    const double ac2 = ac * ac;
    const double ad2 = ad * ad;
    const double bc2 = bc * bc;
    const double bd2 = bd * bd;
    const double cd2 = cd * cd;
    work.denominator[0][i] =
        ab * ac * ad + 0.5 * ((ab2 + ac2 - bc2) * ad + (ac2 + ad2 - cd2) * ab + (ad2 + ab2 - bd2) * ac);
    work.denominator[1][i] =
        ab * bc * bd + 0.5 * ((ab2 + bc2 - ac2) * bd + (bc2 + bd2 - cd2) * ab + (bd2 + ab2 - ad2) * bc);
    work.denominator[2][i] =
        ac * bc * cd + 0.5 * ((ac2 + bc2 - ab2) * cd + (bc2 + cd2 - bd2) * ac + (cd2 + ac2 - ad2) * bc);
    work.denominator[3][i] =
        ad * bd * cd + 0.5 * ((ad2 + bd2 - ab2) * cd + (bd2 + cd2 - bc2) * ad + (cd2 + ad2 - ac2) * bd);
  }
}

/// Largest denominator, shortest and longest edge.
PALPATE_WIDER_TOO void find_extremes(std::size_t end, Work& work) {
  for (std::size_t i = 0; i < end; ++i) {
    work.largest[i] = larger(work.denominator[0][i], work.denominator[1][i]);
    work.shortest[i] = smaller(work.edge[0][i], work.edge[1][i]);
    work.longest[i] = larger(work.edge[0][i], work.edge[1][i]);
  }
  for (std::size_t k = 2; k < 4; ++k) {
    for (std::size_t i = 0; i < end; ++i) work.largest[i] = larger(work.largest[i], work.denominator[k][i]);
  }
  for (std::size_t k = 2; k < 6; ++k) {
    for (std::size_t i = 0; i < end; ++i) {
      work.shortest[i] = smaller(work.shortest[i], work.edge[k][i]);
      work.longest[i] = larger(work.longest[i], work.edge[k][i]);
    }
  }
}

/// thesis_shape; the least solid angle is at most 0.5513 sr, so its half's tangent at most 0.2829.
PALPATE_WIDER_TOO void find_thesis_shape(std::size_t end, Work& work) {
  constexpr double kTwiceOverIdeal = 2.0 / 0.55;
  constexpr double kTiny = std::numeric_limits<double>::min();  // a tet that is one point has no quotient
  for (std::size_t i = 0; i < end; ++i) {
    work.largest[i] = work.six_volume[i] / (work.largest[i] + kTiny);
    work.shape[i] = kTwiceOverIdeal * (work.shortest[i] / (work.longest[i] + kTiny));
  }
  for (std::size_t i = 0; i < end; ++i) work.largest[i] = larger(0.0, smaller(0.3, work.largest[i]));
  for (std::size_t i = 0; i < end; ++i) {
    const double tangent = work.largest[i];
    work.shape[i] *= tangent * arc_tangent_over(tangent * tangent);
  }
}

inline double halley_step(double y, double x) {
  const double cube = y * y * y;
  return y * ((cube + 2.0 * x) / (2.0 * cube + x));
}

/// Cube root of 0 <= x < 2^100: a third of the exponent gives it within 6%, and Halley's step turns an error
/// e into (2/3) e^3, so two leave less than 2^-40. 0 gives something below 2^-300.
inline double cube_root(double x) {
  const auto high = static_cast<std::int32_t>(std::bit_cast<std::uint64_t>(x) >> 32U);
  const std::int32_t guess = static_cast<std::int32_t>(static_cast<double>(high) * (1.0 / 3.0)) + 715094163;
  const auto y = std::bit_cast<double>(static_cast<std::uint64_t>(guess) << 32U);
  return halley_step(halley_step(y, x), x);
}

PALPATE_WIDER_TOO void find_quality(double volume_scale, std::size_t end, const Work& __restrict work,
                                    TetBatch& __restrict batch) {
  for (std::size_t i = 0; i < end; ++i) {
    const double factor = larger(0.0, smaller(1.0, work.six_volume[i] * volume_scale));
    const double cubed = work.shape[i] * factor;
    batch.quality[i] = round_to_grid(cube_root(cubed));
  }
}

/// The rounded 6 V is off by less than 40 * 2^-53 times the product of three edge lengths at a corner.
PALPATE_WIDER_TOO void find_margin(std::size_t end, const Work& __restrict work, TetBatch& __restrict batch) {
  for (std::size_t i = 0; i < end; ++i) {
    batch.margin[i] = work.six_volume[i] - 1e-14 * (work.edge[0][i] * work.edge[1][i] * work.edge[2][i]);
  }
}

}  // namespace

void measure_batch(const QualityMetric& metric, double ideal_volume, TetBatch& batch) {
  const std::size_t end = (batch.size + kLanes - 1) / kLanes * kLanes;
  for (std::size_t i = batch.size; i < end; ++i) {
    for (auto& corner : batch.corner) {
      for (Row& row : corner) row[i] = row[0];
    }
  }
  Work work;
  find_edges(batch, end, work);
  for (Row& row : work.edge) take_roots(end, row);
  find_margin(end, work, batch);
  if (metric.shape == thesis_shape) {
    find_denominators(end, work);
    find_extremes(end, work);
    find_thesis_shape(end, work);
  } else {
    for (std::size_t i = 0; i < end; ++i) {
      const Vec3 a = batch.point(0, i);
      const double six_volume = work.six_volume[i];
      work.shape[i] = six_volume > 0.0 ? metric.shape(batch.point(1, i) - a, batch.point(2, i) - a,
                                                      batch.point(3, i) - a, six_volume)
                                       : 0.0;
    }
  }
  const double volume_scale =
      metric.has_volume_factor ? 1.0 / (6.0 * ideal_volume) : std::numeric_limits<double>::max();
  find_quality(volume_scale, end, work, batch);
}

}  // namespace palpate::simplify
