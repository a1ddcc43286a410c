// Shape and volume of one tetrahedron, written independently of the simplifiers' formulas.
#pragma once

#include <span>

#include "core/mesh/tet_mesh.h"

namespace palpate::judge {

/// value * 2^exponent: a volume that fits no double may still be compared with its like.
struct ScaledVolume {
  double value = 0.0;
  int exponent = 0;  ///< 0 unless the tet is tiny or huge

  /// The volume in units of 2^(3 length_exponent).
  double in_units_of(int length_exponent) const;
};

/// Signed volume (b - a) x (c - a) . (d - a) / 6; 0 if a vertex is not finite. Its sign is that of the
/// rounded determinant.
ScaledVolume measure_volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// Angles, edges and volume of one tet.
struct TetShape {
  bool is_positive = false;      ///< by exact orientation
  ScaledVolume volume;           ///< signed; its sign is never against the exact orientation
  double edge_ratio = 0.0;       ///< shortest / longest edge
  double min_solid_angle = 0.0;  ///< steradians
  double min_dihedral = 0.0;     ///< radians, interior
  double max_dihedral = 0.0;     ///< radians, interior
  double mean_ratio = 0.0;       ///< 12 (3 V)^(2/3) / sum of the squared edges; 1 for a regular tet alone
  double radius_ratio = 0.0;     ///< 3 inradius / circumradius; 1 for a regular tet alone
};

/// Measures a tet.
///
///   dihedral angle at edge e, between the faces with the outward area vectors m and n:
///     atan2(6 V |e|, -4 m . n)
///   solid angle at a vertex: the sum of the three dihedral angles there - pi (thesis eq. 4.2). Where that is
///     below 10^-3 sr and cancels: C the least of the three dihedral angles, A and B the face angles beside
///     it, tan(angle / 2) = t sin C / (1 + t cos C),  t = tan(A / 2) tan(B / 2); C < 90 degrees there, so no
///     term is negative and nothing cancels.
///   mean ratio: 12 (3 V)^(2/3) / sum over the six edges of l^2 (Liu and Joe, BIT 34 (1994))
///   radius ratio: 3 r / R, r = 3 V / (sum of the face areas), and for edges a, b, c from one vertex
///     R = | a^2 (b x c) + b^2 (c x a) + c^2 (a x b) | / (12 V).  The sum cancels in a sliver whose vertices
///     are close to one circle: the ratio then has an error of a few roundings of 1, not of itself.
///
/// A tet that is not positive has both ratios 0 and all angles 0 except the greatest dihedral angle, pi; it
/// keeps its signed volume and its edge ratio. A tet with a non-finite vertex has volume and edge ratio 0 as
/// well. All results are finite whatever the coordinates: powers of two keep the products in range.
TetShape measure_tet(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// The power of two to sum a mesh's volumes by: 0 unless the coordinates are beyond 2^+-300.
int length_exponent(std::span<const Vec3> points);

/// Sum of the signed volumes of the tets with valid indices and finite vertices, compensated, in units of
/// 2^(3 length_exponent).
double sum_volumes(const TetMesh& mesh, int length_exponent);

/// value * 2^(3 length_exponent), the largest double of that sign if it fits none.
double unscaled_volume(double value, int length_exponent);

}  // namespace palpate::judge
