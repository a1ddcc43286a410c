// The quality factor of a tet, as the simplifiers see it. (The judge measures with arithmetic of its own.)
#pragma once

#include "core/base/types.h"

namespace palpate::simplify {

/// What the simplifiers need to know of one tet.
struct TetFigures {
  bool is_positive = false;  ///< exact: the tet is positively oriented
  double shape = 0.0;        ///< product of the scale-free factors; 0 unless positive
  double volume = 0.0;       ///< in the mesh's unit cubed; 0 unless positive
};

/// A replaceable measure of shape: `shape` of a tet with edge vectors u = b - a, v = c - a, w = d - a and
/// six_volume = u x v . w > 0. Larger is better; it must not depend on the tet's size.
using ShapeFunction = double (*)(const Vec3& u, const Vec3& v, const Vec3& w, double six_volume);

/// A quality factor: the cube root of shape * min(1, volume / ideal volume).
struct QualityMetric {
  ShapeFunction shape = nullptr;
  bool has_volume_factor = true;  ///< without it the ideal volume plays no part
};

/// The thesis's metric (2.3.5): shape = (least solid angle / 0.55 sr) * (shortest edge / longest edge).
///
/// The solid angle at a vertex with edge vectors a, b, c is 2 atan2(6 V, |a||b||c| + (a.b)|c| + (b.c)|a| +
/// (c.a)|b|); 6 V is the same at all four, so the least angle belongs to the largest denominator. Source:
/// thesis 2.3.5 and 4.2.3; Van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 30 (1983).
double thesis_shape(const Vec3& u, const Vec3& v, const Vec3& w, double six_volume);

/// The mean ratio, 12 (3 V)^(2/3) / (sum of the squared edge lengths), cubed so that the cube root gives it
/// back. Source: Liu and Joe, BIT 34 (1994).
double mean_ratio_shape(const Vec3& u, const Vec3& v, const Vec3& w, double six_volume);

/// "thesis".
inline constexpr QualityMetric kThesisMetric{thesis_shape, true};
/// "mean_ratio".
inline constexpr QualityMetric kMeanRatioMetric{mean_ratio_shape, false};

/// The figures of tet (a, b, c, d); the sign is exact, shape and volume are rounded.
TetFigures measure_tet(const QualityMetric& metric, const Vec3& a, const Vec3& b, const Vec3& c,
                       const Vec3& d);

/// The same for a tet that is known to be positive.
TetFigures measure_positive_tet(const QualityMetric& metric, const Vec3& a, const Vec3& b, const Vec3& c,
                                const Vec3& d);

/// What tets are ordered and compared by: the cube of the quality factor times the ideal volume,
///
///   key = shape * min(volume, ideal_volume)
///
/// which needs neither a root nor a division and orders as the quality factor does.
inline double quality_key(const QualityMetric& metric, double shape, double volume, double ideal_volume) {
  if (!metric.has_volume_factor) return shape;
  return shape * (volume < ideal_volume ? volume : ideal_volume);
}

/// The quality factor itself, cbrt(key / ideal_volume) (or cbrt(shape) without a volume factor).
double quality_factor(const QualityMetric& metric, const TetFigures& figures, double ideal_volume);

}  // namespace palpate::simplify
