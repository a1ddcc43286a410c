// Rules of integration over tets and faces, in barycentric coordinates.
#pragma once

#include <array>
#include <vector>

#include "core/mesh/triangle_rule.h"

namespace palpate::reference {

/// A point of a rule over a tet, with its share of the volume; the shares sum to 1.
struct TetPoint {
  std::array<double, 4> at{};
  double weight = 0.0;
};

/// Gauss points over a tet, all inside and with positive weights: 1, 4 or 14 of them are exact for
/// polynomials of degree 1, 2 or 5. `subdivide` times the tet is split into eight equal parts with a rule of
/// their own each. (The rule of 11 points and degree 4 has a negative weight: a stiffness that it integrates
/// can be indefinite.) Throws: InputError for another count. Sources: P. Keast, Comput. Methods Appl. Mech.
/// Engrg. 55 (1986), 339-348; N. J. Walkington, Quadrature on simplices of arbitrary dimension (2000), 14
/// points.
std::vector<TetPoint> build_tet_rule(int points, int subdivide);

/// build_radon_rule over a face (degree 5); `subdivide` as above, into four.
std::vector<FacePoint> build_face_rule(int subdivide);

/// The middles of the six parts into which the medians cut a face, two at each corner: exact for degree 1 on
/// the part of each corner, which bounds its dual cell.
std::vector<FacePoint> build_dual_face_rule();

/// The corner whose dual cell point i of build_dual_face_rule bounds.
inline constexpr std::array<int, 6> kDualFaceCorner{0, 0, 1, 1, 2, 2};

}  // namespace palpate::reference
