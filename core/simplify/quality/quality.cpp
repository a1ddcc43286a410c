#include "core/simplify/quality/quality.h"

#include <algorithm>
#include <cmath>

#include "core/mesh/orientation.h"

namespace palpate::simplify {
namespace {

/// Solid angle that the thesis takes for the ideal one (a regular tet has 0.551286 sr).
constexpr double kIdealSolidAngleSr = 0.55;

}  // namespace

double thesis_shape(const Vec3& u, const Vec3& v, const Vec3& w, double six_volume) {
  const double uu = length_sq(u);
  const double vv = length_sq(v);
  const double ww = length_sq(w);
  const double uv = length_sq(v - u);
  const double uw = length_sq(w - u);
  const double vw = length_sq(w - v);
  const double shortest_sq = std::min({uu, vv, ww, uv, uw, vw});
  const double longest_sq = std::max({uu, vv, ww, uv, uw, vw});
  const double lu = std::sqrt(uu);
  const double lv = std::sqrt(vv);
  const double lw = std::sqrt(ww);
  const double luv = std::sqrt(uv);
  const double luw = std::sqrt(uw);
  const double lvw = std::sqrt(vw);
  // Each line: the three lengths at a vertex and the squares of the edges opposite to each pair.
  const auto denominator = [](double a, double b, double c, double aa, double bb, double cc, double ab,
                              double bc, double ca) {
    return a * b * c + 0.5 * ((aa + bb - ab) * c + (bb + cc - bc) * a + (cc + aa - ca) * b);
  };
  const double at_a = denominator(lu, lv, lw, uu, vv, ww, uv, vw, uw);
  const double at_b = denominator(lu, luv, luw, uu, uv, uw, vv, vw, ww);
  const double at_c = denominator(lv, luv, lvw, vv, uv, vw, uu, uw, ww);
  const double at_d = denominator(lw, luw, lvw, ww, uw, vw, uu, uv, vv);
  const double least_solid_angle = 2.0 * std::atan2(six_volume, std::max({at_a, at_b, at_c, at_d}));
  return least_solid_angle / kIdealSolidAngleSr * std::sqrt(shortest_sq / longest_sq);
}

double mean_ratio_shape(const Vec3& u, const Vec3& v, const Vec3& w, double six_volume) {
  const double sum =
      length_sq(u) + length_sq(v) + length_sq(w) + length_sq(v - u) + length_sq(w - u) + length_sq(w - v);
  const double half = 0.5 * six_volume;  // 3 V
  return 1728.0 * half * half / (sum * sum * sum);
}

TetFigures measure_tet(const QualityMetric& metric, const Vec3& a, const Vec3& b, const Vec3& c,
                       const Vec3& d) {
  return orientation(a, b, c, d) > 0 ? measure_positive_tet(metric, a, b, c, d) : TetFigures{};
}

TetFigures measure_positive_tet(const QualityMetric& metric, const Vec3& a, const Vec3& b, const Vec3& c,
                                const Vec3& d) {
  TetFigures figures;
  figures.is_positive = true;
  const Vec3 u = b - a;
  const Vec3 v = c - a;
  const Vec3 w = d - a;
  const double six_volume = dot(cross(u, v), w);
  if (!(six_volume > 0.0)) return figures;  // positive, but too flat for its rounded volume to show it
  figures.volume = six_volume / 6.0;
  figures.shape = metric.shape(u, v, w, six_volume);
  return figures;
}

double quality_factor(const QualityMetric& metric, const TetFigures& figures, double ideal_volume) {
  const double key = quality_key(metric, figures.shape, figures.volume, ideal_volume);
  return std::cbrt(metric.has_volume_factor ? key / ideal_volume : key);
}

}  // namespace palpate::simplify
